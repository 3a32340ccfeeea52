"""The result table of `plant-bench ablate`, as Markdown and as CSV."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import pandas as pd

from plant_bench.scoring.metrics import Scores, Spread, summarise
from plant_bench.scoring.metrics_table import RANKED, headline_metrics, score_metrics
from plant_bench.scoring.results import EpisodeResult


@dataclass(frozen=True)
class AblationRow:
    """One row of the table.

    Attributes:
        ablation: Name of the ablation.
        variant: Name of the variant.
        training: Name of the training whose weights drove.
        scores: Scores over training seeds and repetitions together.
        drives: Number of these seeds and repetitions.
        inference_ms: Inference time (IT), ms; nan if not measured.
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
    """Return the scores over the repetitions of several runs, and the number of repetitions.

    Args:
        runs: The episodes of each run; one run per training seed.

    Raises:
        InputError: There are none, or they cannot be summarised.
    """
    parts = [
        summarise(part, expected=len(part)).scores
        for run in runs
        for number in sorted({item.repetition for item in run})
        if (part := [item for item in run if item.repetition == number])
    ]
    spreads = {
        metric.name: Spread.of([part[metric.name].mean for part in parts])
        for metric in score_metrics()
    }
    return spreads, len(parts)


def ablation_markdown(rows: Sequence[AblationRow], facts: dict[str, str]) -> str:
    """Return the table as Markdown, after the facts common to all rows; row 1 is the base."""
    base = rows[0].scores[RANKED].mean
    scores = [f"{metric.label} {metric.unit}".strip() for metric in headline_metrics()]
    scores.insert(1, "to base")
    heads = ("ablation", "variant", *scores, "IT ms", "paper's DS")
    return "\n".join(
        [
            "# Ablations",
            "",
            "Each variant differs from the base in one setting, and was trained and scored anew.",
            "Mean ± standard deviation over training seeds and driving repetitions together.",
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
    """Return the table as CSV; unknown values are empty."""
    columns = [
        {
            "ablation": row.ablation,
            "variant": row.variant,
            "training": row.training,
            "drives": row.drives,
            **{
                f"{metric.name}_{part}": getattr(row.scores[metric.name], part)
                for metric in score_metrics()
                for part in ("mean", "std")
            },
            "inference_ms": row.inference_ms,
        }
        for row in rows
    ]
    return pd.DataFrame(columns).to_csv(index=False, lineterminator="\n")


def _cells(row: AblationRow, base: float) -> list[str]:
    scores = [row.scores[metric.name].text(metric.digits) for metric in headline_metrics()]
    scores.insert(1, f"{row.scores[RANKED].mean - base:+.1f}")
    same = " (base)" if row.variant != row.training else ""
    return [
        row.ablation,
        row.variant + same,
        *scores,
        "-" if math.isnan(row.inference_ms) else f"{row.inference_ms:.2f}",
        row.paper,
    ]
