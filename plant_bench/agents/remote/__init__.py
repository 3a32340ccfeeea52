"""Planners in separate processes: the protocol, its client and server, and process supervision."""
