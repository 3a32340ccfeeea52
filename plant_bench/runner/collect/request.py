"""The request of a data collection, with its command line and checks."""

import shlex
from dataclasses import dataclass

from plant_bench.agents.loading.planner_spec import without_folders
from plant_bench.errors import InputError

UNIT = 228_000  # frames at 2 Hz: 1x of PlanT (section 4)
FRAME_TICKS = 10  # 2 Hz


@dataclass(frozen=True)
class CollectRequest:
    """The requested data.

    Attributes:
        frames: Minimum number of samples at 2 Hz.
        seed: Base seed of routes, traffic and perturbations.
        density: Traffic density.
        perturb: Fraction of episodes with perturbations, 0 to 1.
        driver: Planner whose actions are executed while the expert's are recorded; empty for the
            expert itself.
    """

    frames: int
    seed: int = 0
    density: str = "dense"
    perturb: float = 0.0
    driver: str = ""

    def command(self, out: str) -> str:
        """Return the command line that collects this data, without private folders."""
        parts = ["plant-bench", "collect", "--out", out]
        parts += ["--frames", str(self.frames)] if self.frames else []  # 0 if unknown
        parts += ["--seed", str(self.seed), "--density", self.density]
        parts += ["--perturb", f"{self.perturb:g}"] if self.perturb else []
        parts += ["--driver", self.driver] if self.driver else []
        return shlex.join(map(without_folders, parts))

    def check(self) -> None:
        """Check the values.

        Raises:
            InputError: A value is invalid.
        """
        if self.frames < 1:
            message = f"frames: expected at least 1, got {self.frames}."
            raise InputError(message)
        if self.driver and self.perturb:
            message = "--driver and --perturb exclude each other: both change the executed control."
            raise InputError(message)
        if not 0.0 <= self.perturb <= 1.0:
            message = f"--perturb: expected a fraction of episodes, 0 to 1, got {self.perturb:g}."
            raise InputError(message)
