"""RFDS: drive the expert with and without a planner's filter on its sight, relate the scores."""

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
from plant_bench.api.planners import PlannerLike, spec_of
from plant_bench.api.score import Driving, Listener, RunMonitor, drive_missing, silent_monitor
from plant_bench.errors import InputError
from plant_bench.runner.episode.jobs import episode_name
from plant_bench.runner.run.score_run import Run as OpenRun
from plant_bench.runner.run.score_run import ScoreRequest
from plant_bench.runner.run.summary_files import write_summary
from plant_bench.scoring.penalties import penalty_scheme_of
from plant_bench.scoring.relevance import RelativeScore, relative_score
from plant_bench.scoring.results import EpisodeResult

EXPERT, FILTERED = "expert", "expert-filtered"


@dataclass(frozen=True)
class RelevanceRequest:
    """What is asked for.

    Attributes:
        agent: Whose ranking is scored; None where all rankers need no planner.
        rankers: Names in `RANKERS`; empty for the planner's own ranking, or masking without one.
        drives: What is driven; its agent does not count.
        out: Folder of the runs, one sub-folder each; None for `reports/<run name>` each.
    """

    agent: str | None
    rankers: Sequence[str]
    drives: ScoreRequest
    out: Path | None

    def rankings(self) -> list[str]:
        """Return who ranks and how, as `FilteredExpert` takes it.

        Raises:
            InputError: A ranker is unknown, or wants a planner and there is none.
        """
        agent = self.agent
        names = self.rankers or ([] if agent is None else [_best_ranker(agent)])
        if not names or (agent is None and set(names) & set(PLANNER_RANKERS)):
            message = "--agent is wanted: whose ranking shall be scored?"
            raise InputError(message)
        if unknown := [name for name in names if name not in RANKERS]:
            message = f"There is no ranker '{unknown[0]}': {', '.join(RANKERS)} are known."
            raise InputError(message)
        return [
            f"{name}:{agent}" if name in PLANNER_RANKERS else name for name in dict.fromkeys(names)
        ]

    def checksum(self, ranker: str) -> str:
        """Return the content hash of the planner that ranks; empty where none does."""
        if self.agent is None or ranker not in PLANNER_RANKERS:
            return ""
        return agent_checksum(self.agent)

    def folder(self, name: str) -> Path | None:
        """Return where the run of a ranker lies; None for where `plant-bench score` puts it."""
        return None if self.out is None else self.out / name


@dataclass(frozen=True)
class Relevance:
    """What was found.

    Attributes:
        scores: RFDS by ranker.
        runs: What was driven, the expert that sees everybody first.
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
    """Return how well a planner knows which vehicle matters, by ranker: RFDS, in percent.

    The expert drives seeing, of all vehicles, only the one that ranks highest at each decision; its
    driving score is given in percent of that of the expert that sees everybody.

    Args:
        planner: Whose ranking is scored: a name, "file.py:Class", or a class of a module or file;
            None where all rankers need no planner.
        rankers: "attention", "masking", "distance", "random", "oracle", "none"; without any the
            planner's own ranking, or masking where it has none.
        suite: As of `score`, and so are all others.
        routes: Which of them.
        repetitions: Episodes on each.
        seed: Base seed of the traffic.
        density: Of the traffic.
        hazards: Whether the routes' hazards are played.
        workers: Processes.
        out: Folder of the runs, one sub-folder each.
        overwrite: Drive again what is finished.
        penalties: Makes infractions a score.
        on_event: Told of episodes that start, go on and end.

    Raises:
        InputError: The request cannot be met.
        SimulationError: Worker processes do not start.
    """
    agent = None if planner is None else spec_of(planner, "rfds")
    drives = ScoreRequest(EXPERT, os.fspath(suite), routes, repetitions, seed, density, hazards)
    request = RelevanceRequest(agent, rankers, drives, None if out is None else Path(out))
    how = Driving(
        cores() if workers is None else workers,
        overwrite=overwrite,
        recordings=False,
        penalties=penalty_scheme_of(penalties),
    )
    return dict(score_relevance(request, how, silent_monitor(on_event)).scores)


def score_relevance(request: RelevanceRequest, how: Driving, monitor: RunMonitor) -> Relevance:
    """Drive the expert with everybody in sight and with each ranking, and write each RFDS.

    Args:
        request: What is asked for.
        how: Who drives it.
        monitor: Follows each of the runs, as of `drive_missing`.

    Raises:
        PlantBenchError: A run cannot be started or cannot go on.
        KeyboardInterrupt: It was stopped; what is finished is kept.
    """
    rankings = request.rankings()
    agents = {EXPERT: EXPERT} | {
        ranking.partition(":")[0]: f"{FILTERED}@{ranking}" for ranking in rankings
    }
    for agent in agents.values():
        load_agent(agent)  # better now than after the first run
    runs: dict[str, OpenRun] = {}
    for name, agent in agents.items():
        run = drive_missing(
            replace(request.drives, agent=agent), request.folder(name), how, monitor
        )
        write_summary(run.folder, penalties=how.penalties)
        runs[name] = run
    whole = list(_results(runs[EXPERT]))
    filtered = {name: run for name, run in runs.items() if name != EXPERT}
    scores = {
        name: relative_score(
            whole,
            list(_results(run)),
            penalties=how.penalties,
            planner_checksum=request.checksum(name),
        )
        for name, run in filtered.items()
    }
    for name, run in filtered.items():
        text = TypeAdapter(RelativeScore).dump_json(scores[name], indent=1).decode()
        run.folder.write("rfds.json", text + "\n")
    return Relevance(scores, list(runs.values()))


def _best_ranker(agent: str) -> str:
    return ATTENTION if ranks_itself(load_agent(agent)) else MASKING


def _results(run: OpenRun) -> Iterator[EpisodeResult]:
    """Return the records of what was asked for; the folder may hold more."""
    found = (run.folder.record(episode_name(job)) for job in run.jobs)
    return (result for result in found if result is not None)
