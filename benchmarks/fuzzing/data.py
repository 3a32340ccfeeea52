"""Fuzzing of collected data and recordings: valid files and their readers."""

import tempfile
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from fuzzing.form import Format, used
from fuzzing.worlds import first_metres
from plant_bench.agent import Cause, Control, Plan, Reason
from plant_bench.data.recorder import Recorder
from plant_bench.data.recording import Recording
from plant_bench.runner.collect.data_folder import DataFolder, EpisodeNote, Origin
from plant_bench.world.route import load_suite
from plant_bench.world.scene import Actors, EgoState, Scene


def _recording_seeds() -> list[bytes]:
    found = []
    with tempfile.TemporaryDirectory() as place:
        for every in (1, 10):
            recorder = Recorder(Path(place) / "r.parquet", {"route": "town01-0"}, every=every)
            for tick in range(60):
                recorder.add(scene_at(tick), *answer_at(tick))
            recorder.close(hazards=[])
            found.append((Path(place) / "r.parquet").read_bytes())
    return found


def scene_at(tick: int) -> Scene:
    """Return a scene with up to three actors."""
    count = tick % 4
    actors = Actors(
        np.arange(count, dtype=np.int64),
        np.ones((count, 3), np.float32),
        np.ones(count, np.float32),
        np.ones((count, 2), np.float32),
        np.zeros(count, np.uint8),
    )
    ego = EgoState(float(tick), 0.0, 0.0, 1.0, 0.0, 0.0)
    return Scene(tick, ego, actors, np.zeros(2, np.uint8))


def answer_at(tick: int) -> tuple[Plan | Control | None, Reason | None]:
    """Return nothing, a control or a plan in turn, and why."""
    if tick % 3 == 0:
        return None, None
    reason = Reason(next(iter(Cause)), 3)
    return (Control(1.0, 0.1) if tick % 3 == 1 else Plan(np.ones((4, 2)))), reason


def _use_recording(box: Path) -> None:
    recording = Recording.load(box / "r.parquet")
    for row in recording.complete_rows:
        used(len(recording[row].actors) >= 0)
    used(len(recording.actions) == len(recording.reasons) == len(recording))
    used(len(recording.egos) == len(recording.disturbed))


def _origin_seeds() -> list[bytes]:
    names = ("density", "protocol", "agent", "agent_checksum", "rules")
    told = dict.fromkeys(names, "x") | {"seed": 0, "perturb": 0.1, "versions": {"a": "1"}}
    return [Origin.model_validate(told).model_dump_json().encode()]


def _use_origin(box: Path) -> None:
    from plant_bench.training.data_provenance import source_of

    source_of(box, 3)


def _note_seeds() -> list[bytes]:
    note = EpisodeNote(route="town01-0", status="Completed", frames=10)
    return [note.model_dump_json().encode()]


def _use_notes(box: Path) -> None:
    (box / "episodes").mkdir(exist_ok=True)
    DataFolder(box).notes()


def _visit_seeds() -> list[bytes]:
    with tempfile.TemporaryDirectory() as place:
        folder = DataFolder(Path(place))
        route = load_suite("longest6")[0]
        folder.save_visits("town01", [[replace(route, **first_metres(route, 40))]])
        return [(Path(place) / "routes" / "town01.json").read_bytes()]


def _use_visits(box: Path) -> None:
    DataFolder(box).visits("town01")


def _data_summary_seeds() -> list[bytes]:
    return [b'{"request": {"frames": 100}, "episodes": 3}']


def _put_origin(box: Path) -> None:
    (box / "collect.json").write_bytes(_origin_seeds()[0])


def _part_seeds() -> list[bytes]:
    columns: dict[str, Any] = {name: np.zeros((3, 2), np.float32) for name in ("ego", "poses")}
    with tempfile.TemporaryDirectory() as place:
        path = Path(place) / "s.npz"
        np.savez_compressed(path, facts__=np.array("{}"), **columns)
        return [path.read_bytes()]


def _use_part(box: Path) -> None:
    from plant_bench.training.column_store import _read_part

    _read_part(box / "s.npz")


FORMATS = (
    Format("recording", "parquet", "r.parquet", _recording_seeds, _use_recording),
    Format("collect", "json", "collect.json", _origin_seeds, _use_origin),
    Format("note", "json", "records/a.json", _note_seeds, _use_notes),
    Format("visits", "json", "routes/town01.json", _visit_seeds, _use_visits),
    Format("data", "json", "data.json", _data_summary_seeds, _use_origin, _put_origin),
    Format("part", "bytes", "s.npz", _part_seeds, _use_part),
)
