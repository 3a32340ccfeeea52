import math

import pandas as pd
import pytest

from plant_bench.errors import InputError
from plant_bench.scoring.infractions import InfractionKind, Status
from plant_bench.scoring.metrics import Spread, summarise, summary_frame


def test_driving_score_is_the_mean_of_products_not_the_product_of_means(episode):
    results = [
        episode(0, completion=1.0, kinds=("collision_vehicle",)),
        episode(1, completion=0.5),
    ]
    scores = summarise(results, expected=2).scores
    assert scores.driving_score.mean == pytest.approx((60.0 + 50.0) / 2)
    assert scores.route_completion.mean == pytest.approx(75.0)
    assert scores.infraction_score.mean == pytest.approx(0.8)


def test_collisions_per_km_are_all_counts_over_all_kilometres(episode):
    results = [
        episode(0, length=500.0, kinds=("collision_vehicle", "collision_vehicle")),
        episode(1, length=3000.0, completion=0.5, kinds=("collision_pedestrian",)),
    ]
    summary = summarise(results, expected=2)
    assert summary.km == pytest.approx(2.0)
    assert summary.scores.vehicle_collisions.mean == pytest.approx(1.0)
    assert summary.infractions_per_km[InfractionKind.COLLISION_PEDESTRIAN] == pytest.approx(0.5)
    assert summary.infractions_per_km[InfractionKind.RED_LIGHT] == 0.0


def test_a_rate_is_finite_for_who_never_left(episode):
    stuck = episode(completion=0.0, kinds=("collision_vehicle",))
    rate = summarise([stuck], expected=1).scores.vehicle_collisions.mean
    assert rate == pytest.approx(1000.0)


def test_kilometres_outside_the_lanes(episode):
    summary = summarise([episode(share=0.25), episode(1, length=3000.0)], expected=2)
    assert summary.infractions_per_km[InfractionKind.OUTSIDE_LANES] == pytest.approx(0.25 / 4)


def test_spread_is_over_repetitions(episode):
    results = [episode(route, 0) for route in range(3)]
    results += [episode(route, 1, completion=0.9) for route in range(3)]
    score = summarise(results, expected=6).scores.driving_score
    assert score.mean == pytest.approx(95.0)
    assert score.std == pytest.approx(10.0 / math.sqrt(2.0))


def test_one_repetition_has_no_spread(episode):
    score = summarise([episode(0), episode(1, completion=0.2)], expected=2).scores.driving_score
    assert math.isnan(score.std)


def test_sample_standard_deviation():
    assert Spread.of([1.0, 2.0, 3.0]) == Spread(2.0, 1.0)


def test_towns(episode):
    summary = summarise([episode(0), episode(1, completion=0.2)], expected=2)
    assert list(summary.towns) == ["town01", "town02"]
    assert summary.towns["town02"].driving_score.mean == pytest.approx(20.0)


def test_statuses_and_blocked_routes(episode):
    results = [
        episode(0, 0),
        episode(1, 0, status=Status.BLOCKED),
        episode(0, 1, status=Status.BLOCKED),
        episode(1, 1, status=Status.BLOCKED),
        episode(0, 2, status=Status.AGENT_CRASHED),
    ]
    summary = summarise(results, expected=6)
    assert summary.statuses == {Status.COMPLETED: 1, Status.BLOCKED: 3, Status.AGENT_CRASHED: 1}
    assert summary.blocked == (1, 2, 0)
    assert (summary.episodes, summary.expected, summary.complete) == (5, 6, False)


def test_share_of_collisions_that_the_ego_caused(episode):
    results = [
        episode(
            0, kinds=("collision_vehicle", "red_light", "collision_static", "collision_static")
        ),
        episode(1, kinds=("collision_pedestrian",), cause="other"),
    ]
    assert summarise(results, expected=2).ego_share == pytest.approx(0.75)
    assert math.isnan(summarise([episode()], expected=1).ego_share)


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"agent": "another"}, "two agents"),
        ({"agent_checksum": "f" * 64}, "two agents"),
        ({"protocol": "longest6-sumo-v1"}, "two protocols"),
        ({"scenario": "0-0"}, "2 times"),
    ],
)
def test_what_must_not_be_mixed(episode, changed, message):
    with pytest.raises(InputError, match=message):
        summarise([episode(0), episode(1, **changed)], expected=2)


def test_nothing_to_sum_up():
    with pytest.raises(InputError, match="No episodes"):
        summarise([], expected=36)


def test_frame_has_a_row_for_each_episode(episode):
    results = [
        episode(2, kinds=("collision_vehicle", "red_light"), cause="other", share=0.1),
        episode(0, 1),
        episode(0, 0, status=Status.AGENT_CRASHED, reason="no plan"),
    ]
    frame = summary_frame(results)
    assert list(frame["route"]) == ["town01-0", "town01-0", "town01-2"]
    assert list(frame["repetition"]) == [0, 1, 0]
    last = frame.iloc[-1]
    assert last["driving_score"] == pytest.approx(100.0 * 0.6 * 0.7 * 0.9)
    assert (last["collision_vehicle"], last["red_light"], last["caused_by_other"]) == (1, 1, 1)
    assert last["outside_share"] == pytest.approx(0.1)
    assert frame.iloc[0]["reason"] == "no plan"
    assert frame.to_csv() == summary_frame(results[::-1]).to_csv()


def test_frame_of_nothing():
    assert isinstance(summary_frame([]), pd.DataFrame)
