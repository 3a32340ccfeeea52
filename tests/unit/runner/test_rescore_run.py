"""Rescored runs with untrusted recordings."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from plant_bench.data.recorder import Recorder
from plant_bench.errors import InputError
from plant_bench.runner.episode.jobs import episode_name, make_jobs
from plant_bench.runner.run.folder import RunFolder
from plant_bench.runner.run.provenance import provenance
from plant_bench.runner.run.rescore_run import rescore_folder
from plant_bench.scoring.infractions import Status
from plant_bench.scoring.results import EpisodeResult
from plant_bench.world.route import load_suite
from tests.builders import make_ego, make_scene


def recorded(path: Path, step: float) -> RunFolder:
    """A run of one episode whose ego moves `step` metres each tick until its planner crashes."""
    suite = load_suite("longest6")
    folder = RunFolder(path)
    folder.create()
    told: dict[str, Any] = {
        "suite": "longest6",
        "seed": 0,
        "density": "dense",
        "hazards": True,
        "repetitions": 1,
    }
    made = provenance("stranger", "a" * 64, suite, **told)
    folder.write("run.json", made.model_dump_json(indent=1) + "\n")
    jobs = make_jobs("stranger", "a" * 64, suite[:1], repetitions=1, seed=0, density="dense")
    header = jobs[0].header(frozenset()).model_dump(mode="json")
    numbers: dict[str, Any] = dict.fromkeys(("route_length", "distance", "duration"), 1.0) | {
        "completion": 0.0
    }
    ended = {"status": Status.AGENT_CRASHED, "reason": "x"}
    result = EpisodeResult.model_validate(header | numbers | ended)
    folder.save(episode_name(jobs[0]), result, None)
    recorder = Recorder(folder.recording_path(episode_name(jobs[0])), header)
    (x, y), route = suite[0].points[0], suite[0]
    ego = make_ego(x=float(x), y=float(y), yaw=float(route.headings[0]))
    for tick in range(3):
        lights = np.zeros(len(route.signal_passages), np.uint8)
        moved = replace(ego, x=ego.x + step * tick)
        recorder.add(make_scene(tick, ego=moved, lights=lights))
    recorder.close(hazards=[], status=Status.AGENT_CRASHED.value, reason="x")
    return folder


def test_a_recording_is_scored(tmp_path):
    (episode,) = rescore_folder(recorded(tmp_path / "run", 0.1))

    assert episode.again is not None
    assert episode.again.distance == pytest.approx(0.2)
    assert not episode.equal
    assert episode.first_difference.startswith("route_length 1.0, now 1125.96")


def test_recording_with_invalid_values_is_refused(tmp_path):
    with pytest.raises(InputError, match=r"Cannot score .*distance.*drive the episode again"):
        list(rescore_folder(recorded(tmp_path / "run", 1e30)))
