"""Features for learned planners: observations as numeric arrays. Needs no torch."""
