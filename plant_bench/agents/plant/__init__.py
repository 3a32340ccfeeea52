"""PlanT: a transformer over objects (Renz et al., CoRL 2022). Importing `agent` needs no torch."""
