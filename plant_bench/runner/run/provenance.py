"""Provenance of a run: settings, checksums and versions needed to reproduce it."""

import platform
import shlex
import sys
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from pydantic import BaseModel, ConfigDict, Field

from plant_bench import __version__
from plant_bench.agents.loading.planner_spec import without_folders
from plant_bench.errors import InputError, in_one_line
from plant_bench.scoring.results import MOST_REPETITIONS
from plant_bench.towns.importing.carla_sources import carla_routes
from plant_bench.untrusted_files import read_text
from plant_bench.world.route import NO_HAZARDS_PROTOCOL, PROTOCOL, Route

RUN_FORMAT = 1
_PACKAGES = ("libsumo", "eclipse-sumo", "numpy", "numba", "pyarrow", "torch")


class Provenance(BaseModel):
    """`run.json`.

    Attributes:
        format: Version of this record.
        agent: The agent as named by the user.
        agent_checksum: Content hash of the agent's code and weights.
        suite: Name of the suite, or the path it was read from.
        seed: The base seed; each episode's own seed is in its record.
        density: Traffic density.
        hazards: Whether the routes' hazards are enabled.
        protocol: Name and version of the rules.
        towns: Checksum of each town.
        routes: Checksum of each route of the suite.
        repetitions: Repetitions requested by the last command.
        command: The last command.
        versions: Versions of all software that can change a result.
        processor: Name of the processor; timings depend on it, scores do not.
        carla_routes: For a suite imported from CARLA, the id and the town of each route there.
    """

    model_config = ConfigDict(frozen=True, extra="ignore")

    format: int = RUN_FORMAT
    agent: str
    agent_checksum: str
    suite: str
    seed: int
    density: str
    hazards: bool = False
    protocol: str
    towns: dict[str, str]
    routes: dict[str, str]
    repetitions: int = Field(ge=0, le=MOST_REPETITIONS)
    command: str
    versions: dict[str, str]
    processor: str
    carla_routes: dict[str, tuple[str, str]] = {}

    @property
    def identity(self) -> list[tuple[str, object]]:
        """Settings that all episodes of a folder share; the agent's version may change."""
        names = ("agent", "suite", "seed", "density", "hazards")
        return [(name, getattr(self, name)) for name in names]

    @classmethod
    def load(cls, path: Path) -> "Provenance":
        """Read a `run.json`.

        Raises:
            InputError: The file is missing or broken.
        """
        try:
            return cls.model_validate_json(read_text(path))
        except (OSError, ValueError) as error:
            message = (
                f"{path.parent} is not a run of plant-bench: cannot read {path.name} "
                f"({in_one_line(error)})."
            )
            raise InputError(message) from error


def provenance(
    agent: str,
    agent_checksum: str,
    routes: list[Route],
    *,
    suite: str,
    seed: int,
    density: str,
    hazards: bool,
    repetitions: int,
) -> Provenance:
    """Return the provenance of a run that is about to start here."""
    towns = {route.town: route for route in routes}
    return Provenance(
        agent=agent,
        agent_checksum=agent_checksum,
        suite=suite,
        seed=seed,
        density=density,
        hazards=hazards,
        protocol=PROTOCOL if hazards else NO_HAZARDS_PROTOCOL,
        towns={name: route.town_checksum for name, route in sorted(towns.items())},
        routes={route.id: route.checksum for route in routes},
        repetitions=repetitions,
        command=shlex.join([Path(sys.argv[0]).name, *sys.argv[1:]]),
        versions=installed_versions(),
        processor=processor_name(),
        carla_routes=carla_routes(suite),
    )


def command_line() -> str:
    """Return the current command for publication, without private folders (`without_folders`)."""
    return shlex.join(map(without_folders, [Path(sys.argv[0]).name, *sys.argv[1:]]))


def installed_versions() -> dict[str, str]:
    """Return the versions of plant-bench, Python and the packages that can change results."""
    versions = {"plant-bench": __version__, "python": platform.python_version()}
    for package in _PACKAGES:
        try:
            versions[package] = version(package)
        except PackageNotFoundError:
            versions[package] = "not installed"
    return versions


def processor_name() -> str:
    """Return the processor's name as reported by the system."""
    try:
        text = Path("/proc/cpuinfo").read_text(encoding="utf-8")
    except OSError:
        return platform.processor() or platform.machine()
    names = [line.partition(":")[2].strip() for line in text.splitlines() if "model name" in line]
    return names[0] if names else platform.machine()
