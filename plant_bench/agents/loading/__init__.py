"""Planners found by name, module, file or command, and what they are made of."""
