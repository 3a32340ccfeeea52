"""A run on disk: what was asked for, records, locks, summary, provenance."""
