"""Collects training data: drives episodes on worker processes until there are enough frames."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

from plant_bench.agents.loading.checksum import agent_checksum
from plant_bench.agents.loading.planner_spec import without_folders
from plant_bench.errors import SimulationError
from plant_bench.runner.collect.collect_task import (
    DriveTask,
    TownTask,
    drive_episode,
    lost_note,
    prepare_town,
)
from plant_bench.runner.collect.dagger import check_driver
from plant_bench.runner.collect.data_folder import DataFolder, EpisodeNote, Origin
from plant_bench.runner.collect.episode_plan import EXPERT, PlannedEpisode, planned_episodes
from plant_bench.runner.collect.request import CollectRequest
from plant_bench.runner.episode.keys import collecting_checksum, rules_checksum
from plant_bench.runner.episode.timing import Timing
from plant_bench.runner.run.provenance import installed_versions
from plant_bench.runner.workers.executors import (
    Event,
    Finished,
    Lost,
    Progressed,
    Started,
    run_tasks,
)
from plant_bench.sim.densities import density_of
from plant_bench.towns.training_towns import TrainingTown, training_towns
from plant_bench.user_code import contained
from plant_bench.world.route import PROTOCOL, Route

EXPECTED_RATE = 0.55  # frames per metre of route, before the first episode
MIN_RATE = 0.05  # frames per metre
MAX_EXCLUDED = 20  # first episodes; if all are excluded, the collection is aborted


@dataclass(frozen=True)
class TownsPrepared:
    """Towns and routes are on disk."""

    count: int


@dataclass(frozen=True)
class DriveStarted:
    """A worker has started an episode."""

    worker: int
    name: str


@dataclass(frozen=True)
class DriveProgressed:
    """Progress of a worker's episode, 0 to 1."""

    worker: int
    share: float


@dataclass(frozen=True)
class DriveEnded:
    """An episode's note is on disk; worker and timing are None if it was there before."""

    worker: int | None
    name: str
    note: EpisodeNote
    timing: Timing | None


CollectEvent = TownsPrepared | DriveStarted | DriveProgressed | DriveEnded


def collect(
    request: CollectRequest,
    out: Path,
    *,
    workers: int,
    on_event: Callable[[CollectEvent], None],
) -> list[EpisodeNote]:
    """Collect data until there are enough frames; existing episodes of the folder are reused.

    The data depends on the request alone, not on the number of workers or on interruptions.

    Args:
        request: The request.
        out: Folder of the data.
        workers: Number of processes.
        on_event: Called in this process with each event.

    Returns:
        The notes of all planned episodes.

    Raises:
        InputError: The request cannot be met, or the folder holds data of another origin.
        SimulationError: Worker processes do not start, or all first episodes are excluded.
    """
    request.check()
    density_of(request.density)
    if request.driver:
        with contained():
            check_driver(request.driver)
    folder = DataFolder(out)
    folder.create(_origin(request))
    return _Collection(request, folder, workers, on_event).run()


def _origin(request: CollectRequest) -> Origin:
    return Origin(
        seed=request.seed,
        density=request.density,
        perturb=request.perturb,
        protocol=PROTOCOL,
        agent=EXPERT,
        agent_checksum=agent_checksum(EXPERT),
        driver=without_folders(request.driver),
        driver_checksum=agent_checksum(request.driver) if request.driver else "",
        rules=rules_checksum(),
        collecting=collecting_checksum(),
        versions=installed_versions(),
    )


class _Collection:
    """Plans and drives rounds of episodes until there are enough frames; mutable."""

    def __init__(
        self,
        request: CollectRequest,
        folder: DataFolder,
        workers: int,
        on_event: Callable[[CollectEvent], None],
    ) -> None:
        self._request = request
        self._folder = folder
        self._workers = workers
        self._on_event = on_event
        self._visits: dict[str, list[list[Route]]] = {}
        self._towns = training_towns()
        self._notes: list[EpisodeNote] = []
        self._metres = 0.0  # length of the routes planned so far

    def run(self) -> list[EpisodeNote]:
        plan = planned_episodes(self._request, self._towns, self._visits_of, agent_checksum(EXPERT))
        while (missing := self._request.frames - self._frames()) > 0:
            self._check_any_used()
            self._drive(self._next_round(plan, missing))
        return self._notes

    def _frames(self) -> int:
        return sum(note.frames for note in self._notes if not note.left_out)

    def _check_any_used(self) -> None:
        if len(self._notes) >= MAX_EXCLUDED and not self._frames():
            driver = f"'{self._request.driver}'" if self._request.driver else "The expert"
            message = (
                f"{driver} drove {len(self._notes)} episodes, and none can be used as data; the "
                f"first, {self._notes[0].route}: {self._notes[0].left_out}."
            )
            raise SimulationError(message)

    def _next_round(self, plan: Iterator[PlannedEpisode], frames: int) -> list[PlannedEpisode]:
        """Return the next episodes, as many as are expected to yield the missing frames."""
        rate = max(self._frames() / self._metres, MIN_RATE) if self._metres else EXPECTED_RATE
        chosen, metres = [], 0.0
        while metres * rate < frames:
            chosen.append(next(plan))
            metres += chosen[-1].job.route.length
        self._metres += metres
        return chosen

    def _drive(self, episodes: list[PlannedEpisode]) -> None:
        """Drive a round, sorted by town, since workers cache few towns."""
        notes = {episode.name: self._folder.note(episode.name) for episode in episodes}
        for name, note in notes.items():
            if note is not None:
                self._on_event(DriveEnded(None, name, note, None))
        missing = [episode for episode in episodes if notes[episode.name] is None]
        missing.sort(key=lambda one: (one.job.route.town, -one.job.route.length))

        def listen(event: Event) -> None:
            episode = missing[event.task]
            match event:
                case Started():
                    self._on_event(DriveStarted(event.worker, episode.name))
                case Progressed():
                    self._on_event(DriveProgressed(event.worker, event.share))
                case Finished():
                    end(event.worker, episode, *event.value)
                case Lost():
                    end(event.worker, episode, lost_note(episode, event.reason), None)

        def end(
            worker: int, episode: PlannedEpisode, note: EpisodeNote, timing: Timing | None
        ) -> None:
            self._folder.save(episode.name, note)
            notes[episode.name] = note
            self._on_event(DriveEnded(worker, episode.name, note, timing))

        folder = DataFolder(self._folder.path.absolute())  # a driver may change the working folder
        tasks = [DriveTask(episode, folder) for episode in missing]
        self._run(tasks, drive_episode, listen)
        self._notes += [note for note in notes.values() if note is not None]

    def _visits_of(self, town: TrainingTown) -> list[list[Route]]:
        if town.name not in self._visits:
            if not self._folder.has_visits(town.name):
                self._prepare(town)
            self._visits[town.name] = self._folder.visits(town.name)
        return self._visits[town.name]

    def _prepare(self, first: TrainingTown) -> None:
        """Build a town, together with all others that the request is expected to need."""
        routes = [visit for visits in self._visits.values() for visit in visits]
        metres = sum(route.length for visit in routes for route in visit) / max(len(routes), 1)
        count = round(self._request.frames / (EXPECTED_RATE * metres)) if metres else 1
        start = self._towns.index(first)
        towns = [
            town
            for town in self._towns[start : max(start + 1, count)]
            if not self._folder.has_visits(town.name)
        ]
        tasks = [TownTask(town, self._folder, self._request.seed) for town in towns]
        self._run(tasks, prepare_town, lambda _event: None)
        self._on_event(TownsPrepared(len(self._visits) + len(towns)))

    def _run(
        self,
        tasks: list[TownTask] | list[DriveTask],
        work: Callable[..., object],
        listen: Callable[[Event], None],
    ) -> None:
        logs = self._folder.path / "logs"
        run_tasks(tasks, work, workers=self._workers, on_event=listen, logs=logs)
