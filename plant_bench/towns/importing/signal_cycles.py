"""Bounds the cycles of an imported network's traffic lights: nobody should wait for minutes."""

from collections.abc import Sequence
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

from plant_bench.towns.importing.map_findings import Finding, repaired, reported

MAX_RED = 110.0  # s; an ego that is stationary for 180 s is blocked (`scoring.termination`)
MIN_GREEN = 5.0  # s that a shortened green phase still lasts
_GREEN, _YELLOW = "Gg", "yYuo"


def bound_cycles(net: str) -> tuple[str, list[Finding]]:
    """Shorten green phases of signals at which a lane would be red for more than `MAX_RED`.

    Args:
        net: The SUMO network, XML text.

    Returns:
        The network, and findings: the shortened signals, and those that stay too long.
    """
    root = ElementTree.fromstring(net)
    shortened, too_long = [], []
    for program in root.findall("tlLogic"):
        phases = program.findall("phase")
        before = longest_red(phases)
        if before <= MAX_RED:
            continue
        _shorten(phases)
        name = program.get("id", "")
        after = longest_red(phases)
        if after < before:
            shortened.append(f"{name}: {before:.0f} s to {after:.0f} s")
        if after > MAX_RED:
            too_long.append(f"{name}: {after:.0f} s")
    if not shortened and not too_long:
        return net, []
    done = f"green phases shortened: some lanes were red for more than {MAX_RED:.0f} s"
    findings = repaired("signals with long red phases", done, shortened)
    findings += reported("signals that stay red for long", "the ego may be blocked", too_long)
    return ElementTree.tostring(root, encoding="unicode"), findings


def longest_red(phases: Sequence[Element]) -> float:
    """Return the longest time that any of a program's links waits for green, seconds."""
    durations = [float(phase.get("duration", "0")) for phase in phases]
    states = [phase.get("state", "") for phase in phases]
    cycle = sum(durations)
    longest = 0.0
    for link in range(min(map(len, states), default=0)):
        is_open = [state[link] in _GREEN for state in states]
        if not any(is_open):
            continue  # never green in the map: a link that is closed on purpose
        if all(is_open) or any(state[link] in "oO" for state in states):
            continue
        first = is_open.index(True)
        waited = 0.0
        for step in range(len(states)):
            place = (first + step) % len(states)
            waited = 0.0 if is_open[place] else waited + durations[place]
            longest = max(longest, min(waited, cycle))
    return longest


def _shorten(phases: Sequence[Element]) -> None:
    """Scale the durations of green phases down until no link waits too long."""
    green = [phase for phase in phases if _has_green_only(phase.get("state", ""))]
    for _ in range(20):
        if longest_red(phases) <= MAX_RED:
            return
        for phase in green:
            duration = max(MIN_GREEN, 0.85 * float(phase.get("duration", "0")))
            phase.set("duration", f"{min(duration, float(phase.get('duration', '0'))):.0f}")


def _has_green_only(state: str) -> bool:
    return any(sign in _GREEN for sign in state) and not any(sign in _YELLOW for sign in state)
