"""Loads the inputs of a replay: recording, record, route and town of an episode."""

import re
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

from plant_bench.agents.loading.planner_spec import without_folders
from plant_bench.data.recording import Recording
from plant_bench.data_files import towns_dirs_of
from plant_bench.errors import InputError
from plant_bench.reports.episode_selection import episodes_of
from plant_bench.runner.review.expert_braking import ExpertView
from plant_bench.runner.run.folder import RunFolder
from plant_bench.runner.run.provenance import Provenance
from plant_bench.scoring.results import EpisodeResult
from plant_bench.world.route import Route, load_suite, suite_names
from plant_bench.world.town import Town, load_town, town_checksum

AskExpert = Callable[[Recording, EpisodeResult, Route], ExpertView]

LONGEST_ID = 200  # characters
_ID = re.compile(r"[A-Za-z0-9_][\w.-]*/[A-Za-z0-9_][\w.-]*", re.ASCII)
_NAME = re.compile(r"[A-Za-z0-9_][\w.-]*", re.ASCII)


@dataclass(frozen=True)
class ReplaySource:
    """One episode to replay.

    Attributes:
        id: "<run>/<episode name>", of letters, digits, ".", "_" and "-"; names the replay's file.
        title: Display name of the planner.
        agent: Name of the planner, for `load_agent`.
        recording: Path of the recording.
        result: The episode's record.
        ask_expert: Returns the actors that the expert would brake for; must be picklable. None
            leaves them out, unless the expert drove.

    Raises:
        InputError: The id cannot name a file, or the town's name cannot.
    """

    id: str
    title: str
    agent: str
    recording: Path
    result: EpisodeResult
    ask_expert: AskExpert | None = None

    def __post_init__(self) -> None:
        """Check that the id cannot name a file outside the folder of replays."""
        if not is_replay_id(self.id):
            message = (
                f"Replay id {self.id[:80]!r}: expected '<run>/<episode>' of letters, digits, '.', "
                "'_' and '-', since it names a file."
            )
            raise InputError(message)
        if not _NAME.fullmatch(self.result.town):
            message = f"Town {self.result.town[:80]!r} cannot name a file. Score the route again."
            raise InputError(message)


def is_replay_id(text: object) -> bool:
    """Return whether a text is a valid replay id.

    >>> is_replay_id("plant/town01-0_r0_abc"), is_replay_id("../x")
    (True, False)
    """
    return isinstance(text, str) and len(text) <= LONGEST_ID and _ID.fullmatch(text) is not None


def load_recording(source: ReplaySource) -> Recording:
    """Return the recording of a source.

    Raises:
        InputError: It is missing, broken, thinned, empty or of another episode.
    """
    if not source.recording.is_file():
        message = (
            f"No recording {source.recording.name}: the run was scored without recordings. Run the "
            "same `plant-bench score` again with --recordings --overwrite."
        )
        raise InputError(message)
    recording = Recording.load(source.recording)
    if not len(recording) or len(recording.complete_rows) < len(recording):
        message = (
            f"The recording {source.recording.name} is thinned: it has the actors at only "
            f"{len(recording.complete_rows)} of {len(recording)} ticks, as written by `plant-bench "
            "collect`. A replay needs all: drive the route with `plant-bench score --recordings`."
        )
        raise InputError(message)
    if recording.metadata.get("scenario") != source.result.scenario:
        message = (
            f"The recording {source.recording.name} is of scenario "
            f"{recording.metadata.get('scenario')}, its record of {source.result.scenario}. "
            "Score the route again."
        )
        raise InputError(message)
    return recording


def load_route(source: ReplaySource) -> Route:
    """Return the route of a source: from its run's suite, or one of the built-in suites.

    Raises:
        InputError: No suite has the route with the recorded checksum.
    """
    checksum = source.result.route_checksum
    for suite in (*_suite_of(source), *suite_names()):
        route = _routes(suite).get(checksum)
        if route is not None:
            return route
    message = (
        f"The route {source.result.route} has changed since the episode was driven: no suite has "
        f"it with checksum {checksum[:12]}. Score it again."
    )
    raise InputError(message)


def load_town_of(source: ReplaySource) -> Town:
    """Return the town of a source.

    Raises:
        InputError: There is no such town, or it has changed.
    """
    name, folders = source.result.town, town_folders_of(source)
    if _checksum(name, folders) != source.result.town_checksum:
        message = f"The town {name} has changed since the episode was driven. Score it again."
        raise InputError(message)
    return load_town(name, folders)


def town_folders_of(source: ReplaySource) -> tuple[Path, ...]:
    """Return the folders to search for a source's town, besides `networks/`."""
    return tuple(
        folder
        for suite in map(Path, _suite_of(source))
        if suite.exists()
        for folder in towns_dirs_of(suite if suite.is_dir() else suite.parent)
    )


def _suite_of(source: ReplaySource) -> list[str]:
    run_file = source.recording.parent.parent / "run.json"
    return [Provenance.load(run_file).suite] if run_file.is_file() else []


@lru_cache(maxsize=8)
def _routes(suite: str) -> dict[str, Route]:
    """Return the routes of a suite by checksum; empty if it cannot be loaded."""
    try:
        return {route.checksum: route for route in load_suite(suite)}
    except InputError:
        return {}


@lru_cache(maxsize=32)
def _checksum(name: str, folders: tuple[Path, ...]) -> str:
    return town_checksum(name, folders)


def source_in_run(run: Path, route: str, repetition: int | None) -> ReplaySource:
    """Return an episode of a run as a source of a replay.

    Args:
        run: A folder that `plant-bench score` wrote.
        route: The route's id, or its number in the suite.
        repetition: The repetition; None for the first one.

    Raises:
        InputError: It is not a run, or has no such episode; the message lists its episodes.
    """
    folder = RunFolder.open(run)
    name, result = episodes_of(folder, route, repetition)[0]
    title = without_folders(result.agent)
    return ReplaySource(
        f"{run_slug(run)}/{name}", title, result.agent, folder.recording_path(name), result
    )


def run_slug(run: Path) -> str:
    """Return the name of a run's folder, with characters that are valid in a URL.

    >>> run_slug(Path("reports/my agent.py_Mine-longest6"))
    'my-agent.py_Mine-longest6'
    """
    slug = re.sub(r"[^A-Za-z0-9_.-]+", "-", run.resolve().name).strip("-.")
    return slug or "run"
