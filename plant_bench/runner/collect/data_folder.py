"""The folder of collected data: one recording an episode, the routes, and all that is derived.

collect.json: what was asked for and what it is made with (`Origin`).
routes/<town>.json: the routes of a town, a suite file; "visits" tells which are driven together.
towns/<town>/: further towns; the benchmark's own are not copied.
episodes/<route>_r<repetition>_<key>.parquet: a thinned recording (`data.recording`).
records/<the same>.json: how the episode ended (`EpisodeNote`), also of those left out of the data.
data.json, README.md: derived; a summary, and the data card.
unfinished/, logs/: what is being written, and what the workers printed.
"""

from dataclasses import dataclass
from pathlib import Path

from pydantic import BaseModel, ConfigDict

from plant_bench.atomic_files import UNFINISHED
from plant_bench.errors import InputError
from plant_bench.runner.run.folder import RunFolder
from plant_bench.towns.routes import suite_text
from plant_bench.untrusted_files import read_json, read_text
from plant_bench.world.route import Route, load_suite

_PARTS = ("episodes", "records", "routes", "towns", "unfinished", "logs")


class Origin(BaseModel):
    """What all episodes of a folder have in common; only the number of frames may grow.

    Attributes:
        seed: The base seed.
        density: Of the traffic.
        perturb: Share of episodes with perturbations.
        protocol: The rules.
        agent: Who answered, and drove unless there is a driver.
        agent_checksum: Content hash of the agent's code.
        driver: Who drove while the agent answered; empty if it was the agent.
        driver_checksum: Content hash of the driver's code and weights.
        rules: Content hash of the code that moves and judges the world.
        collecting: Content hash of what else decides the drives; empty in folders of earlier days,
            which can be read but not added to.
        versions: Of everything that could change a number.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    seed: int
    density: str
    perturb: float
    protocol: str
    agent: str
    agent_checksum: str
    driver: str = ""
    driver_checksum: str = ""
    rules: str
    collecting: str = ""
    versions: dict[str, str]

    def differences(self, other: "Origin") -> list[str]:
        """Return what of this origin is not so in another.

        Versions do not count, nor another name for the same driver.
        """
        same = {"driver"} if self.driver_checksum == other.driver_checksum else set()
        ours, theirs = self.model_dump(exclude={"versions", *same}), other.model_dump()
        return [
            f"{name} {str(value)[:16] or 'unknown'}"
            for name, value in ours.items()
            if value != theirs[name]
        ]


class EpisodeNote(BaseModel):
    """How one episode ended; nothing of it depends on the clock.

    Attributes:
        route: Route id.
        status: A `Status` value.
        left_out: Why it is not in the data; empty if it is.
        frames: Samples at 2 Hz, counted whether it is in the data or not.
        metres: Driven.
        seconds: Simulated.
        collisions: Those that others caused; an expert's own leave the episode out. All of them
            where another planner drove.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    route: str
    status: str
    left_out: str = ""
    frames: int = 0
    metres: float = 0.0
    seconds: float = 0.0
    collisions: int = 0


@dataclass(frozen=True)
class DataFolder:
    """Collected data on disk.

    Attributes:
        path: The folder.
    """

    path: Path

    def create(self, origin: Origin) -> None:
        """Make the folder or go on with it; clear away what was left half written.

        Raises:
            InputError: It cannot be written, or holds data of another origin.
        """
        writer = RunFolder(self.path)
        for name in _PARTS:
            writer.make(name)
        for leftover in (
            *self.path.glob(f"**/*{UNFINISHED}"),
            *(self.path / "unfinished").iterdir(),
        ):
            leftover.unlink()
        earlier = self.origin()
        if earlier is not None and (other := earlier.differences(origin)):
            message = (
                f"{self.path} holds data of another origin ({', '.join(other)}). Choose another "
                "folder with --out, or remove it: data of two origins is not mixed."
            )
            raise InputError(message)
        self.write("collect.json", origin.model_dump_json(indent=1) + "\n")

    def origin(self) -> Origin | None:
        """Return what all episodes have in common; None where nobody has written it down.

        Raises:
            InputError: It is broken.
        """
        path = self.path / "collect.json"
        if not path.is_file():
            return None
        try:
            return Origin.model_validate_json(read_text(path))
        except (OSError, ValueError) as error:
            message = f"{path} is broken. Choose another folder, or remove it and collect again."
            raise InputError(message) from error

    @property
    def towns(self) -> Path:
        """Where further towns lie."""
        return self.path / "towns"

    def episode(self, name: str) -> Path:
        """Return where an episode's recording lies."""
        return self.path / "episodes" / f"{name}.parquet"

    def unfinished(self, name: str) -> Path:
        """Return where an episode's recording is written before its end is known."""
        return self.path / "unfinished" / f"{name}.parquet"

    def note(self, name: str) -> EpisodeNote | None:
        """Return how an episode ended, if that and its recording are there."""
        try:
            text = read_text(self.path / "records" / f"{name}.json")
            note = EpisodeNote.model_validate_json(text)
        except (OSError, ValueError):
            return None  # missing or broken: it is driven again
        return note if note.left_out or self.episode(name).is_file() else None

    def notes(self) -> list[EpisodeNote]:
        """Return how all episodes have ended, by name."""
        names = [path.stem for path in sorted((self.path / "records").glob("*.json"))]
        return [note for note in map(self.note, names) if note is not None]

    def save(self, name: str, note: EpisodeNote) -> None:
        """Write down how an episode ended.

        Raises:
            InputError: It cannot be written.
        """
        self.write(f"records/{name}.json", note.model_dump_json(indent=1) + "\n")

    def write(self, name: str, text: str) -> None:
        """Write a text file, whole or not at all.

        Raises:
            InputError: It cannot be written.
        """
        RunFolder(self.path).write(name, text)

    def save_visits(self, town: str, visits: list[list[Route]]) -> None:
        """Write a town's routes as a suite file."""
        routes = sorted((route for visit in visits for route in visit), key=lambda route: route.id)
        ids = [[route.id for route in visit] for visit in visits]
        about = {"suite": "training", "visits": ids}
        self.write(f"routes/{town}.json", suite_text(about, routes))

    def has_visits(self, town: str) -> bool:
        """Tell whether a town's routes are there."""
        return (self.path / "routes" / f"{town}.json").is_file()

    def visits(self, town: str) -> list[list[Route]]:
        """Return a town's routes, grouped by the visit on which they are driven.

        Raises:
            InputError: They are missing or broken.
        """
        path = self.path / "routes" / f"{town}.json"
        routes = {route.id: route for route in load_suite(str(path))}
        try:
            visits = read_json(path)["visits"]
            return [[routes[name] for name in visit] for visit in visits]
        except (OSError, KeyError, TypeError, ValueError) as error:
            message = f"{path} does not tell its visits. Remove it, and collect again."
            raise InputError(message) from error
