"""Replays: recordings as browser pages, images, GIFs and videos."""
