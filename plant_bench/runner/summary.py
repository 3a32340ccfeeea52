"""`summary.json` and `summary.csv`: derived from a run's records and nothing else."""

from pydantic import TypeAdapter

from plant_bench.runner.run_folder import RunFolder
from plant_bench.scoring.metrics import Summary, summarise, summary_frame


def write_summary(folder: RunFolder, *, missing: int = 0) -> Summary:
    """Sum up all records of a run and write the summary beside them.

    Args:
        folder: The run.
        missing: Episodes that were asked for and have no record.

    Raises:
        InputError: There are no records, or they cannot be summed up.
    """
    results = folder.results()
    summary = summarise(results, expected=len(results) + missing)
    text = TypeAdapter(Summary).dump_json(summary, indent=1).decode()
    folder.write("summary.json", text + "\n")
    folder.write("summary.csv", summary_frame(results).to_csv(index=False, lineterminator="\n"))
    return summary
