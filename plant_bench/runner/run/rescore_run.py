"""Scores a whole run again from its recordings, without the simulator."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from plant_bench.data.recording import Recording
from plant_bench.errors import InputError, in_one_line
from plant_bench.runner.review.differences import first_difference
from plant_bench.runner.run.folder import RunFolder
from plant_bench.runner.run.provenance import Provenance
from plant_bench.scoring.rescore_episode import rescore
from plant_bench.scoring.results import EpisodeResult
from plant_bench.world.route import Route, load_suite


@dataclass(frozen=True)
class Rescored:
    """One episode, scored twice.

    Attributes:
        name: Name of the episode's files.
        first: The original record.
        again: The record computed from the recording; None without a recording.
    """

    name: str
    first: EpisodeResult
    again: EpisodeResult | None

    @property
    def equal(self) -> bool:
        """Whether both records have the same bytes, in the format version of the first."""
        if self.again is None:
            return False
        return self.again.as_format(self.first.format).to_json() == self.first.to_json()

    @property
    def first_difference(self) -> str:
        """The first field that differs, with both values; empty if none does."""
        found = None if self.again is None else first_difference(self.first, self.again)
        return "" if found is None else f"{found.field} {found.told}, now {found.again}"


def rescore_folder(folder: RunFolder) -> Iterator[Rescored]:
    """Score each recording of a run again, and write the records into `rescored/`.

    Raises:
        InputError: There is no such run, or its suite, towns or recordings cannot be read.
    """
    provenance = Provenance.load(RunFolder.open(folder.path).run_file)
    routes = {route.id: route for route in load_suite(provenance.suite)}
    folder.make_subfolder("rescored")
    for path in folder.record_files():
        first = EpisodeResult.load(path)
        recording = folder.path / "recordings" / f"{path.stem}.parquet"
        if not recording.is_file():
            yield Rescored(path.stem, first, None)
            continue
        if first.route not in routes:
            message = f"The suite {provenance.suite} has no route {first.route} any more."
            raise InputError(message)
        again = _again(recording, routes[first.route])
        folder.write(f"rescored/{path.name}", again.to_json())
        yield Rescored(path.stem, first, again)


def _again(recording: Path, route: Route) -> EpisodeResult:
    try:
        return rescore(Recording.load(recording), route.load_town(), route)
    except ValueError as error:  # e.g. a value outside the range of a record's field
        message = f"Cannot score {recording} ({in_one_line(error)}): drive the episode again."
        raise InputError(message) from error
