"""Planners in processes of their own: the protocol, both its ends, and who watches the process."""
