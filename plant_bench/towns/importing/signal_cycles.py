"""Bounds the cycles of an imported network's traffic lights: nobody should wait for minutes."""

import math
from collections.abc import Mapping, Sequence
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

from plant_bench.towns.importing.map_findings import Finding, repaired, reported

MAX_RED = 110.0  # s; an ego that is stationary for 180 s is blocked (`scoring.termination`)
MIN_GREEN = 5.0  # s that a shortened green phase still lasts
_GREEN, _YELLOW = "Gg", "yYuo"
_PASSABLE = "GgsoO"  # also turning on red after a stop ("s"), and signals that are off


def bound_cycles(net: str) -> tuple[str, list[Finding]]:
    """Shorten green phases of signals at which a lane would be red for more than `MAX_RED`.

    Args:
        net: The SUMO network, XML text.

    Returns:
        The network, and findings: the shortened signals, those that stay too long, and links that
        are never green.
    """
    root = ElementTree.fromstring(net)
    links = _links_of_cars(root)
    shortened, too_long, never = [], [], []
    for program in root.findall("tlLogic"):
        phases = program.findall("phase")
        name = program.get("id", "")
        never += [f"{name}: {link}" for link in _never_green(phases, links.get(name, {}))]
        is_actuated = program.get("type", "static") != "static"
        before = longest_red(phases, actuated=is_actuated)
        if before <= MAX_RED:
            continue
        _shorten(phases, actuated=is_actuated)
        after = longest_red(phases, actuated=is_actuated)
        if after < before:
            was = "no limit" if math.isinf(before) else f"{before:.0f} s"
            shortened.append(f"{name}: {was} to {after:.0f} s")
        if after > MAX_RED:
            too_long.append(f"{name}: {after:.0f} s")
    done = f"green phases shortened: some lanes were red for more than {MAX_RED:.0f} s"
    findings = repaired("signals with long red phases", done, shortened)
    findings += reported("signals that stay red for long", "the ego may be blocked", too_long)
    findings += reported(
        "signals that are never green", "the ego is blocked if its route leads there", never
    )
    return ElementTree.tostring(root, encoding="unicode") if shortened else net, findings


def longest_red(phases: Sequence[Element], *, actuated: bool = False) -> float:
    """Return the longest time that any of a program's links waits for green, seconds.

    Links that are never green do not count.

    Args:
        phases: The program.
        actuated: Whether phases last up to their `maxDur`; else they last their `duration`.
    """
    durations = [_longest(phase, actuated=actuated) for phase in phases]
    states = [phase.get("state", "") for phase in phases]
    cycle = sum(durations)
    longest = 0.0
    for link in range(min(map(len, states), default=0)):
        is_open = [state[link] in _PASSABLE for state in states]
        if not any(is_open) or all(is_open):
            continue
        first = is_open.index(True)
        waited = 0.0
        for step in range(len(states)):
            place = (first + step) % len(states)
            waited = 0.0 if is_open[place] else waited + durations[place]
            longest = max(longest, min(waited, cycle))
    return longest


def _longest(phase: Element, *, actuated: bool) -> float:
    """Return how long a phase lasts at most, seconds; with a `minDur` alone SUMO sets no limit."""
    duration = float(phase.get("duration", "0"))
    if not actuated:
        return duration
    limit = phase.get("maxDur")
    if limit is None:
        return duration if phase.get("minDur") is None else math.inf
    return float(limit)


def _links_of_cars(root: Element) -> dict[str, dict[int, str]]:
    """Return for each signal the links of its vehicle connections, by index, with their lanes."""
    links: dict[str, dict[int, str]] = {}
    for item in root.findall("connection"):
        values = item.attrib
        if "tl" in values and "linkIndex" in values and not values["from"].startswith(":"):
            index = int(values["linkIndex"])
            ends = f"{values['from']}_{values['fromLane']} to {values['to']}_{values['toLane']}"
            links.setdefault(values["tl"], {})[index] = f"link {index} ({ends})"
    return links


def _never_green(phases: Sequence[Element], links: Mapping[int, str]) -> list[str]:
    states = [phase.get("state", "") for phase in phases]
    if not states:
        return []
    return [
        name
        for index, name in sorted(links.items())
        if not any(state[index : index + 1] in tuple(_PASSABLE) for state in states)
    ]


def _shorten(phases: Sequence[Element], *, actuated: bool) -> None:
    """Scale the durations of green phases down until no link waits too long."""
    green = [phase for phase in phases if _has_green_only(phase.get("state", ""))]
    for _ in range(20):
        if longest_red(phases, actuated=actuated) <= MAX_RED:
            return
        for phase in green:
            longest = _longest(phase, actuated=actuated)
            limit = min(max(MIN_GREEN, 0.85 * longest), longest)
            if not actuated:
                phase.set("duration", f"{limit:.0f}")
                continue
            limit = min(limit, MAX_RED)
            phase.set("maxDur", f"{limit:.0f}")
            for name in ("minDur", "duration"):
                if float(phase.get(name, "0")) > limit:
                    phase.set(name, f"{limit:.0f}")


def _has_green_only(state: str) -> bool:
    return any(sign in _GREEN for sign in state) and not any(sign in _YELLOW for sign in state)
