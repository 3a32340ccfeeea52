"""What data is asked for, and the unit it is counted in."""

import shlex
from dataclasses import dataclass

from plant_bench.agents.loading.planner_spec import without_folders
from plant_bench.errors import InputError

UNIT = 228_000  # frames at 2 Hz: 1x of PlanT (section 4)
FRAME_TICKS = 10  # 2 Hz


@dataclass(frozen=True)
class CollectRequest:
    """What data is asked for.

    Attributes:
        frames: Samples at 2 Hz, at least.
        seed: The base seed: of routes, traffic and perturbations.
        density: Of the traffic.
        perturb: Share of episodes with perturbations, 0 to 1.
        driver: Who drives while the expert answers; empty if the expert drives.
    """

    frames: int
    seed: int = 0
    density: str = "dense"
    perturb: float = 0.0
    driver: str = ""

    def command(self, out: str) -> str:
        """Return the command that collects this into a folder; see `without_folders`."""
        parts = ["plant-bench", "collect", "--out", out]
        parts += ["--frames", str(self.frames)] if self.frames else []  # where nobody knows
        parts += ["--seed", str(self.seed), "--density", self.density]
        parts += ["--perturb", f"{self.perturb:g}"] if self.perturb else []
        parts += ["--driver", self.driver] if self.driver else []
        return shlex.join(map(without_folders, parts))

    def check(self) -> None:
        """Check the numbers.

        Raises:
            InputError: What was found, and what is wanted.
        """
        if self.frames < 1:
            message = f"frames: expected at least 1, got {self.frames}."
            raise InputError(message)
        if self.driver and self.perturb:
            message = "--driver and --perturb both change what is driven: give one of them."
            raise InputError(message)
        if not 0.0 <= self.perturb <= 1.0:
            message = f"--perturb: expected a fraction of episodes, 0 to 1, got {self.perturb:g}."
            raise InputError(message)
