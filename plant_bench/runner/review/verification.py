"""Verifies records: scores their recordings again, and simulates episodes again."""

import random
import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from plant_bench.data.recording import Recording
from plant_bench.errors import SimulationError, in_one_line
from plant_bench.runner.episode.jobs import Job
from plant_bench.runner.episode.loop import run_episode
from plant_bench.runner.review.differences import Difference, EpisodeCheck, first_difference
from plant_bench.runner.review.resimulation import simulate_again
from plant_bench.runner.review.submission import Submission
from plant_bench.runner.workers.executors import Event, Finished, Lost, Progressed, run_tasks
from plant_bench.runner.workers.isolation import Isolation, episode_loader
from plant_bench.runner.workers.worker import Report
from plant_bench.scoring.infractions import Status
from plant_bench.scoring.rescore_episode import rescore
from plant_bench.scoring.results import Crash, EpisodeResult
from plant_bench.world.route import Route

AGENT, CONTROLS = "agent", "controls"
RECORDING = "a recording that can be scored"
OnShare = Callable[[float], None]


@dataclass(frozen=True)
class Task:
    """An episode to simulate again; picklable.

    Attributes:
        name: Name of the episode's files.
        job: The job, made from the installed suite.
        record: The submitted record.
        recording: Recording whose controls are executed; None if the agent drives.
        isolation: Runs the agent in a separate process; None to load it in the worker.
    """

    name: str
    job: Job
    record: EpisodeResult
    recording: Path | None
    isolation: Isolation | None = None


@dataclass(frozen=True)
class RescoringTask:
    """A recorded episode to score again without the simulator; picklable.

    Attributes:
        name: Name of the episode's files.
        route: The installed route.
        record: The submitted record.
        recording: The submitted recording.
    """

    name: str
    route: Route
    record: EpisodeResult
    recording: Path


@dataclass(frozen=True)
class Checks:
    """The results of verifying the episodes of a run.

    Attributes:
        simulated: Episodes of the sample, simulated again.
        rescored: Episodes whose recording was scored again; all that have one.
    """

    simulated: list[EpisodeCheck]
    rescored: list[EpisodeCheck]


def sample_of(records: Mapping[str, EpisodeResult], size: int, seed: int) -> list[str]:
    """Return the names of a random sample, stratified by town.

    Args:
        records: Records by name.
        size: Number of names.
        seed: Random seed.
    """
    rng = random.Random(seed)
    towns: dict[str, list[str]] = {}
    for name in sorted(records):
        towns.setdefault(records[name].town, []).append(name)
    rows = list(towns.values())
    for names in (*rows, rows):
        rng.shuffle(names)
    longest = max(map(len, rows), default=0)
    by_turns = [names[turn] for turn in range(longest) for names in rows if turn < len(names)]
    return sorted(by_turns[:size])


def verify_episodes(
    submission: Submission,
    names: Sequence[str],
    *,
    agent: str | None,
    workers: int,
    on_share: OnShare,
    isolation: Isolation | None = None,
) -> Checks:
    """Score all recordings of a run again, and simulate some of its episodes again.

    Args:
        submission: The run.
        names: Names of the episodes to simulate.
        agent: Agent that drives, as named for `load_agent`; None for the recorded controls.
        workers: Number of processes.
        on_share: Called with the fraction of the work done, 0 to 1.
        isolation: Runs the agent in a separate process; None to load it in the workers.

    Raises:
        InputError: The agent or a town cannot be used.
        SimulationError: Worker processes do not start.
    """
    simulations = [_task(submission, name, agent, isolation) for name in names]
    tasks: list[Task | RescoringTask] = [*simulations, *_rescoring_tasks(submission)]
    shares = [0.0] * len(tasks)
    found: dict[int, EpisodeCheck] = {}

    def listen(event: Event) -> None:
        if isinstance(event, Finished):
            found[event.task] = event.value
        elif isinstance(event, Lost):
            found[event.task] = _lost(tasks[event.task], event.reason)
        if isinstance(event, Progressed | Finished | Lost):
            shares[event.task] = event.share if isinstance(event, Progressed) else 1.0
            on_share(sum(shares) / len(shares))

    with tempfile.TemporaryDirectory(prefix="plant-bench-verify-") as logs:
        run_tasks(tasks, check, workers=workers, on_event=listen, logs=Path(logs))
    checks = [found[index] for index in sorted(found)]
    return Checks(checks[: len(simulations)], checks[len(simulations) :])


def _rescoring_tasks(submission: Submission) -> list[RescoringTask]:
    """Return a task for each episode with a recording; a link counts, and is then a difference."""
    paths = {name: submission.folder.recording_path(name) for name in submission.records}
    return [
        RescoringTask(name, submission.routes[record.route], record, paths[name])
        for name, record in submission.records.items()
        if paths[name].is_symlink() or paths[name].is_file()
    ]


def _task(
    submission: Submission, name: str, agent: str | None, isolation: Isolation | None
) -> Task:
    record = submission.records[name]
    job = submission.job(record)
    if agent is None:
        return Task(name, job, record, submission.folder.recording_path(name))
    return Task(name, Job(**{**vars(job), "agent": agent}), record, None, isolation)


def check(task: Task | RescoringTask, report: Report) -> EpisodeCheck:
    """Run a task in a worker process; see `check_episode` and `check_score`."""
    return check_score(task) if isinstance(task, RescoringTask) else check_episode(task, report)


def check_score(task: RescoringTask) -> EpisodeCheck:
    """Score a recording again without the simulator, and compare the records."""
    route = task.route
    try:
        if task.recording.is_symlink():
            difference = Difference("recording", "symbolic link", RECORDING)
        else:
            again = rescore(Recording.load(task.recording), route.load_town(), route)
            difference = first_difference(task.record, again)
    except Exception as error:  # noqa: BLE001  an untrusted recording may cause any error
        difference = Difference("recording", in_one_line(error), RECORDING)
    return EpisodeCheck(task.name, route.town, difference)


def check_episode(task: Task, report: Report) -> EpisodeCheck:
    """Simulate one episode again in a worker process, and compare the records.

    Raises:
        InputError: The agent or the town cannot be used.
        SimulationError: SUMO fails.
    """
    if task.recording is None:
        load = episode_loader(task.isolation)
        again = run_episode(task.job, progress=report, load=load).result
        again = again.model_copy(update={"agent": task.record.agent})
        return EpisodeCheck(task.name, task.job.route.town, first_difference(task.record, again))
    try:
        difference = _resimulated_difference(task, task.recording, report)
    except SimulationError:
        raise
    except Exception as error:  # noqa: BLE001  an untrusted recording may cause any error
        difference = Difference(
            "recording", in_one_line(error), "a recording that can be simulated"
        )
    return EpisodeCheck(task.name, task.job.route.town, difference)


def _resimulated_difference(task: Task, path: Path, report: Report) -> Difference | None:
    """Execute the recorded controls, and compare scenes and record."""
    record, route = task.record, task.job.route
    if not path.is_file() or path.is_symlink():
        return Difference("recording", "none", "a recording of every tick")
    recording = Recording.load(path)
    header = task.job.header(frozenset(record.inputs))
    crash = None
    if record.status is Status.AGENT_CRASHED:
        crash = Crash(record.status, record.reason)
    again: EpisodeResult | None = None
    last = len(recording) - 1
    for tick in simulate_again(recording, record, route):
        if tick.difference:
            place = f"recording, tick {tick.recorded.tick}"
            return Difference(place, "as recorded", f"other: {tick.difference}")
        report(tick.row / max(last, 1))
        if tick.row == last:
            again = tick.episode.result(header, crash)
    return None if again is None else first_difference(record, again)


def _lost(task: Task | RescoringTask, reason: str) -> EpisodeCheck:
    if isinstance(task, RescoringTask):
        difference = Difference("recording", f"not scored: {reason}", RECORDING)
        return EpisodeCheck(task.name, task.route.town, difference)
    difference = Difference("status", task.record.status.value, f"not simulated: {reason}")
    return EpisodeCheck(task.name, task.job.route.town, difference)
