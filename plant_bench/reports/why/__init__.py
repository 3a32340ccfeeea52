"""`plant-bench why`: explains the infractions of an episode as text and as a figure."""
