"""The built-in planners, one file or folder each; they depend on neither SUMO nor scoring."""
