"""IT: reported forward passes are in the timings, and in no record."""

import json
import time

import pytest

from plant_bench.inference_timing import forward_pass, listen_to_passes
from plant_bench.reports.tables import inference_time, print_planner_time
from plant_bench.runner.episode.timing import Stopwatch
from plant_bench.runner.run.folder import RunFolder
from plant_bench.runner.run.speed import speed_of, write_speed


def drive(*tokens: int) -> Stopwatch:
    watch = Stopwatch()
    for count in tokens:
        with forward_pass(tokens=count):
            time.sleep(0.001)
    return watch


def test_episode_keeps_the_medians_of_its_forward_passes() -> None:
    earlier = drive(1, 1, 1)
    timing = drive(10, 12, 30).timing(1.0, 20)
    assert timing.inference_tokens == 12.0
    assert timing.inference_ms is not None
    assert timing.inference_ms >= 1.0
    assert timing.processor
    assert len(earlier.passes) == 3


def test_failed_forward_pass_is_not_recorded() -> None:
    passes = listen_to_passes()
    with pytest.raises(ValueError, match="broken"), forward_pass(tokens=3):
        raise ValueError("broken")
    assert passes == []


def test_run_reports_the_median_over_its_episodes(tmp_path, capsys) -> None:
    folder = RunFolder(tmp_path)
    folder.create()
    for name, milliseconds in (("a", 1.0), ("b", 4.0), ("c", 2.0)):
        timing = drive(14).timing(1.0, 20).model_copy(update={"inference_ms": milliseconds})
        folder.write(f"timing/{name}.json", timing.model_dump_json())
    speed = write_speed(folder, ["a", "b", "c"])
    assert inference_time(speed) == "2.00 ms at 14 tokens"
    assert json.loads((tmp_path / "speed.json").read_text())["inference_ms"] == 2.0
    print_planner_time(speed)
    said = capsys.readouterr().out
    assert "2.00 ms at 14 tokens" in said
    assert speed.processors[0][:20] in said


def test_planner_without_a_network_has_no_inference_time() -> None:
    assert inference_time(speed_of([drive().timing(1.0, 20)])) == "-"
