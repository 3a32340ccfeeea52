"""Cycles of imported traffic lights are bounded."""

from xml.etree import ElementTree

from plant_bench.towns.importing.signal_cycles import MAX_RED, bound_cycles, longest_red

LONG = """<net><tlLogic id="joined" type="static" programID="0" offset="0">
<phase duration="60" state="Grrr"/><phase duration="4" state="yrrr"/>
<phase duration="60" state="rGrr"/><phase duration="4" state="ryrr"/>
<phase duration="60" state="rrGr"/><phase duration="4" state="rryr"/>
<phase duration="60" state="rrrG"/><phase duration="4" state="rrry"/></tlLogic></net>"""
SHORT = """<net><tlLogic id="a"><phase duration="30" state="Gr"/><phase duration="5" state="yr"/>
<phase duration="30" state="rG"/><phase duration="5" state="ry"/></tlLogic></net>"""


def phases(net: str) -> list[ElementTree.Element]:
    return ElementTree.fromstring(net).findall("tlLogic/phase")


def test_longest_red_counts_all_phases_between_two_greens_of_a_link():
    assert longest_red(phases(LONG)) == 3 * 64 + 4
    assert longest_red(phases(SHORT)) == 40


def test_long_cycle_is_shortened_and_yellow_phases_are_kept():
    net, findings = bound_cycles(LONG)
    assert longest_red(phases(net)) <= MAX_RED
    assert [phase.get("duration") for phase in phases(net)][1::2] == ["4"] * 4
    assert [finding.what for finding in findings] == ["signals with long red phases"]
    assert findings[0].examples[0].startswith("joined: 196 s to ")


def test_short_cycle_is_unchanged():
    assert bound_cycles(SHORT) == (SHORT, [])


def test_cycle_that_cannot_be_shortened_enough_is_reported():
    greens = "".join(
        f'<phase duration="6" state="{"r" * place}G{"r" * (29 - place)}"/>' for place in range(30)
    )
    _, findings = bound_cycles(f'<net><tlLogic id="huge">{greens}</tlLogic></net>')
    assert findings[-1].what == "signals that stay red for long"
