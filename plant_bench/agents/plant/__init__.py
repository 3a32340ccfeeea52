"""PlanT: a transformer over objects (Renz et al., CoRL 2022). `agent` needs no torch to import."""
