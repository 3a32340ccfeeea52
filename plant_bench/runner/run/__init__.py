"""A run on disk: request, records, lock, summary, provenance."""
