"""Worker tasks of data collection: build a town; drive an episode, keep or drop its recording."""

from dataclasses import dataclass

from plant_bench.atomic_files import move_whole
from plant_bench.runner.collect.dagger import DaggerOverride
from plant_bench.runner.collect.data_folder import DataFolder, EpisodeNote
from plant_bench.runner.collect.episode_plan import VISITS, PlannedEpisode
from plant_bench.runner.collect.perturbation import Perturbation
from plant_bench.runner.collect.request import FRAME_TICKS
from plant_bench.runner.episode.loop import Override, run_episode
from plant_bench.runner.episode.timing import Timing
from plant_bench.runner.workers.worker import Report
from plant_bench.scoring.infractions import COLLISIONS, InfractionKind, Status
from plant_bench.scoring.results import EpisodeResult
from plant_bench.towns.training_routes import training_visits
from plant_bench.towns.training_towns import TrainingTown, build_training_town
from plant_bench.world.town import load_town


@dataclass(frozen=True)
class TownTask:
    """A town to build; picklable."""

    town: TrainingTown
    folder: DataFolder
    seed: int


@dataclass(frozen=True)
class DriveTask:
    """An episode to drive; picklable."""

    episode: PlannedEpisode
    folder: DataFolder


def prepare_town(task: TownTask, _report: Report) -> None:
    """Build a town and generate its routes."""
    town = task.town
    build_training_town(town, task.folder.towns)
    visits = training_visits(
        load_town(town.name, [task.folder.towns]), town.base, VISITS, task.seed
    )
    task.folder.save_visits(town.name, visits)


def drive_episode(task: DriveTask, report: Report) -> tuple[EpisodeNote, Timing]:
    """Drive an episode, and add its recording to the data unless it must be excluded."""
    episode, folder = task.episode, task.folder
    recording = folder.unfinished(episode.name)
    done = run_episode(
        episode.job,
        recording=recording,
        progress=report,
        thinning=FRAME_TICKS,
        override=_override(episode),
    )
    note = _note(done.result, done.timing.ticks, dagger=bool(episode.driver))
    if note.left_out:
        recording.unlink()
    else:
        move_whole(recording, folder.episode(episode.name))
    return note, done.timing


def _override(episode: PlannedEpisode) -> Override | None:
    if episode.driver:
        return DaggerOverride(episode.driver, episode.job.route, episode.job.seed)
    return Perturbation(episode.job.seed) if episode.perturbed else None


def _note(result: EpisodeResult, ticks: int, *, dagger: bool) -> EpisodeNote:
    collisions = [item for item in result.infractions if item.kind in COLLISIONS]
    counted = [item for item in collisions if dagger or item.cause != "ego"]
    return EpisodeNote(
        route=result.route,
        status=result.status.value,
        left_out=exclusion_reason_dagger(result) if dagger else exclusion_reason(result),
        frames=ticks // FRAME_TICKS + 1,
        metres=result.distance,
        seconds=result.duration,
        collisions=len(counted),
    )


def exclusion_reason(result: EpisodeResult) -> str:
    """Return why an episode that the expert drove is excluded from the data; empty if it is not."""
    if result.status is not Status.COMPLETED:
        return result.status.value.removeprefix("Failed - ")
    if any(item.kind in COLLISIONS and item.cause == "ego" for item in result.infractions):
        return "collision that the expert caused"
    if any(item.kind is InfractionKind.RED_LIGHT for item in result.infractions):
        return "red light run by the expert"
    return ""


def exclusion_reason_dagger(result: EpisodeResult) -> str:
    """Return why an episode that another planner drove is excluded; empty if it is not.

    Driving mistakes do not exclude it: DAgger needs the expert's actions in those states.
    """
    if result.status is Status.AGENT_CRASHED:
        return f"Agent crashed: {result.reason}"
    return ""


def lost_note(episode: PlannedEpisode, reason: str) -> EpisodeNote:
    """Return the note of an episode whose simulation crashed repeatedly."""
    status = Status.SIMULATION_CRASHED.value
    return EpisodeNote(
        route=episode.job.route.id, status=status, left_out=f"Simulation crashed: {reason}"
    )
