"""What `plant-bench why` prints of an episode: each incident, its last seconds and a verdict."""

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
from plant_bench.reports.why.verdicts import reason_text, subject, verdict
from plant_bench.runner.review.review_frames import Moment, Postmortem
from plant_bench.scoring.results import EpisodeResult
from plant_bench.text_escaping import one_line
from plant_bench.world.scene import Light

ROWS = 9  # of the table of an incident
TOP = 3  # of a ranking that are shown
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
    """Print one incident: what happened, what was seen, the last seconds, the verdict."""
    _console.print(Text(incident_line(finding, postmortem.result), style="bold red"))
    _console.print(Padding(Text(surroundings(finding, postmortem)), (0, 0, 0, 3)))
    if finding.moments:
        _console.print(Padding(_seconds_table(finding), (0, 0, 0, 1)))
    _console.print(Padding(Text(verdict(finding, postmortem), style="yellow"), (0, 0, 0, 3)))


def episode_line(result: EpisodeResult) -> str:
    """Return what an episode is and how it ended."""
    reason = f" ({one_line(result.reason)})" if result.reason else ""
    return (
        f"{one_line(result.agent)} on {one_line(result.route)}, repetition {result.repetition}: "
        f"DS {result.driving_score:.1f}, RC {result.route_completion:.1f} %, "
        f"IS {result.infraction_score:.3f}, {result.status.value}{reason}"
    )


def again_line(postmortem: Postmortem) -> str:
    """Return whether the simulator came to the recorded scenes again."""
    if postmortem.differs_at is None:
        return f"Simulated again: all {postmortem.ticks:,} scenes equal the recorded ones."
    return (
        f"Simulated again: from tick {postmortem.differs_at:,} of {postmortem.ticks:,} on it is "
        f"another episode ({postmortem.difference}); from there on the expert is not asked."
    )


def incident_line(finding: Finding, result: EpisodeResult) -> str:
    """Return what happened, when, where, and with whom."""
    item = finding.incident.infraction
    whom = "" if item.actor is None else f": {_who_hit_whom(finding)}"
    return (
        f"{finding.incident.number}. {KIND_NAMES[item.kind]} at {item.time:.2f} s{whom}, "
        f"{item.progress:.0f} m along the route of {result.route_length:.0f} m "
        f"(x {item.x:.1f}, y {item.y:.1f})"
    )


def surroundings(finding: Finding, postmortem: Postmortem) -> str:
    """Return what there was to see at the beginning of the last seconds, and the hazards then."""
    if not finding.moments:
        return "Nothing of it was looked at."
    moment = _near(finding)
    seen, light = moment.seen, moment.seen.light
    parts = [f"{len(moment.scene.actors)} others in sight", f"limit {seen.speed_limit:.1f} m/s"]
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
    """Return where the route goes at the next junction, or at the one that the ego is on."""
    route = moment.seen.route
    at = 0.0 if route is None else route.progress
    for item in postmortem.route.passages:
        if item.exit > at:
            way = "straight on" if item.turn == "straight" else f"{item.turn} turn"
            left = item.entry - at
            return [f"{way} on this junction" if left <= 0.0 else f"{way} in {left:.0f} m"]
    return []


def spread_moments(finding: Finding, rows: int = ROWS) -> list[Moment]:
    """Return so many moments of a finding, evenly spread, the incident the last."""
    moments = finding.moments
    count = min(rows, len(moments))
    if count < 2:
        return list(moments)
    return [moments[round(place * (len(moments) - 1) / (count - 1))] for place in range(count)]


def _near(finding: Finding) -> Moment:
    """Return the moment at the beginning of the seconds in which the planner's ranking is asked."""
    start = finding.incident.window.ranked_from
    return next((item for item in finding.moments if item.scene.tick >= start), finding.moments[-1])


def _who_hit_whom(finding: Finding) -> str:
    item = finding.incident.infraction
    assert item.actor is not None  # noqa: S101  only asked then
    name = actor_name(item.actor, item.actor_kind)
    return f"{name} ran into the ego" if item.cause == "other" else f"the ego ran into {name}"


def _seconds_table(finding: Finding) -> Table:
    table = Table(box=SIMPLE_HEAD, pad_edge=False)
    table.add_column("before", justify="right")
    table.add_column("m/s", justify="right")
    table.add_column("planner m/s2", justify="right")
    table.add_column("ranks first, or why")
    table.add_column("expert m/s2", justify="right")
    table.add_column("because of")
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
    """Return whom the planner ranks first, and where the one hit ranks if not among these.

    A planner without a ranking that explains itself tells its reason.
    """
    planner = moment.planner
    ranking = None if planner is None else planner.ranking
    if not ranking:
        return reason_text(None if planner is None else planner.reason, finding.kinds)
    names = [actor_name(actor, finding.kinds.get(actor)) for actor in ranking[:TOP]]
    foe = finding.incident.infraction.actor
    if foe in ranking[TOP:]:
        names.append(f"... {foe} as number {ranking.index(foe) + 1}")
    return ", ".join(names)


def _distance(moment: Moment, finding: Finding) -> str:
    foe = finding.incident.infraction.actor
    if foe is not None:
        gap = gap_to(moment.scene, foe)
        return "out of sight" if gap is None else f"{gap:.1f}"
    if finding.red_light is None:
        return ""
    state, distance = finding.red_light.seen_at(moment)
    return f"{distance:.1f} ({state.name.lower()})"
