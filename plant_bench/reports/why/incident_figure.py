"""Figure of an incident: top views of the moments before it, with speed and acceleration plots."""

import textwrap
from functools import lru_cache
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties, findfont, get_font
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from plant_bench.atomic_files import write_whole
from plant_bench.reports.why.incident_findings import Finding
from plant_bench.reports.why.incident_text import episode_line, incident_line, spread_moments
from plant_bench.reports.why.incidents import actor_name
from plant_bench.reports.why.top_view import (
    EGO,
    EXPERTS,
    INK,
    OTHER,
    PLAN,
    ROUTE,
    TOP,
    WALKER,
    draw_moment,
)
from plant_bench.reports.why.verdicts import verdict
from plant_bench.runner.review.review_frames import Moment, Postmortem

PANELS = 4
SIZE_IN = (13.0, 9.6)
DOTS = 110  # per inch
LINE = 150  # characters of text
OWN = "#495057"


def save_picture(finding: Finding, postmortem: Postmortem, path: Path) -> None:
    """Draw an incident into a PNG file, written atomically.

    Raises:
        OSError: It cannot be written.
    """
    figure = _figure(finding, postmortem)
    write_whole(
        path,
        lambda part: figure.savefig(part, format="png", dpi=DOTS, metadata={"Software": None}),
    )


def _figure(finding: Finding, postmortem: Postmortem) -> Figure:
    figure = Figure(figsize=SIZE_IN, layout="constrained")
    FigureCanvasAgg(figure)
    lines = [
        _plain(episode_line(postmortem.result)),
        _plain(incident_line(finding, postmortem.result)),
        *textwrap.wrap(_plain(verdict(finding, postmortem)), LINE),
    ]
    figure.suptitle("\n".join(lines), x=0.01, ha="left", fontsize=10, color=INK)
    top, below = np.ravel(figure.subfigures(2, 1, height_ratios=(2.3, 1.0)))  # pyright: ignore
    shown = spread_moments(finding, PANELS)
    for ax, moment in zip(top.subplots(1, PANELS).ravel(), shown, strict=False):
        draw_moment(ax, moment, finding, postmortem)
        before = finding.incident.before(moment.scene.tick)
        ax.set_title(f"{before:.1f} s before" if before else "then", fontsize=10)
    for ax in top.axes[len(shown) :]:
        ax.set_axis_off()
    top.legend(handles=_legend(), loc="outside lower center", ncols=9, fontsize=8, frameon=False)
    speeds, accelerations = below.subplots(1, 2)
    _draw_speeds(speeds, finding)
    _draw_accelerations(accelerations, finding)
    for ax in (speeds, accelerations):
        _frame(ax, finding, shown)
    return figure


@lru_cache(maxsize=1)
def _drawable() -> frozenset[int]:
    """Return the code points that matplotlib's font has."""
    return frozenset(get_font(findfont(FontProperties())).get_charmap())


def _plain(text: str) -> str:
    """Return text that matplotlib shows unchanged: dollar signs escaped, missing glyphs as '?'."""
    known = "".join(letter if ord(letter) in _drawable() else "?" for letter in text)
    return known.replace("$", r"\$")


def _legend() -> list[Patch | Line2D]:
    return [
        Patch(fc=EGO, ec=INK, label="ego"),
        Patch(fc=TOP, label="planner ranks first"),
        Patch(fc="white", ec=EXPERTS, lw=3, label="expert brakes for"),
        Patch(fc="white", ec=INK, hatch="//////", label="the one hit"),
        Patch(fc=OTHER, label="vehicle"),
        Patch(fc=WALKER, label="pedestrian"),
        Line2D([], [], color=INK, lw=1, ls="--", label="where it went"),
        Line2D([], [], color=PLAN, marker="o", label="plan"),
        Line2D([], [], color=ROUTE, lw=3, alpha=0.55, label="route"),
    ]


def _times(finding: Finding) -> np.ndarray:
    incident = finding.incident
    return np.array([-incident.before(moment.scene.tick) for moment in finding.moments])


def _draw_speeds(ax: Axes, finding: Finding) -> None:
    times, item = _times(finding), finding.incident.infraction
    egos = [moment.scene.ego.speed for moment in finding.moments]
    ax.plot(times, egos, color=OWN, lw=2.0, label="ego")
    if item.actor is not None:
        speeds = [_speed_of(moment, item.actor) for moment in finding.moments]
        name = actor_name(item.actor, item.actor_kind)
        ax.plot(times, speeds, color=INK, lw=1.5, ls="--", label=name)
    ax.set_ylabel("speed, m/s")
    ax.set_ylim(bottom=0.0)


def _speed_of(moment: Moment, actor: int) -> float:
    speeds = moment.scene.actors.speeds[moment.scene.actors.ids == actor]
    return float(speeds[0]) if len(speeds) else np.nan


def _draw_accelerations(ax: Axes, finding: Finding) -> None:
    times = _times(finding)
    asked = [moment.control.acceleration for moment in finding.moments]
    experts = [
        np.nan if moment.expert is None else moment.expert.control.acceleration
        for moment in finding.moments
    ]
    ax.plot(times, asked, color=OWN, lw=1.8, drawstyle="steps-post", label="planner asks for")
    ax.plot(times, experts, color=EXPERTS, lw=1.8, drawstyle="steps-post", label="expert would")
    ax.axhline(0.0, color=INK, lw=0.6)
    if finding.expert is not None:
        ax.axvline(-finding.expert.before, color=EXPERTS, lw=1.0, ls=":")
    ax.set_ylabel("acceleration, m/s2")
    ax.set_ylim(-9.5, 5.5)


def _frame(ax: Axes, finding: Finding, shown: list[Moment]) -> None:
    for moment in shown:
        ax.axvline(-finding.incident.before(moment.scene.tick), color="#dee2e6", lw=6, zorder=0)
    ax.set_xlim(-finding.incident.seconds, 0.02 * finding.incident.seconds)
    ax.set_xlabel("seconds before")
    ax.spines[["top", "right"]].set_visible(False)
    ax.legend(loc="best", fontsize=8, frameon=False)
