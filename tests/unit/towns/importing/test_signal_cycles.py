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


ACTUATED = """<net><tlLogic id="sensed" type="actuated" programID="0" offset="0">
<phase duration="20" minDur="10" maxDur="90" state="Grr"/><phase duration="4" state="yrr"/>
<phase duration="20" minDur="10" maxDur="90" state="rGr"/><phase duration="4" state="ryr"/>
<phase duration="20" minDur="10" state="rrG"/><phase duration="4" state="rry"/></tlLogic></net>"""


def test_actuated_phases_last_up_to_their_maximum():
    two = ACTUATED.replace('minDur="10" state', 'maxDur="90" state')
    assert longest_red(phases(two)) == 20 + 4 + 20 + 4 + 4
    assert longest_red(phases(two), actuated=True) == 90 + 4 + 90 + 4 + 4
    assert longest_red(phases(SHORT), actuated=True) == longest_red(phases(SHORT))


def test_actuated_signal_is_shortened_by_its_maximum_durations():
    tight = ACTUATED.replace('minDur="10" maxDur="90"', 'minDur="80" maxDur="90"')
    net, findings = bound_cycles(tight)
    assert longest_red(phases(net), actuated=True) <= MAX_RED
    assert findings[0].examples[0].startswith("sensed: no limit to ")
    for phase in phases(net)[::2]:
        longest = float(phase.attrib["maxDur"])
        assert 5.0 <= longest <= MAX_RED
        assert float(phase.attrib["minDur"]) <= longest
        assert float(phase.attrib["duration"]) <= longest
    assert [phase.attrib for phase in phases(net)[1::2]] == [
        phase.attrib for phase in phases(tight)[1::2]
    ]


def test_turning_on_red_after_a_stop_ends_the_wait():
    states = zip((20, 60, 60, 60), "Grsr", strict=True)
    program = "".join(f'<phase duration="{time}" state="{state}"/>' for time, state in states)
    net = f'<net><tlLogic id="a">{program}</tlLogic></net>'
    assert longest_red(phases(net)) == 60
    assert bound_cycles(net) == (net, [])


def test_links_that_are_never_green_are_reported_with_signal_and_lanes():
    closed = SHORT.replace('r"/>', 'rrrs"/>').replace('y"/>', 'yrrr"/>').replace('G"/>', 'Grrr"/>')
    lanes = 'fromLane="0" toLane="1" tl="a"'
    links = f"""<connection from="in" to="out" {lanes} linkIndex="0"/>
<connection from="in" to="side" {lanes} linkIndex="2"/>
<connection from=":walk" to=":cross" {lanes} linkIndex="3"/>
<connection from="in" to="right" {lanes} linkIndex="4"/>"""
    net = closed.replace("</net>", f"{links}</net>")
    same, (finding,) = bound_cycles(net)
    assert same == net
    assert finding.what == "signals that are never green"
    assert finding.examples == ("a: link 2 (in_0 to side_1)",)
