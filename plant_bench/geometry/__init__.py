"""Geometry of poses, oriented boxes and polylines; frames and units: docs/notes/conventions.md."""
