"""The Python API: the commands as functions that return values and print nothing."""
