"""Tables of collected data, for the terminal and for the data card."""

from collections.abc import Mapping

from plant_bench.data.statistics import NEARBY, SPEED_STEP, DataStatistics
from plant_bench.reports.tables import print_rows

Row = tuple[str, str]


def print_data(data: DataStatistics, *, answers: bool = False) -> None:
    """Print all tables of a folder of data; see `data_tables`."""
    for title, head, rows in data_tables(data, answers=answers):
        print_rows(title, [head, "value" if head == "what" else "count"], rows)


def data_tables(data: DataStatistics, *, answers: bool = False) -> list[tuple[str, str, list[Row]]]:
    """Return each table's title, head and rows.

    Args:
        data: The statistics to show.
        answers: Whether another planner drove and the expert's actions were recorded (DAgger).
    """
    return [
        ("Data", "what", data_overview(data, answers=answers)),
        ("Speed (frames)", "km/h", _bins(data.speeds, SPEED_STEP)),
        ("Manoeuvres driven", "manoeuvre", _counts(data.turns)),
        ("Hazards triggered", "hazard", _counts(data.hazards)),
        ("Frames by town", "town", _counts(data.towns)),
        ("Frames by kind of route", "kind", _counts(data.routes)),
    ]


def data_overview(data: DataStatistics, *, answers: bool = False) -> list[Row]:
    """Return the rows of the overview table."""
    otherwise = [
        ("episodes with perturbations", f"{data.disturbed_episodes:,}"),
        ("frames during a perturbation", f"{data.disturbed_share:.1%}"),
    ]
    if answers:
        otherwise = [("frames not driven as the expert", f"{data.disturbed_share:.1%}")]
    return [
        ("episodes", f"{data.episodes:,}"),
        ("frames at 2 Hz", f"{data.frames:,}"),
        ("hours", f"{data.hours:.2f}"),
        ("km", f"{data.km:.1f}"),
        ("time stationary", f"{data.standing_share:.0%}"),
        (f"actors within {NEARBY:.0f} m", f"{data.nearby_mean:.1f}"),
        *otherwise,
        ("size of the recordings", f"{data.megabytes:.1f} MB"),
    ]


def _counts(counts: Mapping[str, int]) -> list[Row]:
    return [(name.replace("_", " "), f"{number:,}") for name, number in counts.items()]


def _bins(counts: tuple[int, ...], step: float) -> list[Row]:
    last = max((place for place, number in enumerate(counts) if number), default=-1)
    return [
        (f"{place * step:.0f} to {(place + 1) * step:.0f}", f"{counts[place]:,}")
        for place in range(last + 1)
    ]
