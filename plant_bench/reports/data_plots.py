"""Plots of collected data, as PNG files."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from matplotlib.figure import Figure

from plant_bench.atomic_files import whole_file
from plant_bench.data.statistics import NEARBY, SPEED_STEP, DataStatistics

SIZE, DPI = (7.0, 4.0), 120
COLOUR = "#3b6ea5"


def save_data_plots(data: DataStatistics, folder: Path) -> list[Path]:
    """Save all plots of a folder of data and return their paths.

    Args:
        data: The statistics to plot.
        folder: Output folder; created if missing.
    """
    folder.mkdir(parents=True, exist_ok=True)
    speeds = [f"{SPEED_STEP * place:.0f}" for place in range(len(data.speeds))]
    nearby = [str(number) for number in range(len(data.nearby))]
    standing = f"stationary in {data.standing_share:.0%} of all frames"
    figures = {
        "speeds": _columns(speeds, data.speeds, f"speed, km/h from ({standing})"),
        "actors": _columns(nearby, data.nearby, f"actors within {NEARBY:.0f} m of the ego"),
        "manoeuvres": _bars(data.turns, "manoeuvres driven"),
        "hazards": _bars(data.hazards, "hazards triggered"),
        "towns": _bars(data.towns, "frames by town"),
        "routes": _bars(data.routes, "frames by kind of route"),
    }
    for name, figure in figures.items():
        with whole_file(folder / f"{name}.png") as part:
            figure.savefig(part, format="png", dpi=DPI, metadata={"Software": ""})
    return [folder / f"{name}.png" for name in figures]


def _columns(labels: Sequence[str], counts: Sequence[int], title: str) -> Figure:
    last = max((place for place, number in enumerate(counts) if number), default=0) + 1
    figure = Figure(SIZE, layout="constrained")
    axes = figure.subplots()
    axes.bar(labels[:last], counts[:last], width=0.9, color=COLOUR)
    axes.set(xlabel=title, ylabel="frames at 2 Hz")
    axes.tick_params(axis="x", labelrotation=90 if last > 20 else 0)
    axes.spines[["top", "right"]].set_visible(False)
    return figure


def _bars(counts: Mapping[str, int], title: str) -> Figure:
    figure = Figure(SIZE, layout="constrained")
    axes = figure.subplots()
    names = [name.replace("_", " ") for name in counts]
    bars = axes.barh(names, list(counts.values()), color=COLOUR)
    axes.bar_label(bars, fmt="{:,.0f}", padding=3)
    axes.invert_yaxis()
    axes.set(xlabel=title)
    axes.margins(x=0.12)
    axes.spines[["top", "right"]].set_visible(False)
    return figure
