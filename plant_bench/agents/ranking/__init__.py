"""Which actors matter to a planner: rankers, and the expert that is shown the top-ranked only."""
