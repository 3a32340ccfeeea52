"""The metrics table agrees with records, documentation and keys."""

import math
import re
from pathlib import Path

import grimp
import pytest
from pydantic import ValidationError

from plant_bench.scoring.aggregation import mean, median, per_km, share_of_time
from plant_bench.scoring.episode_measures import Measures
from plant_bench.scoring.episode_metrics import EPISODE_METRICS, EpisodeMetric
from plant_bench.scoring.metrics import summarise
from plant_bench.scoring.metrics_table import (
    METRICS,
    RANKED,
    headline_metrics,
    measure_metrics,
    metrics_markdown,
    score_metrics,
)
from plant_bench.scoring.penalties import PenaltyScheme
from plant_bench.scoring.results import RESULT_FORMAT, EpisodeResult

DOCS = Path(__file__).parents[3] / "docs" / "reference" / "metrics.md"


def test_table_rows_and_episode_metrics_correspond():
    columns = dict.fromkeys(metric.column for metric in measure_metrics() if metric.column)
    assert list(columns) == list(EPISODE_METRICS)


def test_metric_names_and_labels_are_unique():
    for values in ([item.name for item in METRICS], [item.label for item in METRICS]):
        assert len(set(values)) == len(values)


def test_boards_are_sorted_by_the_first_column():
    assert headline_metrics()[0].name == score_metrics()[0].name == RANKED


@pytest.mark.parametrize(
    ("part", "metrics"), [("scores", score_metrics()), ("measures", measure_metrics())]
)
def test_documentation_contains_the_metrics_table(part, metrics):
    """If it fails, paste the output of `metrics_markdown` into the page."""
    text = DOCS.read_text(encoding="utf-8")
    (found,) = re.findall(rf"<!-- {part} -->\n(.*?)\n<!-- end -->", text, re.DOTALL)
    assert found == metrics_markdown(metrics)


def test_records_and_keys_do_not_depend_on_run_level_modules():
    """The loop imports the referee and records: what they import is in an episode's key."""
    graph = grimp.build_graph("plant_bench")
    room = "plant_bench.scoring"
    of_episodes = {f"{room}.referee", f"{room}.results"}
    for module in tuple(of_episodes):
        of_episodes |= graph.find_upstream_modules(module)
    assert f"{room}.episode_metrics" in of_episodes
    of_runs = {
        "metrics_table",
        "aggregation",
        "metrics",
        "comparison",
        "normalised_score",
        "hazard_outcomes",
    }
    assert not of_episodes & {f"{room}.{name}" for name in of_runs}


def test_unknown_episode_metrics_are_refused_by_name():
    with pytest.raises(ValidationError, match="unknown measures: ttc_bus; expected ttc_vehicle, "):
        Measures.model_validate_json('{"ttc_bus": 1.0}')
    with pytest.raises(KeyError, match="ttc_bus"):
        Measures({})["ttc_bus"]


@pytest.mark.parametrize("value", ["2.5", "true", '"many"', f"1{'0' * 400}", "NaN"])
def test_count_that_is_not_a_whole_number_is_refused(value):
    if value == "true":
        assert Measures.model_validate_json('{"hard_brakes": true}')["hard_brakes"] == 1
        return
    with pytest.raises(ValidationError):
        Measures.model_validate_json(f'{{"hard_brakes": {value}}}')


def test_types_and_order_follow_the_table():
    read = Measures.model_validate_json(
        '{"off_lane_distance": 10, "hard_brakes": 3.0, "ttc_vehicle": null}'
    )
    assert read.model_dump_json() == (
        '{"ttc_vehicle":null,"hard_brakes":3,"off_lane_distance":10.0}'
    )
    assert hash(read) == hash(Measures.model_validate_json(read.model_dump_json()))


def test_metrics_missing_in_old_records_are_none_and_ignored(episode):
    old = episode(0, measures={"hard_brakes": 2}, length=1000.0)
    new = episode(1, measures={"hard_brakes": 6, "jerk_p95": 2.0, "ttc_vehicle": None})
    assert old.measures is not None
    assert old.measures["jerk_p95"] is None
    assert "jerk_p95" not in old.measures
    assert EpisodeResult.model_validate_json(old.to_json()).to_json() == old.to_json()
    both = [old, new]
    assert per_km("hard_brakes").compute(both, PenaltyScheme.LB1_0) == pytest.approx(4.0)
    assert mean("jerk_p95").compute(both, PenaltyScheme.LB1_0) == 2.0
    assert median("ttc_vehicle").compute(both, PenaltyScheme.LB1_0) == math.inf
    assert math.isnan(median("pet_vehicle").compute(both, PenaltyScheme.LB1_0))
    assert math.isnan(share_of_time("standing_share").compute(both, PenaltyScheme.LB1_0))
    assert summarise(both, expected=2).measures.episodes == 2


def test_newer_metric_is_omitted_from_an_older_format(episode, monkeypatch):
    """This keeps rescored older records identical."""
    newer = EpisodeMetric(lambda trajectory: 0.0, since=RESULT_FORMAT + 1)
    monkeypatch.setitem(EPISODE_METRICS, "newer", newer)
    monkeypatch.setattr("plant_bench.scoring.results.RESULT_FORMAT", RESULT_FORMAT + 1)
    measures = {"hard_brakes": 2}
    before = episode(measures=measures)
    after = before.model_copy(
        update={"format": RESULT_FORMAT + 1, "measures": Measures(measures | {"newer": 1.0})}
    )
    assert after.to_json() != before.to_json()
    assert after.as_format(RESULT_FORMAT).to_json() == before.to_json()
    assert after.as_format(1).measures is None
