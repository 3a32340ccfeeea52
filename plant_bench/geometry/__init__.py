"""Poses, boxes and polylines: numpy only, no state. Frames, units: docs/notes/conventions.md."""
