"""What `plant-bench rfds` does: drive the expert with and without filters, relate the scores."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import typer
from pydantic import TypeAdapter

from plant_bench.agents.loading.checksum import agent_checksum
from plant_bench.agents.loading.registry import load_agent
from plant_bench.agents.ranking.expert_filtered import (
    ATTENTION,
    MASKING,
    OF_A_PLANNER,
    RANKERS,
    ranks_itself,
)
from plant_bench.cli.drive import Driving, drive_missing, say_crashes
from plant_bench.cli.options import EXIT_INTERRUPTED
from plant_bench.errors import InputError
from plant_bench.reports.relevance import print_relative_scores
from plant_bench.runner.episode.jobs import episode_name
from plant_bench.runner.run.score_run import Run, ScoreRequest
from plant_bench.runner.run.summary import write_summary
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
        if not names or (agent is None and set(names) & set(OF_A_PLANNER)):
            message = "--agent is wanted: whose ranking shall be scored?"
            raise InputError(message)
        if unknown := [name for name in names if name not in RANKERS]:
            message = f"There is no ranker '{unknown[0]}': {', '.join(RANKERS)} are known."
            raise InputError(message)
        return [
            f"{name}:{agent}" if name in OF_A_PLANNER else name for name in dict.fromkeys(names)
        ]

    def checksum(self, ranker: str) -> str:
        """Return the content hash of the planner that ranks; empty where none does."""
        if self.agent is None or ranker not in OF_A_PLANNER:
            return ""
        return agent_checksum(self.agent)

    def folder(self, name: str) -> Path | None:
        """Return where the run of a ranker lies; None for where `plant-bench score` puts it."""
        return None if self.out is None else self.out / name


def score_relevance(request: RelevanceRequest, how: Driving) -> int:
    """Drive the expert with everybody in sight and with each ranking, and print RFDS.

    Returns:
        The exit code, as `drive`.

    Raises:
        PlantBenchError: A run cannot be started or cannot go on.
    """
    rankings = request.rankings()
    agents = {EXPERT: EXPERT} | {
        ranking.partition(":")[0]: f"{FILTERED}@{ranking}" for ranking in rankings
    }
    for agent in agents.values():
        load_agent(agent)  # better now than after the first run
    runs: dict[str, Run] = {}
    for name, agent in agents.items():
        typer.echo(f"{agent}:", err=True)
        run = drive_missing(replace(request.drives, agent=agent), request.folder(name), how)
        if run is None:
            return EXIT_INTERRUPTED
        write_summary(run.folder, law=how.law)
        runs[name] = run
    whole = list(_results(runs[EXPERT]))
    filtered = {name: run for name, run in runs.items() if name != EXPERT}
    scores = {
        name: relative_score(
            whole, list(_results(run)), law=how.law, planner_checksum=request.checksum(name)
        )
        for name, run in filtered.items()
    }
    for name, run in filtered.items():
        text = TypeAdapter(RelativeScore).dump_json(scores[name], indent=1).decode()
        run.folder.write("rfds.json", text + "\n")
    print_relative_scores(scores)
    for run in runs.values():
        typer.echo(f"Records: {run.folder.path}")
    return max(say_crashes(run) for run in runs.values())


def _best_ranker(agent: str) -> str:
    return ATTENTION if ranks_itself(load_agent(agent)) else MASKING


def _results(run: Run) -> Iterator[EpisodeResult]:
    """Return the records of what was asked for; the folder may hold more."""
    found = (run.folder.record(episode_name(job)) for job in run.jobs)
    return (result for result in found if result is not None)
