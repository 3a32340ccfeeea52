import math

import pandas as pd
import pytest

from plant_bench.errors import InputError
from plant_bench.scoring.infractions import InfractionKind, Status
from plant_bench.scoring.metrics import Spread, summarise, summary_frame
from plant_bench.scoring.penalties import PenaltyScheme
from plant_bench.scoring.results import HazardRecord
from plant_bench.world.hazard import HazardKind, Phase
from plant_bench.world.scene import ActorKind

MEASURES = {
    "ttc_vehicle": 2.0,
    "ttc_vulnerable": None,
    "pet_vehicle": 1.0,
    "pet_vulnerable": None,
    "hard_brakes": 3,
    "hard_brake_share": 0.1,
    "jerk_p95": 2.0,
    "lateral_acceleration_p95": 3.0,
    "relative_speed": 0.8,
    "standing_share": 0.2,
    "off_lane_distance": 10.0,
    "wrong_lane_distance": 30.0,
}


def test_driving_score_is_the_mean_of_products_not_the_product_of_means(episode):
    results = [
        episode(0, completion=1.0, kinds=("collision_vehicle",)),
        episode(1, completion=0.5),
    ]
    scores = summarise(results, expected=2).scores
    assert scores["driving_score"].mean == pytest.approx((60.0 + 50.0) / 2)
    assert scores["route_completion"].mean == pytest.approx(75.0)
    assert scores["infraction_score"].mean == pytest.approx(0.8)


def test_collisions_per_km_are_total_counts_per_total_kilometres(episode):
    results = [
        episode(0, length=500.0, kinds=("collision_vehicle", "collision_vehicle")),
        episode(1, length=3000.0, completion=0.5, kinds=("collision_pedestrian",)),
    ]
    summary = summarise(results, expected=2)
    assert summary.km == pytest.approx(2.0)
    assert summary.scores["vehicle_collisions"].mean == pytest.approx(1.0)
    assert summary.infractions_per_km[InfractionKind.COLLISION_PEDESTRIAN] == pytest.approx(0.5)
    assert summary.infractions_per_km[InfractionKind.RED_LIGHT] == 0.0


def test_rate_is_finite_without_any_distance(episode):
    stuck = episode(completion=0.0, kinds=("collision_vehicle",))
    rate = summarise([stuck], expected=1).scores["vehicle_collisions"].mean
    assert rate == pytest.approx(1000.0)


def test_distance_outside_the_lanes_is_summed(episode):
    summary = summarise([episode(share=0.25), episode(1, length=3000.0)], expected=2)
    assert summary.infractions_per_km[InfractionKind.OUTSIDE_LANES] == pytest.approx(0.25 / 4)


def test_standard_deviation_is_over_repetitions(episode):
    results = [episode(route, 0) for route in range(3)]
    results += [episode(route, 1, completion=0.9) for route in range(3)]
    score = summarise(results, expected=6).scores["driving_score"]
    assert score.mean == pytest.approx(95.0)
    assert score.std == pytest.approx(10.0 / math.sqrt(2.0))


def test_one_repetition_has_no_standard_deviation(episode):
    score = summarise([episode(0), episode(1, completion=0.2)], expected=2).scores["driving_score"]
    assert math.isnan(score.std)


def test_standard_deviation_is_the_sample_one():
    assert Spread.of([1.0, 2.0, 3.0]) == Spread(2.0, 1.0)


def test_scores_are_summarised_per_town(episode):
    summary = summarise([episode(0), episode(1, completion=0.2)], expected=2)
    assert list(summary.towns) == ["town01", "town02"]
    assert summary.towns["town02"]["driving_score"].mean == pytest.approx(20.0)


def test_hazards_are_counted_by_outcome(episode):
    met = HazardRecord(kind=HazardKind.CROSSING, at=50.0, phase=Phase.DONE, time=9.0, reason="")
    void = HazardRecord(kind=HazardKind.CUT_IN, at=90.0, phase=Phase.VOID, time=12.0, reason="far")
    results = [episode(0).model_copy(update={"hazards": (met, void)}), episode(1)]
    assert summarise(results, expected=2).hazards == {Phase.DONE: 1, Phase.VOID: 1}


def test_statuses_and_blocked_routes_are_counted(episode):
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
        ({"protocol": "longest6-sumo-v0"}, "two protocols"),
        ({"scenario": "0-0"}, "2 times"),
    ],
)
def test_records_of_different_settings_are_not_mixed(episode, changed, message):
    with pytest.raises(InputError, match=message):
        summarise([episode(0), episode(1, **changed)], expected=2)


def test_summary_of_no_records_is_refused():
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


def test_frame_of_no_episodes_is_empty():
    assert isinstance(summary_frame([]), pd.DataFrame)


def test_penalty_scheme_changes_the_scores_and_is_named(episode):
    results = [episode(0, kinds=("collision_vehicle",) * 2, length=2000.0)]
    summary = summarise(results, expected=1, penalties=PenaltyScheme.LB2_1)
    assert summary.penalties is PenaltyScheme.LB2_1
    assert summary.scores["driving_score"].mean == pytest.approx(100.0 / 2.4)
    assert summary.scores["normalised_score"].mean == pytest.approx(100.0 / 1.7)
    row = summary_frame(results, penalties=PenaltyScheme.LB2_1).iloc[0]
    assert (row["penalties"], row["driving_score"]) == ("lb2.1", pytest.approx(100.0 / 2.4))
    assert summarise(results, expected=1).penalties is PenaltyScheme.LB1_0
    assert summary_frame(results).iloc[0]["normalised_score"] == pytest.approx(60.0)


def test_cyclists_and_motorcyclists_count_as_vehicles_and_separately(episode):
    hit = episode(kinds=("collision_vehicle",) * 3).infractions
    kinds = (ActorKind.BICYCLE, ActorKind.MOTORCYCLE, ActorKind.CAR)
    marked = [
        item.model_copy(update={"actor_kind": kind}) for item, kind in zip(hit, kinds, strict=True)
    ]
    result = episode(infractions=marked, length=500.0)
    row = summary_frame([result]).iloc[0]
    assert row["collision_vehicle"] == 3
    assert (row["collisions_cyclist"], row["collisions_motorcyclist"]) == (1, 1)
    summary = summarise([result], expected=1)
    assert summary.cyclists_per_km == pytest.approx(2.0)
    assert summary.scores["vehicle_collisions"].mean == pytest.approx(6.0)


def test_safety_metrics_are_summarised_over_episodes(episode):
    changed = {"ttc_vehicle": None, "hard_brakes": 0, "standing_share": 0.5, "jerk_p95": None}
    other = MEASURES | changed
    results = [
        episode(0, measures=MEASURES, duration=100.0),
        episode(1, measures=other, duration=200.0, length=3000.0),
        episode(2, measures=MEASURES | {"ttc_vehicle": 4.0}, duration=0.0),
        episode(3),
    ]
    beyond = summarise(results, expected=4).measures
    assert beyond.episodes == 3
    assert (beyond["ttc_vehicle"], beyond["ttc_vulnerable"]) == (4.0, math.inf)
    assert beyond["hard_brakes_per_km"] == pytest.approx(6 / 5)
    assert beyond["standing_share"] == pytest.approx((0.2 * 100 + 0.5 * 200) / 300)
    assert (beyond["jerk_p95"], beyond["pet_vehicle"]) == (2.0, 1.0)
    assert beyond["wrong_lane_per_km"] == pytest.approx(0.09 / 5)


def test_old_records_have_no_safety_metrics(episode):
    beyond = summarise([episode(0)], expected=1).measures
    assert beyond.episodes == 0
    assert math.isnan(beyond["ttc_vehicle"])
    assert math.isnan(beyond["hard_brakes_per_km"])
    assert math.isnan(beyond["standing_share"])


def test_episode_metrics_are_columns_of_the_frame(episode):
    frame = summary_frame([episode(0, measures=MEASURES), episode(1)])
    assert frame["hard_brakes"].iloc[0] == 3
    assert frame["wrong_lane_distance"].iloc[0] == 30.0
    assert frame["ttc_vehicle"].isna().tolist() == [False, True]


def test_summary_has_the_detectable_difference_of_repetitions(episode):
    results = [episode(0, r, completion=c) for r, c in enumerate((0.5, 0.6, 0.7))]
    detectable = summarise(results, expected=3).detectable
    assert detectable is not None
    assert detectable.deviation == pytest.approx(10.0)
    assert summarise(results[:1], expected=1).detectable is None
