"""Opens a run's folder for a request and determines which episodes are missing."""

import hashlib
import re
from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path

from plant_bench.agents.loading.checksum import agent_checksum
from plant_bench.agents.loading.registry import Loader, load_agent
from plant_bench.errors import InputError
from plant_bench.runner.episode.jobs import Job, episode_name, make_jobs, select_routes
from plant_bench.runner.run.folder import RunFolder
from plant_bench.runner.run.provenance import Provenance, provenance
from plant_bench.runner.run.run_lock import Shard, locked
from plant_bench.sim.densities import density_of
from plant_bench.world.route import Route, load_suite


@dataclass(frozen=True)
class ScoreRequest:
    """The request for a run.

    Attributes:
        agent: Name of the planner, as for `load_agent`.
        suite: A suite's name, or a folder or file of routes.
        routes: Selection of routes (see `select_routes`), None for all.
        repetitions: Episodes per route.
        seed: The base seed.
        density: Traffic density.
        hazards: Whether the routes' hazards are enabled.
    """

    agent: str
    suite: str = "longest6"
    routes: str | None = None
    repetitions: int = 3
    seed: int = 0
    density: str = "dense"
    hazards: bool = True

    @property
    def run_name(self) -> str:
        """Default name of the folder; equal requests have equal names."""
        suite = Path(self.suite)  # an imported town's suite is the folder MYTOWN/routes
        parts = [self.agent, suite.parent.name if suite.name == "routes" else suite.stem]
        if not self.hazards:
            parts.append("no-hazards")
        if self.density != "dense":
            parts.append(self.density)
        if self.seed != 0:
            parts.append(f"seed{self.seed}")
        return re.sub(r"[^\w.-]+", "_", "-".join(parts)).strip("._")

    def folder(self, out: Path | None) -> Path:
        """Return the folder of the run: `out`, or `reports/<run name>` if it is None."""
        return Path("reports") / self.run_name if out is None else out

    def jobs(self, checksum: str, routes: Sequence[Route], repetitions: int) -> list[Job]:
        """Return one job for each route and repetition."""
        return make_jobs(
            self.agent,
            checksum,
            routes,
            repetitions=repetitions,
            seed=self.seed,
            density=self.density,
            hazards=self.hazards,
        )


@dataclass(frozen=True)
class Run:
    """An opened run, ready to drive.

    Attributes:
        folder: Folder of the run.
        jobs: The requested jobs.
        missing: Jobs without a record, the longest first so that workers finish together.
        notes: Notes for the user about the existing content of the folder.
        others: Jobs of the run's other shards.
    """

    folder: RunFolder
    jobs: list[Job]
    missing: list[Job]
    notes: list[str]
    others: tuple[Job, ...] = ()

    def unfinished(self) -> int:
        """Return the number of jobs without a record."""
        return self._without_record(self.jobs)

    def unfinished_by_others(self) -> int:
        """Return the number of other shards' jobs without a record."""
        return self._without_record(self.others)

    def remove_partial_files(self) -> None:
        """Remove the partly written files of this run's own jobs."""
        self.folder.remove_partial_files(
            [episode_name(job) for job in self.jobs] if self.others else None
        )

    def _without_record(self, jobs: Sequence[Job]) -> int:
        return sum(self.folder.record(episode_name(job)) is None for job in jobs)


def open_run(
    request: ScoreRequest,
    out: Path | None,
    *,
    overwrite: bool = False,
    shard: Shard | None = None,
    lock_stack: ExitStack | None = None,
    load: Loader = load_agent,
) -> Run:
    """Open or create a run's folder, find the missing episodes, and write `run.json`.

    Records made with another version of the agent, the towns, the routes or the rules are moved to
    `superseded/`.

    Args:
        request: The request.
        out: Folder of the run; None for `reports/<run name>` in the working folder.
        overwrite: Drive all requested episodes again, even if the folder holds another run.
        shard: The part of the request that is driven here; None for all of it.
        lock_stack: Holds the run lock (`locked`) until it is closed; None to take no lock.
        load: Loads the planner, for its checksum.

    Raises:
        InputError: The request cannot be met, the folder holds another run, or another process is
            writing to it.
    """
    suite = load_suite(request.suite)
    chosen = _checked_routes(request, suite)
    now = _provenance_now(request, suite, load)
    folder = RunFolder(request.folder(out))
    earlier = folder.provenance()
    if earlier is not None and not overwrite:
        _check_same_run(folder, earlier, now)
    everything = request.jobs(now.agent_checksum, chosen, request.repetitions)
    jobs = everything
    if shard is not None:
        jobs = shard.of(everything, [job.route.length for job in everything])
    if lock_stack is not None:
        lock_stack.enter_context(locked(folder.path, shard, _division(everything)))
    folder.create(partial_of=None if shard is None else [episode_name(job) for job in jobs])
    notes = _move_superseded(folder, request, now.agent_checksum, suite)
    missing = (
        jobs if overwrite else [job for job in jobs if folder.record(episode_name(job)) is None]
    )
    if overwrite:
        folder.remove_episodes(map(episode_name, jobs))
    if earlier is not None and len(missing) < len(jobs):
        notes += _changed_versions(earlier, now)
    folder.write("run.json", now.model_dump_json(indent=1) + "\n")
    by_length = sorted(missing, key=lambda job: (-job.route.length, job.route.id, job.repetition))
    own_names = set(map(episode_name, jobs))
    others = tuple(job for job in everything if episode_name(job) not in own_names)
    return Run(folder, jobs, by_length, notes, others)


def _checked_routes(request: ScoreRequest, suite: Sequence[Route]) -> list[Route]:
    """Return the requested routes; check that towns and density exist."""
    chosen = select_routes(suite, request.routes)
    for route in sorted(chosen, key=lambda route: route.town):
        route.check_town(route.load_town())
    density_of(request.density)
    return chosen


def _provenance_now(request: ScoreRequest, suite: list[Route], load: Loader) -> Provenance:
    return provenance(
        request.agent,
        agent_checksum(request.agent, load),
        suite,
        suite=request.suite,
        seed=request.seed,
        density=request.density,
        hazards=request.hazards,
        repetitions=request.repetitions,
    )


def _division(jobs: Sequence[Job]) -> str:
    """Return a hash of all episodes that the shards divide; it must be equal for all shards."""
    return hashlib.sha256("\n".join(map(episode_name, jobs)).encode()).hexdigest()


def _check_same_run(folder: RunFolder, earlier: Provenance, now: Provenance) -> None:
    other = [
        f"{name} {value}" for name, value in earlier.identity if (name, value) not in now.identity
    ]
    if other:
        message = (
            f"{folder.path} holds another run ({', '.join(other)}). Choose another folder with "
            "--out, or pass --overwrite."
        )
        raise InputError(message)


def _move_superseded(
    folder: RunFolder, request: ScoreRequest, checksum: str, suite: Sequence[Route]
) -> list[str]:
    repetitions = max(request.repetitions, folder.repetitions())
    moved = folder.move_superseded(map(episode_name, request.jobs(checksum, suite, repetitions)))
    if not moved:
        return []
    where = folder.path / "superseded"
    return [
        f"Records of another version of agent, towns, routes or rules: {moved}, moved to {where}."
    ]


def _changed_versions(earlier: Provenance, now: Provenance) -> list[str]:
    changed = [
        f"{name} {earlier.versions.get(name, 'unknown')}"
        for name in now.versions
        if earlier.versions.get(name) != now.versions[name]
    ]
    if not changed:
        return []
    return [f"Existing records were made with {', '.join(changed)}; --overwrite replaces them."]
