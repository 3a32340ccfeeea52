"""Fuzzing of recordings in use: rescoring, replay, statistics and training."""

import functools
import shutil
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np

from fuzzing.data import answer_at, scene_at
from fuzzing.form import Format, used
from fuzzing.runs import put_run, run_files
from plant_bench.agents.plant.training_options import PlanTOptions
from plant_bench.data.recorder import Recorder
from plant_bench.data.statistics import describe_data, find_data_faults
from plant_bench.errors import InputError
from plant_bench.reports.replay.replay_episode import load_episode, replay_script
from plant_bench.reports.replay.replay_source import ReplaySource
from plant_bench.runner.run import rescore_run as rescoring
from plant_bench.runner.run.folder import RunFolder
from plant_bench.runner.run.rescore_run import rescore_folder
from plant_bench.scoring.infractions import Status
from plant_bench.scoring.results import EpisodeHeader, EpisodeResult
from plant_bench.towns.routes import suite_text
from plant_bench.training.encodings import load_encodings
from plant_bench.training.frame_store import load_frames
from plant_bench.training.learners import LearnerSpec
from plant_bench.world.route import Route, load_suite
from plant_bench.world.scene import EgoState, Scene

TICKS = 160


@functools.cache
def _episode() -> tuple[str, EpisodeResult]:
    name = min(name for name in run_files() if "/episodes/" in name)
    return Path(name).stem, EpisodeResult.model_validate_json(run_files()[name])


@functools.cache
def _route() -> Route:
    wanted = _episode()[1].route
    return next(route for route in load_suite("longest6") if route.id == wanted)


def drive_seeds() -> list[bytes]:
    """Return the recording of an episode's beginning, whole and thinned."""
    with tempfile.TemporaryDirectory() as place:
        path = Path(place) / "r.parquet"
        for every in (1, 10):
            about = _episode()[1].model_dump(mode="json")
            header = {name: about[name] for name in EpisodeHeader.model_fields if name in about}
            recorder = Recorder(path.with_suffix(f".{every}"), header, every=every)
            for tick in range(TICKS):
                recorder.add(_scene_on_route(tick), *answer_at(tick))
            recorder.close(hazards=[], status=Status.AGENT_CRASHED.value, reason="x")
        return [path.with_suffix(f".{every}").read_bytes() for every in (1, 10)]


def _scene_on_route(tick: int) -> Scene:
    """Return a scene whose ego is on the route, a decimetre farther with each tick."""
    route, scene = _route(), scene_at(tick)
    (x, y), yaw = route.points[tick // 10], route.headings[tick // 10]
    ego = EgoState(float(x), float(y), float(yaw), 2.0, 0.0, 0.0)
    lights = np.zeros(len(route.signal_passages), np.uint8)
    return replace(scene, ego=ego, lights=lights)


def _use_drive(box: Path) -> None:
    """Do all that is done with recordings; one of them at least must work."""
    refusals = []
    for use in (_rescore, _replay, describe_data, find_data_faults, _make_samples):
        try:
            use(box if use in (_rescore, _replay) else _data_of(box))
        except InputError as error:
            refusals.append(error)
    if len(refusals) > 3:  # faults that are found are no refusal
        raise refusals[0]


def _rescore(box: Path) -> None:
    name, _ = _episode()
    shutil.copyfile(box / "r.parquet", box / "run" / "recordings" / f"{name}.parquet")
    for episode in rescore_folder(RunFolder(box / "run")):
        used(episode.equal)


def _replay(box: Path) -> None:
    name, result = _episode()
    source = ReplaySource(f"run/{name}", "stranger", result.agent, box / "r.parquet", result)
    replay_script(load_episode(source))


def _make_samples(data: Path) -> None:
    for made in ("frames", "encoded"):
        shutil.rmtree(data / made, ignore_errors=True)
    load_encodings(load_frames([data]), LearnerSpec("plant", PlanTOptions()))


def _data_of(box: Path) -> Path:
    shutil.copyfile(box / "r.parquet", box / "data" / "episodes" / "r.parquet")
    return box / "data"


def _put_run_and_data(box: Path) -> None:
    rescoring.load_suite = functools.cache(load_suite)  # ours, which is not what is broken here
    put_run(box)
    (box / "run" / "recordings").mkdir()
    (box / "data" / "episodes").mkdir(parents=True)
    (box / "data" / "routes").mkdir()
    text = suite_text({"suite": "f"}, [_route()])
    (box / "data" / "routes" / "r.json").write_text(text, encoding="utf-8")


FORMATS = (Format("drive", "parquet", "r.parquet", drive_seeds, _use_drive, _put_run_and_data),)
