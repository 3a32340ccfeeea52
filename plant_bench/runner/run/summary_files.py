"""Writes `summary.json` and `summary.csv`, which depend on a run's records alone."""

from collections.abc import Sequence

from pydantic import TypeAdapter

from plant_bench.runner.run.folder import RunFolder, sorted_results
from plant_bench.scoring.metrics import Summary, summarise, summary_frame
from plant_bench.scoring.penalties import PenaltyScheme
from plant_bench.scoring.results import EpisodeResult


def write_summary(
    folder: RunFolder, *, missing: int = 0, penalties: PenaltyScheme = PenaltyScheme.LB1_0
) -> Summary:
    """Aggregate all records of a run and write the summary beside them.

    Args:
        folder: Folder of the run.
        missing: Number of requested episodes without a record.
        penalties: Penalty scheme.

    Raises:
        InputError: There are no records, or they cannot be aggregated.
    """
    return _write(folder, "", folder.results(), missing, penalties)


def write_rescored_summary(
    folder: RunFolder,
    results: Sequence[EpisodeResult],
    *,
    missing: int = 0,
    penalties: PenaltyScheme = PenaltyScheme.LB1_0,
) -> Summary:
    """Write the summary of `rescore_folder`'s records into `rescored/`; as `write_summary`."""
    return _write(folder, "rescored/", results, missing, penalties)


def summary_texts(
    results: Sequence[EpisodeResult],
    *,
    missing: int = 0,
    penalties: PenaltyScheme = PenaltyScheme.LB1_0,
) -> dict[str, str]:
    """Return the summary's files by name; equal records give equal text, in any order.

    Raises:
        InputError: There are no records, or they cannot be aggregated.
    """
    ordered = sorted_results(results)
    return _texts(summarise(ordered, expected=len(results) + missing, penalties=penalties), ordered)


def _write(
    folder: RunFolder,
    subfolder: str,
    results: Sequence[EpisodeResult],
    missing: int,
    penalties: PenaltyScheme,
) -> Summary:
    summary = summarise(results, expected=len(results) + missing, penalties=penalties)
    for name, text in _texts(summary, results).items():
        folder.write(f"{subfolder}{name}", text)
    return summary


def _texts(summary: Summary, results: Sequence[EpisodeResult]) -> dict[str, str]:
    table = summary_frame(results, penalties=summary.penalties).to_csv(
        index=False, lineterminator="\n"
    )
    text = TypeAdapter(Summary).dump_json(summary, indent=1).decode()
    return {"summary.json": text + "\n", "summary.csv": table}
