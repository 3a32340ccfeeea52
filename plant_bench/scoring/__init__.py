"""The rules: what is an infraction, what it costs, when an episode ends, what a run scores."""
