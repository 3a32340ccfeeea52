"""Every error that plant-bench raises on purpose.

PlantBenchError
├── InputError        what the user gave cannot be used; the command line exits with code 2
├── AgentError        a planner raised, or returned something that is not a plan or a control
└── SimulationError   SUMO failed in a way that no input explains
"""


class PlantBenchError(Exception):
    """Base of all errors raised by plant-bench."""


class InputError(PlantBenchError):
    """Raised when input is unusable: says what was found, what was wanted and what to do."""


class AgentError(PlantBenchError):
    """Raised when a planner fails; it ends that planner's episode and nothing else."""


class SimulationError(PlantBenchError):
    """Raised when the simulator fails or loses the ego vehicle."""
