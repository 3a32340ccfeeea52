"""The drivers: one planner, one file; they know neither SUMO nor the score."""
