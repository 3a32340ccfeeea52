"""Poses, boxes and polylines: numpy only, no state. Frames and units are in docs/conventions.md."""
