"""Text output of `plant-bench why`: each incident, a table of its last seconds, and a verdict."""

import sys
from collections.abc import Iterable, Sequence

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.padding import Padding
from rich.table import Table
from rich.text import Text

from plant_bench.reports.tables import PIPED_WIDTH
from plant_bench.reports.why.incident_findings import Finding, gap_to
from plant_bench.reports.why.incidents import KIND_NAMES, actor_name
from plant_bench.reports.why.time_use import TimeUse
from plant_bench.reports.why.verdicts import reason_text, stop_reason, subject, verdict
from plant_bench.runner.review.review_frames import Moment, Postmortem
from plant_bench.scoring.results import EpisodeResult
from plant_bench.text_escaping import one_line
from plant_bench.world.scene import Light

ROWS = 9  # of an incident's table
TOP = 3  # actors of a ranking that are shown
_console = Console(
    highlight=False, markup=False, emoji=False, width=None if sys.stdout.isatty() else PIPED_WIDTH
)


def print_episode(
    postmortem: Postmortem, findings: Iterable[Finding], suite_note: str = ""
) -> None:
    """Print an episode's incidents."""
    result = postmortem.result
    _console.print(Text(episode_line(result), style="bold"))
    _console.print(Text(again_line(postmortem) + suite_note, style="dim"))
    for finding in findings:
        _console.print()
        print_finding(finding, postmortem)


def print_finding(finding: Finding, postmortem: Postmortem) -> None:
    """Print one incident: what happened, the surroundings, the last seconds, the verdict."""
    _console.print(Text(incident_line(finding, postmortem.result), style="bold red"))
    _console.print(Padding(Text(surroundings(finding, postmortem)), (0, 0, 0, 3)))
    if finding.time_use is not None:
        _console.print(Padding(_stops_table(finding.time_use), (0, 0, 0, 1)))
    elif finding.moments:
        _console.print(Padding(_seconds_table(finding), (0, 0, 0, 1)))
    _console.print(Padding(Text(verdict(finding, postmortem), style="yellow"), (0, 0, 0, 3)))


def episode_line(result: EpisodeResult) -> str:
    """Return a line with the episode's agent, route, scores and status."""
    reason = f" ({one_line(result.reason)})" if result.reason else ""
    return (
        f"{one_line(result.agent)} on {one_line(result.route)}, repetition {result.repetition}: "
        f"DS {result.driving_score:.1f}, RC {result.route_completion:.1f} %, "
        f"IS {result.infraction_score:.3f}, {result.status.value}{reason}"
    )


def again_line(postmortem: Postmortem) -> str:
    """Return a line that says whether the resimulation reproduced the recorded scenes."""
    if postmortem.differs_at is None:
        return f"Simulated again: all {postmortem.ticks:,} scenes equal the recorded ones."
    return (
        f"Simulated again: differs from the recording from tick {postmortem.differs_at:,} of "
        f"{postmortem.ticks:,} on ({postmortem.difference}); no decisions of the expert after that."
    )


def incident_line(finding: Finding, result: EpisodeResult) -> str:
    """Return a line that says what happened, when and where, and which actor was involved."""
    item = finding.incident.infraction
    whom = "" if item.actor is None else f": {_who_hit_whom(finding)}"
    return (
        f"{finding.incident.number}. {KIND_NAMES[item.kind]} at {item.time:.2f} s{whom}, "
        f"{item.progress:.0f} m along the route of {result.route_length:.0f} m "
        f"(x {item.x:.1f}, y {item.y:.1f})"
    )


def surroundings(finding: Finding, postmortem: Postmortem) -> str:
    """Return a line on the surroundings at the start of the last seconds, and recent hazards."""
    if not finding.moments:
        return "No moments of it were evaluated."
    moment = _near(finding)
    seen, light = moment.seen, moment.seen.light
    parts = [f"{len(moment.scene.actors)} actors in sight", f"limit {seen.speed_limit:.1f} m/s"]
    parts += _junction(moment, postmortem)
    if light is not None and light.state is not Light.UNKNOWN:
        parts.append(f"light {light.state.name.lower()}, {light.distance:.0f} m to its line")
    time = finding.incident.infraction.time
    near = [
        f"{item.kind.value.replace('_', ' ')} ({item.phase.value} at {item.time:.1f} s)"
        for item in postmortem.result.hazards
        if time - finding.incident.seconds - 10.0 <= item.time <= time
    ]
    hazards = f". Hazards shortly before: {', '.join(near)}" if near else ""
    before = finding.incident.before(moment.scene.tick)
    return f"{before:.1f} s before: {', '.join(parts)}{hazards}."


def _junction(moment: Moment, postmortem: Postmortem) -> list[str]:
    """Return the route's turn at the current or next junction; empty if there is none."""
    route = moment.seen.route
    at = 0.0 if route is None else route.progress
    for item in postmortem.route.passages:
        if item.exit > at:
            way = "straight on" if item.turn == "straight" else f"{item.turn} turn"
            left = item.entry - at
            return [f"{way} at this junction" if left <= 0.0 else f"{way} in {left:.0f} m"]
    return []


def spread_moments(finding: Finding, rows: int = ROWS) -> list[Moment]:
    """Return up to `rows` moments of a finding, evenly spaced and ending with the incident."""
    moments = finding.moments
    count = min(rows, len(moments))
    if count < 2:
        return list(moments)
    return [moments[round(place * (len(moments) - 1) / (count - 1))] for place in range(count)]


def _near(finding: Finding) -> Moment:
    """Return the first moment of the period in which the planner's ranking is evaluated."""
    start = finding.incident.window.ranked_from
    return next((item for item in finding.moments if item.scene.tick >= start), finding.moments[-1])


def _who_hit_whom(finding: Finding) -> str:
    item = finding.incident.infraction
    assert item.actor is not None  # noqa: S101  checked by the caller
    name = actor_name(item.actor, item.actor_kind)
    return f"{name} ran into the ego" if item.cause == "other" else f"the ego ran into {name}"


def _stops_table(use: TimeUse) -> Table:
    """Return a table of the longest stops."""
    table = Table(box=SIMPLE_HEAD, pad_edge=False, title="Longest stops", title_justify="left")
    for head in ("from", "seconds", "m along the route"):
        table.add_column(head, justify="right")
    table.add_column("planner's reason" if use.recorded else "close ahead")
    for stop in use.stops[:ROWS]:
        kinds = {} if stop.kind is None else {stop.reason.actor: stop.kind}
        cells = (f"{stop.start:.1f} s", f"{stop.seconds:.1f}", f"{stop.progress:.0f}")
        table.add_row(*map(Text, cells), Text(stop_reason(stop.reason, kinds)))
    return table


def _seconds_table(finding: Finding) -> Table:
    table = Table(box=SIMPLE_HEAD, pad_edge=False)
    table.add_column("before", justify="right")
    table.add_column("m/s", justify="right")
    table.add_column("planner m/s2", justify="right")
    table.add_column("planner's top ranks or reason")
    table.add_column("expert m/s2", justify="right")
    table.add_column("expert's reason")
    what = subject(finding)
    table.add_column(f"to {what}, m" if what else "", justify="right")
    for moment in spread_moments(finding):
        table.add_row(*(Text(cell) for cell in _cells(moment, finding)))
    return table


def _cells(moment: Moment, finding: Finding) -> Sequence[str]:
    expert = moment.expert
    return (
        f"{finding.incident.before(moment.scene.tick):.1f} s",
        f"{moment.scene.ego.speed:.1f}",
        f"{moment.control.acceleration:+.1f}",
        _top(moment, finding),
        "-" if expert is None else f"{expert.control.acceleration:+.1f}",
        "-" if expert is None else reason_text(expert.reason, finding.kinds),
        _distance(moment, finding),
    )


def _top(moment: Moment, finding: Finding) -> str:
    """Return the planner's top-ranked actors, and the rank of the actor hit if it is lower.

    Without a ranking, it is the planner's reason, if it gave one: the recorded one, which does not
    depend on the planner's present code.
    """
    planner = moment.planner
    ranking = None if planner is None else planner.ranking
    if not ranking:
        reason = moment.reason or (None if planner is None else planner.reason)
        return reason_text(reason, finding.kinds)
    names = [actor_name(actor, finding.kinds.get(actor)) for actor in ranking[:TOP]]
    hit = finding.incident.infraction.actor
    if hit in ranking[TOP:]:
        names.append(f"... {hit} as number {ranking.index(hit) + 1}")
    return ", ".join(names)


def _distance(moment: Moment, finding: Finding) -> str:
    hit = finding.incident.infraction.actor
    if hit is not None:
        gap = gap_to(moment.scene, hit)
        return "out of sight" if gap is None else f"{gap:.1f}"
    if finding.red_light is None:
        return ""
    state, distance = finding.red_light.seen_at(moment)
    return f"{distance:.1f} ({state.name.lower()})"
