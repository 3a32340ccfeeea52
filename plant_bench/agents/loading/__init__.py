"""Finds and loads planners by name, module, file or command, and computes their checksums."""
