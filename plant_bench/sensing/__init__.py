"""What planners are given: observations made of scenes."""
