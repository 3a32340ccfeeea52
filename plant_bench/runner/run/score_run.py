"""A run: what was asked for, what of it is finished, and what is left to do."""

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
from plant_bench.runner.run.run_lock import Shard, claimed
from plant_bench.sim.densities import density_of
from plant_bench.world.route import Route, load_suite


@dataclass(frozen=True)
class ScoreRequest:
    """What is asked of a run.

    Attributes:
        agent: As given to `load_agent`.
        suite: A suite's name, or a folder or file of routes.
        routes: Selection of routes (see `select_routes`), None for all.
        repetitions: Episodes on each route.
        seed: The base seed.
        density: Of the traffic.
        hazards: Whether the routes' hazards are played.
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
        """The folder's name: the same request finds its run again."""
        suite = Path(self.suite)  # an imported town's suite is the folder MYTOWN/routes
        parts = [self.agent, suite.parent.name if suite.name == "routes" else suite.stem]
        if not self.hazards:
            parts.append("no-hazards")
        if self.density != "dense":
            parts.append(self.density)
        if self.seed != 0:
            parts.append(f"seed{self.seed}")
        return re.sub(r"[^\w.-]+", "_", "-".join(parts)).strip("._")

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
    """A run that is ready to go.

    Attributes:
        folder: Where it lives.
        jobs: What was asked for.
        missing: Those of them without a record, the longest first so that workers end together.
        notes: What the user should know of what was found in the folder.
        others: What other shards of the run drive.
    """

    folder: RunFolder
    jobs: list[Job]
    missing: list[Job]
    notes: list[str]
    others: tuple[Job, ...] = ()

    def unfinished(self) -> int:
        """Return how many of the jobs have no record now."""
        return self._without_record(self.jobs)

    def unfinished_by_others(self) -> int:
        """Return how many of the jobs of other shards have no record now."""
        return self._without_record(self.others)

    def sweep(self) -> None:
        """Remove what killed workers left half written, of this run's own jobs."""
        self.folder.sweep([episode_name(job) for job in self.jobs] if self.others else None)

    def _without_record(self, jobs: Sequence[Job]) -> int:
        return sum(self.folder.record(episode_name(job)) is None for job in jobs)


def open_run(
    request: ScoreRequest,
    out: Path | None,
    *,
    overwrite: bool = False,
    shard: Shard | None = None,
    hold: ExitStack | None = None,
    load: Loader = load_agent,
) -> Run:
    """Find out what there is to do, and write `run.json`.

    Records made with another version of the agent, the towns, the routes or the rules are moved to
    `superseded/`.

    Args:
        request: What is wanted.
        out: The run's folder; None for `reports/<run name>` in the working folder.
        overwrite: Run all that is asked for again, and let the folder belong to this request.
        shard: The part of the request that is driven here; None for all of it.
        hold: Keeps others out of the folder until it is closed (see `claimed`); without it the
            caller knows that there are none.
        load: Makes the planner, to learn what it is made of.

    Raises:
        InputError: The request cannot be met, or the folder belongs to another one, or somebody
            else is driving into it.
    """
    suite = load_suite(request.suite)
    chosen = _checked_routes(request, suite)
    now = _provenance_now(request, suite, load)
    folder = RunFolder(out if out is not None else Path("reports") / request.run_name)
    earlier = folder.provenance()
    if earlier is not None and not overwrite:
        _check_same_run(folder, earlier, now)
    everything = request.jobs(now.agent_checksum, chosen, request.repetitions)
    jobs = everything
    if shard is not None:
        jobs = shard.of(everything, [job.route.length for job in everything])
    if hold is not None:
        hold.enter_context(claimed(folder.path, shard, _division(everything)))
    folder.create(sweeping=None if shard is None else [episode_name(job) for job in jobs])
    notes = _set_aside(folder, request, now.agent_checksum, suite)
    missing = (
        jobs if overwrite else [job for job in jobs if folder.record(episode_name(job)) is None]
    )
    if overwrite:
        folder.forget(map(episode_name, jobs))
    if earlier is not None and len(missing) < len(jobs):
        notes += _changed_versions(earlier, now)
    folder.write("run.json", now.model_dump_json(indent=1) + "\n")
    by_length = sorted(missing, key=lambda job: (-job.route.length, job.route.id, job.repetition))
    mine = set(map(episode_name, jobs))
    others = tuple(job for job in everything if episode_name(job) not in mine)
    return Run(folder, jobs, by_length, notes, others)


def _checked_routes(request: ScoreRequest, suite: Sequence[Route]) -> list[Route]:
    """Return the routes that are asked for, if all of the request can be driven."""
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
    """Return a hash of what shards divide: only shards of the same episodes fit together."""
    return hashlib.sha256("\n".join(map(episode_name, jobs)).encode()).hexdigest()


def _check_same_run(folder: RunFolder, earlier: Provenance, now: Provenance) -> None:
    other = [
        f"{name} {value}" for name, value in earlier.identity if (name, value) not in now.identity
    ]
    if other:
        message = (
            f"{folder.path} holds another run ({', '.join(other)}). Choose another folder with "
            "--out, or give --overwrite."
        )
        raise InputError(message)


def _set_aside(
    folder: RunFolder, request: ScoreRequest, checksum: str, suite: Sequence[Route]
) -> list[str]:
    repetitions = max(request.repetitions, folder.repetitions())
    moved = folder.set_aside(map(episode_name, request.jobs(checksum, suite, repetitions)))
    if not moved:
        return []
    where = folder.path / "superseded"
    return [
        f"{moved} records of another version of agent, towns, routes or rules are now in {where}."
    ]


def _changed_versions(earlier: Provenance, now: Provenance) -> list[str]:
    changed = [
        f"{name} {earlier.versions.get(name, 'unknown')}"
        for name in now.versions
        if earlier.versions.get(name) != now.versions[name]
    ]
    if not changed:
        return []
    return [f"Records kept were made with {', '.join(changed)}; --overwrite runs them again."]
