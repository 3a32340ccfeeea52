"""Computes RFDS, the relative filtered driving score of a planner's relevance ranking.

The expert drives twice: seeing all vehicles, and seeing only the one that the planner ranks
highest. RFDS is the second driving score in percent of the first.
"""

import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from pydantic import TypeAdapter

from plant_bench.agents.loading.checksum import agent_checksum
from plant_bench.agents.loading.registry import load_agent
from plant_bench.agents.ranking.expert_filtered import (
    ATTENTION,
    MASKING,
    PLANNER_RANKERS,
    RANKERS,
    ranks_itself,
)
from plant_bench.api.execution import cores
from plant_bench.api.numbers import check_episodes
from plant_bench.api.planners import PlannerLike, spec_of
from plant_bench.api.score import (
    ExecutionSettings,
    Listener,
    RunMonitor,
    drive_missing,
    silent_monitor,
)
from plant_bench.errors import InputError
from plant_bench.runner.episode.jobs import episode_name
from plant_bench.runner.run.score_run import Run as OpenRun
from plant_bench.runner.run.score_run import ScoreRequest
from plant_bench.runner.run.summary_files import write_summary
from plant_bench.scoring.penalties import penalty_scheme_of
from plant_bench.scoring.relevance import RelativeScore, relative_score
from plant_bench.scoring.results import EpisodeResult
from plant_bench.user_code import contained

EXPERT, FILTERED = "expert", "expert-filtered"


@dataclass(frozen=True)
class RelevanceRequest:
    """Arguments of an RFDS computation.

    Attributes:
        agent: The planner whose ranking is scored; None if no ranker needs a planner.
        rankers: Names in `RANKERS`; if empty, the planner's own ranking, or masking if it has none.
        episodes: The episodes to drive; its `agent` is replaced.
        out: Folder with a sub-folder for each run; None for `reports/<run name>`.
    """

    agent: str | None
    rankers: Sequence[str]
    episodes: ScoreRequest
    out: Path | None

    def rankings(self) -> list[str]:
        """Return the arguments of `FilteredExpert`, one per ranker: "ranker" or "ranker:planner".

        Raises:
            InputError: A ranker is unknown, or requires a planner and there is none.
        """
        agent = self.agent
        names = self.rankers or ([] if agent is None else [_best_ranker(agent)])
        if not names or (agent is None and set(names) & set(PLANNER_RANKERS)):
            message = "Expected --agent, the planner whose ranking is scored."
            raise InputError(message)
        if unknown := [name for name in names if name not in RANKERS]:
            message = f"There is no ranker '{unknown[0]}'. Rankers: {', '.join(RANKERS)}."
            raise InputError(message)
        return [
            f"{name}:{agent}" if name in PLANNER_RANKERS else name for name in dict.fromkeys(names)
        ]

    def checksum(self, ranker: str) -> str:
        """Return the checksum of the planner; empty if the ranker uses none."""
        if self.agent is None or ranker not in PLANNER_RANKERS:
            return ""
        return agent_checksum(self.agent)

    def folder(self, name: str) -> Path | None:
        """Return the folder of a ranker's run; None for the default of `plant-bench score`."""
        return None if self.out is None else self.out / name


@dataclass(frozen=True)
class RelevanceResult:
    """RFDS of each ranker, and the runs that it was computed from.

    Attributes:
        scores: RFDS by ranker.
        runs: The runs; first the one of the unfiltered expert.
    """

    scores: Mapping[str, RelativeScore]
    runs: Sequence[OpenRun]


def rfds(
    planner: PlannerLike | None = None,
    *,
    rankers: Sequence[str] = (),
    suite: str | os.PathLike[str] = "longest6",
    routes: str | None = None,
    repetitions: int = 3,
    seed: int = 0,
    density: str = "dense",
    hazards: bool = True,
    workers: int | None = None,
    out: str | os.PathLike[str] | None = None,
    overwrite: bool = False,
    penalties: str = "lb1.0",
    on_event: Listener | None = None,
) -> dict[str, RelativeScore]:
    """Score how well a planner ranks vehicles by relevance; return RFDS in percent by ranker.

    At each decision the expert sees only the vehicle that ranks highest. RFDS is its driving score
    in percent of that of the expert that sees all vehicles.

    Args:
        planner: The planner whose ranking is scored: a name, "file.py:Class", or a class of a
            module or file; None if no ranker needs a planner.
        rankers: "attention", "masking", "distance", "random", "oracle" or "none". Default: the
            planner's own ranking, or masking if it has none.
        suite: A suite's name, or a folder or file of routes.
        routes: Numbers, ranges and ids, as in "0,3-5,town02-1". Default: all routes.
        repetitions: Number of episodes on each route.
        seed: Base seed of the traffic.
        density: Traffic density.
        hazards: Whether the routes' hazards are enabled.
        workers: Number of processes. Default: one per core.
        out: Folder with a sub-folder for each run. Default: `reports/<run name>`.
        overwrite: Drive finished episodes again.
        penalties: Penalty scheme: "lb1.0" or "lb2.1".
        on_event: Called with each event of an episode: start, progress, end.

    Raises:
        InputError: The request cannot be met.
        SimulationError: Worker processes do not start.
    """
    check_episodes(repetitions, seed, workers)
    agent = None if planner is None else spec_of(planner, "rfds")
    episodes = ScoreRequest(EXPERT, os.fspath(suite), routes, repetitions, seed, density, hazards)
    request = RelevanceRequest(agent, rankers, episodes, None if out is None else Path(out))
    settings = ExecutionSettings(
        cores() if workers is None else workers,
        overwrite=overwrite,
        recordings=False,
        penalties=penalty_scheme_of(penalties),
    )
    return dict(score_relevance(request, settings, silent_monitor(on_event)).scores)


def score_relevance(
    request: RelevanceRequest, settings: ExecutionSettings, monitor: RunMonitor
) -> RelevanceResult:
    """Drive the unfiltered expert and the expert with each ranking; write the RFDS of each.

    Args:
        request: Planner, rankers and episodes.
        settings: How the runs are executed.
        monitor: Shows the progress of each run, as in `drive_missing`.

    Raises:
        PlantBenchError: A run cannot start or continue.
        KeyboardInterrupt: Ctrl-C was pressed; finished episodes are kept.
    """
    rankings = request.rankings()
    agents = {EXPERT: EXPERT} | {
        ranking.partition(":")[0]: f"{FILTERED}@{ranking}" for ranking in rankings
    }
    for agent in agents.values():
        with contained():
            load_agent(agent)  # report errors before the first run
    runs: dict[str, OpenRun] = {}
    for name, agent in agents.items():
        run = drive_missing(
            replace(request.episodes, agent=agent), request.folder(name), settings, monitor
        )
        write_summary(run.folder, penalties=settings.penalties)
        runs[name] = run
    whole = list(_results(runs[EXPERT]))
    filtered = {name: run for name, run in runs.items() if name != EXPERT}
    scores = {
        name: relative_score(
            whole,
            list(_results(run)),
            penalties=settings.penalties,
            planner_checksum=request.checksum(name),
        )
        for name, run in filtered.items()
    }
    for name, run in filtered.items():
        text = TypeAdapter(RelativeScore).dump_json(scores[name], indent=1).decode()
        run.folder.write("rfds.json", text + "\n")
    return RelevanceResult(scores, list(runs.values()))


def _best_ranker(agent: str) -> str:
    with contained():
        return ATTENTION if ranks_itself(load_agent(agent)) else MASKING


def _results(run: OpenRun) -> Iterator[EpisodeResult]:
    """Return the records of the requested episodes; the folder may hold more."""
    records = (run.folder.record(episode_name(job)) for job in run.jobs)
    return (record for record in records if record is not None)
