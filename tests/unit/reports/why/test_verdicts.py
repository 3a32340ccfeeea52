"""Verdicts on an incident: when the expert and the planner braked, and for which actor."""

from dataclasses import replace

import pytest

from plant_bench.agent import NO_ACTOR, Cause, Control, Reason
from plant_bench.reports.why.incident_findings import find, gap_to
from plant_bench.reports.why.verdicts import verdict
from plant_bench.scoring.infractions import InfractionKind
from plant_bench.world.scene import Light
from tests.unit.reports.why.moments_by_hand import (
    BYSTANDER,
    FOE,
    HIT,
    braking_from,
    infraction,
    lights,
    moment,
    postmortem,
    scene,
)

WINDOW = range(HIT - 60, HIT + 1)


def said(moments, item=None, **changes):
    incident, looked = postmortem(item or infraction(), moments, **changes)
    return verdict(find(incident, looked), looked)


def test_first_braking_for_the_hit_actor_is_given_with_its_share():
    flickers = braking_from(HIT - 30)
    moments = [moment(tick, flickers if tick != HIT - 10 else braking_from(999)) for tick in WINDOW]

    text = said(moments)

    assert (
        "The expert would have braked for car 17 from 1.5 s before (30 of 31 decisions, -3.5 m/s2 "
        "at the hardest)." in text
    )
    assert "The planner never braked half as hard." in text


def test_braking_since_the_window_start_is_given_as_or_earlier():
    text = said([moment(tick, braking_from(0)) for tick in WINDOW])

    assert "from 3.0 s before or earlier (61 of 61 decisions" in text


def test_gentle_deceleration_is_not_reported_as_braking():
    gently = [moment(tick, lambda _: (-0.4, Reason(Cause.LEADER, FOE))) for tick in WINDOW]

    assert "The expert would not have braked for car 17 in these 3.0 s." in said(gently)


def test_braking_for_another_actor_is_reported_separately():
    moments = [moment(tick, braking_from(HIT - 20, BYSTANDER)) for tick in WINDOW]

    text = said(moments)

    assert "would not have braked for car 17 in these 3.0 s, but from 1.0 s before" in text
    assert "(conflict: pedestrian 500001)" in text


def test_held_response_counts_as_one_decision():
    moments = [moment(tick, braking_from(HIT - 20)) for tick in WINDOW]
    held = [
        replace(one, expert=moments[place - place % 2].expert) for place, one in enumerate(moments)
    ]

    assert "(11 of 11 decisions" in said(held)


def test_braking_of_the_planner_is_timed():
    moments = [moment(tick, braking_from(HIT - 40)) for tick in WINDOW]
    late = [
        replace(one, control=Control(-6.0, 0.0)) if one.scene.tick >= HIT - 8 else one
        for one in moments
    ]

    assert "The planner braked at least half as hard from 0.4 s before (-6.0 m/s2)." in said(late)
    gently = [replace(one, control=Control(-1.0, 0.0)) for one in moments]
    assert "The planner never braked half as hard." in said(gently)
    free = [replace(one, expert=moment(0, braking_from(99)).expert) for one in gently]
    assert "The planner braked from 3.0 s before (-1.0 m/s2)." in said(free)


def test_stationary_ego_is_not_reported_as_braking():
    stood = [
        moment(tick, braking_from(HIT - 40), speed=0.0, control=Control(-1.0, 0.0))
        for tick in WINDOW
    ]

    assert "The planner never braked half as hard. The ego was stationary for 2.1 s." in said(stood)


@pytest.mark.parametrize(
    ("ranking", "words"),
    [
        ((BYSTANDER, FOE), "It had car 17 among its first 3 in 21 of 21 decisions."),
        ((1, 2, 3, FOE), "It did not rank car 17 among its first 3 (number 4 at best)."),
        ((1, 2), "It did not rank car 17 among its first 3."),
    ],
)
def test_ranking_is_judged_from_the_start_of_the_experts_braking(ranking, words):
    def ranked(tick):
        return (FOE,) if tick < HIT - 20 else ranking

    moments = [moment(tick, braking_from(HIT - 20), ranking=ranked(tick)) for tick in WINDOW]

    assert words in said(moments)


def test_masked_and_unknown_rankings_are_labelled():
    moments = [moment(tick, braking_from(HIT - 20)) for tick in WINDOW]
    unasked = [replace(one, planner=None) for one in moments]

    assert "decisions (by masking)." in said(moments, ranked_itself=False)
    text = said(unasked, planner_note="its code has changed")
    assert text.endswith("Its ranking is not known: its code has changed.")


def test_expert_that_could_not_be_queried_is_not_mentioned():
    moments = [replace(moment(tick, braking_from(0)), expert=None) for tick in WINDOW]

    text = said(moments, expert_note="simulated again, the ego differ")

    assert text.startswith("What the expert would have done is not known: simulated again")
    assert "would have braked" not in text


def test_red_light_time_is_measured_from_the_change():
    state = lights(HIT - 30)
    moments = [
        moment(tick, braking_from(HIT - 44, NO_ACTOR, Cause.LIGHT), light=state(tick))
        for tick in WINDOW
    ]

    text = said(moments, infraction(InfractionKind.RED_LIGHT))

    assert (
        "The light had been red for 1.5 s when the rear crossed its line; the front had crossed it "
        "0.8 s before, at red." in text
    )
    assert "The expert would have braked for the light from 2.2 s before" in text
    always = [moment(tick, braking_from(0), light=Light.RED) for tick in WINDOW]
    assert "red for 3.0 s or longer when" in said(always, infraction(InfractionKind.RED_LIGHT))


def test_blocked_episode_names_the_obstacle_and_the_expert_action():
    def waits(tick):
        return (1.0, None) if tick == 30 else (-1.0, Reason(Cause.LEADER, FOE))

    stood = [moment(tick, waits, speed=0.0) for tick in range(HIT + 1)]

    text = said(stood, infraction(InfractionKind.BLOCKED))

    assert "Car 17 is 3." in text
    assert "m ahead on the route" in text
    assert f"The expert would have driven on in 1 of {HIT + 1} decisions." in text
    assert f"Its most frequent reason to wait: leader: car 17 ({HIT} decisions)." in text


def test_outside_lanes_verdict_gives_the_share():
    item = infraction(InfractionKind.OUTSIDE_LANES, share=0.0123)

    assert said([moment(HIT, braking_from(0))], item).startswith("1.23% of the distance")


def test_gap_is_between_boxes_and_absent_out_of_sight():
    assert gap_to(scene(0), FOE) == pytest.approx(60.1 - 20.0 - 2.25 - 2.45, abs=1e-3)
    assert gap_to(scene(HIT), FOE) == 0.0
    assert gap_to(scene(0), 999) is None


def test_front_crossing_at_green_is_reported():
    def state(tick):
        return Light.GREEN if tick < HIT - 4 else Light.RED

    moments = [moment(tick, braking_from(999), light=state(tick)) for tick in WINDOW]

    text = said(moments, infraction(InfractionKind.RED_LIGHT))
    assert "red for 0.2 s when the rear" in text
    assert "the front had crossed it 0.8 s before, at green." in text
    late = [one for one in moments if one.scene.tick > HIT - 10]
    assert "crossed it more than 3.0 s before." in said(late, infraction(InfractionKind.RED_LIGHT))
