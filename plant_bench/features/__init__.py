"""What learned planners are told: observations as numbers. No torch."""
