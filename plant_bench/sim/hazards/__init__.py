"""Hazards in motion: one short module a kind, behind the protocol in `script`."""
