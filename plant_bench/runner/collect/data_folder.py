"""The folder of collected data: reads and writes recordings, episode notes and routes.

collect.json: settings, checksums and versions (`Origin`).
routes/<town>.json: the routes of a town as a suite file; "visits" groups those driven together.
towns/<town>/: generated training towns; the benchmark's towns are not copied.
episodes/<route>_r<repetition>_<key>.parquet: a thinned recording (`data.recording`).
records/<the same>.json: how the episode ended (`EpisodeNote`), also for excluded episodes.
data.json, README.md: a summary and the data card, both derived.
unfinished/, logs/: recordings being written, and output of the workers.
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
    """Settings, checksums and versions that all episodes of a folder share.

    Attributes:
        seed: The base seed.
        density: Traffic density.
        perturb: Fraction of episodes with perturbations.
        protocol: Name and version of the rules.
        agent: The planner whose actions are recorded.
        agent_checksum: Content hash of the agent's code.
        driver: The planner whose actions were executed; empty if it was the agent.
        driver_checksum: Content hash of the driver's code and weights.
        rules: Content hash of the rules' code; see `rules_checksum`.
        collecting: Content hash of all code that affects the data; see `collecting_checksum`. Empty
            in folders of older versions, which can be read but not extended.
        versions: Versions of all software that can change the data.
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
        """Return the fields, with their values, that differ from another origin.

        Versions are not compared, nor are names of drivers with equal checksums.
        """
        ignored = {"driver"} if self.driver_checksum == other.driver_checksum else set()
        mine, theirs = self.model_dump(exclude={"versions", *ignored}), other.model_dump()
        return [
            f"{name} {str(value)[:16] or 'unknown'}"
            for name, value in mine.items()
            if value != theirs[name]
        ]


class EpisodeNote(BaseModel):
    """How one episode ended; independent of the clock.

    Attributes:
        route: Route id.
        status: A `Status` value.
        left_out: Why the episode is excluded from the data; empty if it is not.
        frames: Number of samples at 2 Hz, also for excluded episodes.
        metres: Distance driven.
        seconds: Simulated time.
        collisions: Number of collisions that other actors caused (an episode in which the expert
            caused one is excluded); of all collisions if another planner drove.
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
        """Create or open the folder, and remove partly written files of an interrupted run.

        Raises:
            InputError: The folder cannot be written to, or holds a run or data of another origin.
        """
        writer = RunFolder(self.path)
        if writer.run_file.is_file():
            message = (
                f"{self.path} holds a run of `plant-bench score`. Choose another folder with --out."
            )
            raise InputError(message)
        for name in _PARTS:
            writer.make_subfolder(name)
        for leftover in (
            *self.path.glob(f"**/*{UNFINISHED}"),
            *(self.path / "unfinished").iterdir(),
        ):
            leftover.unlink()
        earlier = self.origin()
        if earlier is not None and (other := earlier.differences(origin)):
            message = (
                f"{self.path} holds data of another origin ({', '.join(other)}), which cannot be "
                "mixed with new data. Choose another folder with --out, or remove this one."
            )
            raise InputError(message)
        self.write("collect.json", origin.model_dump_json(indent=1) + "\n")

    def origin(self) -> Origin | None:
        """Return the content of `collect.json`; None if the file is missing.

        Raises:
            InputError: The file is broken.
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
        """Folder of the generated towns."""
        return self.path / "towns"

    def episode(self, name: str) -> Path:
        """Return the path of an episode's recording."""
        return self.path / "episodes" / f"{name}.parquet"

    def unfinished(self, name: str) -> Path:
        """Return the path of an episode's recording while the episode is driven."""
        return self.path / "unfinished" / f"{name}.parquet"

    def note(self, name: str) -> EpisodeNote | None:
        """Return an episode's note; None if the note or the recording is missing."""
        try:
            text = read_text(self.path / "records" / f"{name}.json")
            note = EpisodeNote.model_validate_json(text)
        except (OSError, ValueError):
            return None  # missing or broken: the episode is driven again
        return note if note.left_out or self.episode(name).is_file() else None

    def notes(self) -> list[EpisodeNote]:
        """Return the notes of all episodes, sorted by name."""
        names = [path.stem for path in sorted((self.path / "records").glob("*.json"))]
        return [note for note in map(self.note, names) if note is not None]

    def save(self, name: str, note: EpisodeNote) -> None:
        """Write an episode's note.

        Raises:
            InputError: The file cannot be written.
        """
        self.write(f"records/{name}.json", note.model_dump_json(indent=1) + "\n")

    def write(self, name: str, text: str) -> None:
        """Write a text file, completely or not at all.

        Raises:
            InputError: The file cannot be written.
        """
        RunFolder(self.path).write(name, text)

    def save_visits(self, town: str, visits: list[list[Route]]) -> None:
        """Write a town's routes as a suite file."""
        routes = sorted((route for visit in visits for route in visit), key=lambda route: route.id)
        ids = [[route.id for route in visit] for visit in visits]
        header = {"suite": "training", "visits": ids}
        self.write(f"routes/{town}.json", suite_text(header, routes))

    def has_visits(self, town: str) -> bool:
        """Return whether a town's routes are on disk."""
        return (self.path / "routes" / f"{town}.json").is_file()

    def visits(self, town: str) -> list[list[Route]]:
        """Return a town's routes, grouped by visit.

        Raises:
            InputError: The file is missing or broken.
        """
        path = self.path / "routes" / f"{town}.json"
        routes = {route.id: route for route in load_suite(str(path))}
        try:
            visits = read_json(path)["visits"]
            return [[routes[name] for name in visit] for visit in visits]
        except (OSError, KeyError, TypeError, ValueError) as error:
            message = (
                f'{path} has no valid "visits": expected lists of its route ids. Remove the file, '
                "and collect again."
            )
            raise InputError(message) from error
