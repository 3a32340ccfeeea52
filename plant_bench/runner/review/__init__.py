"""Episodes simulated again: resimulation, verification, explanations."""
