"""Hazard behaviours: one module per kind or family, with the protocol in `behaviour`."""
