"""A metric added as docs/how-to/add-a-metric.md says appears everywhere."""

import json
import math
import re

import pandas as pd
import pytest

from plant_bench.reports.leaderboard.exports import write_exports
from plant_bench.reports.leaderboard.leaderboard_page import page_html
from plant_bench.reports.tables import print_summary
from plant_bench.runner.run.folder import RunFolder
from plant_bench.runner.run.summary_files import write_summary
from plant_bench.scoring import metrics_table
from plant_bench.scoring.aggregation import RunAggregate, mean
from plant_bench.scoring.episode_measures import measure
from plant_bench.scoring.episode_metrics import EPISODE_METRICS, EpisodeMetric
from plant_bench.scoring.infractions import Status
from plant_bench.scoring.metrics_table import HIGHER, METRICS, NEITHER, measure_row, score_row
from plant_bench.scoring.results import RESULT_FORMAT, EpisodeResult
from plant_bench.scoring.trajectory import Trajectory, TrajectoryRecorder
from plant_bench.world.scene import TICK
from tests.builders import make_ego, make_scene


def mean_speed(trajectory: Trajectory) -> float:
    """Return the ego's mean speed, m/s."""
    return float(trajectory.speeds.mean())


MEASURE = measure_row("mean_speed", "mean speed", "m/s", 1, NEITHER, mean, "Mean speed of the ego.")
HEADLINE = score_row(
    "arrived",
    "ARR",
    "%",
    1,
    HIGHER,
    RunAggregate(
        "share of episodes",
        lambda results, _: (
            100.0 * sum(item.status is Status.COMPLETED for item in results) / len(results)
        ),
    ),
    "Share of the routes driven to their end.",
    title="routes arrived at (%)",
)


def driven(speed: float) -> Trajectory:
    """Return the track of an ego alone on a straight road."""
    recorder = TrajectoryRecorder()
    for tick in range(40):
        recorder.add(make_scene(tick, ego=make_ego(speed, x=speed * tick * TICK)))
    return recorder.trajectory()


def page_data(page):
    return json.loads(re.findall(r'id="data">(.*?)</script>', page, re.DOTALL)[0])


@pytest.fixture
def made(tmp_path, write_run, leaderboard, monkeypatch):
    """A run with half of its records older than the metric, its summary and its board."""
    monkeypatch.setitem(
        EPISODE_METRICS, "mean_speed", EpisodeMetric(mean_speed, since=RESULT_FORMAT + 1)
    )
    monkeypatch.setattr(metrics_table, "METRICS", (*METRICS, HEADLINE, MEASURE))
    path = write_run(tmp_path / "run")
    records = sorted((path / "episodes").iterdir())
    for number, file in enumerate(records[::2]):
        record = EpisodeResult.load(file)
        found = {
            "measures": measure(driven(5.0 + number)),
            "status": Status.COMPLETED if number else Status.BLOCKED,
        }
        file.write_text(record.model_copy(update=found).to_json(), encoding="utf-8")
    summary = write_summary(RunFolder.open(path))
    return path, summary, leaderboard([path], paper=True)


def test_new_metric_is_in_records(made):
    path, *_ = made
    new, old, *_ = (json.loads(file.read_text()) for file in RunFolder.open(path).record_files())
    assert list(new["measures"]) == [*old["measures"], "mean_speed"]
    assert new["measures"]["mean_speed"] == 5.0


def test_new_metric_is_in_the_summary(made):
    path, summary, _ = made
    told = json.loads((path / "summary.json").read_text())
    assert told["measures"]["mean_speed"] == summary.measures["mean_speed"] == pytest.approx(7.5)
    assert told["scores"]["arrived"]["mean"] == pytest.approx(100.0 * 11 / 12)
    assert told["towns"]["town01"]["arrived"]["std"] > 0.0
    frame = pd.read_csv(path / "summary.csv")
    assert frame["mean_speed"].dropna().tolist() == [5.0, 6.0, 7.0, 8.0, 9.0, 10.0]
    assert "arrived" not in frame  # no episode has it


def test_new_metric_is_printed(made, capsys):
    print_summary(made[1])
    said = capsys.readouterr().out
    assert "ARR %" in said
    assert "91.7 ± 11.8" in said
    assert re.search(r"mean speed +7\.5 m/s", said)


def test_new_metric_is_exported(made, tmp_path):
    write_exports(made[2], tmp_path)
    lines = pd.read_csv(tmp_path / "leaderboard.csv")
    arrived = dict(zip(lines["id"], lines["arrived_mean"], strict=True))
    assert arrived.pop("scripted") == pytest.approx(100.0 * 11 / 12)
    assert all(math.isnan(value) for value in arrived.values())  # the paper does not tell
    frame = pd.read_parquet(tmp_path / "episodes.parquet")
    assert frame["mean_speed"].dropna().tolist() == [5.0, 6.0, 7.0, 8.0, 9.0, 10.0]
    rows = json.loads((tmp_path / "leaderboard.json").read_text())["boards"]
    assert rows[0]["rows"][0]["arrived_std"] == pytest.approx(11.785, abs=0.001)
    assert rows[1]["rows"][0]["arrived_mean"] is None
    markdown = (tmp_path / "leaderboard.md").read_text()
    assert "ARR routes arrived at (%)" in markdown
    assert "| CV | ARR | IT |" in markdown
    assert "| 91.7 ± 11.8 |" in markdown
    assert r"\textbf{ARR} $\uparrow$" in (tmp_path / "leaderboard.tex").read_text()


def test_new_metric_is_on_the_page(made):
    data = page_data(page_html(made[2], replays=False))
    (score,) = [item for item in data["scores"] if item["name"] == "arrived"]
    assert (score["label"], score["digits"], score["better"]) == ("ARR", 1, "higher")
    assert score["about"] == "Share of the routes driven to their end."
    assert not score["ofEpisode"]
    (own, *_) = data["boards"]
    assert own["lines"][0]["scores"]["arrived"] == pytest.approx([91.667, 11.785], abs=1e-3)
    assert own["details"][0]["towns"]["town02"]["arrived"] == [100.0, 0.0]
    (column,) = [item for item in data["measures"] if item["name"] == "mean_speed"]
    assert (column["label"], column["unit"]) == ("mean speed", "m/s")
    assert own["details"][0]["measures"]["mean_speed"] == 7.5
    assert len(own["episodes"][0][0][5]) == 3  # DS, RC and IS: no episode has the new one
