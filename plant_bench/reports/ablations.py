"""The table of `plant-bench ablate`, as Markdown and as CSV."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields

import pandas as pd

from plant_bench.scoring.metrics import Scores, Spread, summarise
from plant_bench.scoring.results import EpisodeResult


@dataclass(frozen=True)
class AblationRow:
    """One row.

    Attributes:
        ablation: What is compared.
        variant: One of its choices.
        training: Whose weights drove.
        scores: Over seeds of training and repetitions together.
        drives: How many of these there are.
        inference_ms: IT; nan where it was not measured.
        paper: DS in the paper.
    """

    ablation: str
    variant: str
    training: str
    scores: Scores
    drives: int
    inference_ms: float
    paper: str


def pooled_scores(runs: Sequence[Sequence[EpisodeResult]]) -> tuple[Scores, int]:
    """Return the scores over the repetitions of several runs, and how many these are.

    Args:
        runs: The episodes of each run, one run a seed of training.

    Raises:
        InputError: There are none, or they cannot be summed up.
    """
    parts = [
        summarise(part, expected=len(part)).scores
        for run in runs
        for number in sorted({item.repetition for item in run})
        if (part := [item for item in run if item.repetition == number])
    ]
    spreads = {
        item.name: Spread.of([getattr(part, item.name).mean for part in parts])
        for item in fields(Scores)
    }
    return Scores(**spreads), len(parts)


def ablation_markdown(rows: Sequence[AblationRow], facts: dict[str, str]) -> str:
    """Return the table as Markdown, after what all rows have in common; the base comes first."""
    base = rows[0].scores.driving_score.mean
    heads = ("ablation", "variant", "DS", "to base", "RC %", "IS", "CV /km", "IT ms", "paper's DS")
    return "\n".join(
        [
            "# Ablations",
            "",
            "Each variant differs from the base in one thing, and was trained and scored anew.",
            "Mean ± standard deviation over seeds of training and repetitions of driving together.",
            "",
            *(f"- {name}: {value}" for name, value in facts.items()),
            "",
            f"| {' | '.join(heads)} |",
            "|" + "---|" * len(heads),
            *(f"| {' | '.join(_cells(row, base))} |" for row in rows),
            "",
        ]
    )


def ablation_csv(rows: Sequence[AblationRow]) -> str:
    """Return the table as CSV; what is not known is empty."""
    columns = [
        {
            "ablation": row.ablation,
            "variant": row.variant,
            "training": row.training,
            "drives": row.drives,
            **{
                f"{item.name}_{part}": getattr(getattr(row.scores, item.name), part)
                for item in fields(Scores)
                for part in ("mean", "std")
            },
            "inference_ms": row.inference_ms,
        }
        for row in rows
    ]
    return pd.DataFrame(columns).to_csv(index=False, lineterminator="\n")


def _cells(row: AblationRow, base: float) -> list[str]:
    scores = row.scores
    same = " (base)" if row.variant != row.training else ""
    return [
        row.ablation,
        row.variant + same,
        _spread(scores.driving_score, 1),
        f"{scores.driving_score.mean - base:+.1f}",
        _spread(scores.route_completion, 1),
        _spread(scores.infraction_score, 2),
        _spread(scores.vehicle_collisions, 2),
        "-" if math.isnan(row.inference_ms) else f"{row.inference_ms:.2f}",
        row.paper,
    ]


def _spread(spread: Spread, digits: int) -> str:
    mean = f"{spread.mean:.{digits}f}"
    return mean if math.isnan(spread.std) else f"{mean} ± {spread.std:.{digits}f}"
