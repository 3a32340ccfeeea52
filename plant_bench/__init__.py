"""plant-bench: a lightweight closed-loop benchmark for driving planners, on SUMO."""

__version__ = "0.1.0"
