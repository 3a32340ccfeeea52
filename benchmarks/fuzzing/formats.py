"""Each format that plant-bench reads: files that are whole, and who reads them."""

import functools
import json
import tempfile
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from plant_bench.agent import Cause, Control, Plan, Reason
from plant_bench.data.recording import Recorder, Recording
from plant_bench.data_files import networks_dir, towns_also_from
from plant_bench.runner import submission
from plant_bench.runner.data_folder import DataFolder, EpisodeNote, Origin
from plant_bench.runner.jobs import episode_name, make_jobs
from plant_bench.runner.provenance import Provenance, provenance
from plant_bench.runner.run_folder import RunFolder
from plant_bench.runner.speed import read_timings, speed_of
from plant_bench.runner.submission import read_submission
from plant_bench.runner.summary import summary_texts, write_summary
from plant_bench.runner.timing import Timing
from plant_bench.scoring.infractions import Infraction, InfractionKind, Status
from plant_bench.scoring.results import EpisodeResult, HazardRecord
from plant_bench.towns.routes import suite_text
from plant_bench.world.hazard import HazardKind, Phase
from plant_bench.world.route import load_suite
from plant_bench.world.scene import Actors, EgoState, Scene
from plant_bench.world.town import Town, load_town


def _nothing(_box: Path) -> None:
    """Need nothing else in the folder."""


@dataclass(frozen=True)
class Format:
    """One format.

    Attributes:
        name: What the command line calls it.
        kind: How it is mutated: "json", "parquet", "safetensors" or "bytes".
        file: Its path in the case's folder.
        seeds: Makes files that load.
        load: Reads the file of a folder and uses what it gives.
        prepare: Puts what else is needed into the folder.
    """

    name: str
    kind: str
    file: str
    seeds: Callable[[], list[bytes]]
    load: Callable[[Path], object]
    prepare: Callable[[Path], None] = _nothing


def _used(*_values: object) -> None:
    """Want values that are worked out when they are asked for."""


# Routes and towns


def _route_seeds() -> list[bytes]:
    suite = load_suite("longest6")
    short = [replace(suite[place], **_first(suite[place], 60)) for place in (0, 13, 20)]
    return [suite_text({"suite": "f"}, short[:1]).encode(), suite_text({}, short).encode()]


def _first(route, metres: int) -> dict:
    return {
        "points": route.points[:metres],
        "elevations": route.elevations[:metres],
        "speed_limits": route.speed_limits[:metres],
    }


@functools.cache
def _known_town(name: str) -> Town:
    return load_town(name)


def _use_routes(box: Path) -> None:
    for route in load_suite(str(box / "routes.json")):
        _used(route.checksum)
        _used(len(route.headings) == len(route.along))
        _used(route.plan.length > 0)
        _used(len(route.signal_entries) == len(route.signal_passages))
        route.check_town(_known_town(route.town))


def _town_seeds() -> list[bytes]:
    town = json.loads((networks_dir() / "town02" / "town.json").read_text(encoding="utf-8"))
    lanes = town["lanes"][:12]
    kept = {lane["id"] for lane in lanes}
    for lane in lanes:
        lane["successors"] = [name for name in lane["successors"] if name in kept]
        lane["left"], lane["right"] = (
            name if name in kept else None for name in (lane["left"], lane["right"])
        )
    links = [
        link for link in town["links"] if {link["source"], link["target"], *link["via"]} <= kept
    ]
    small = town | {"lanes": lanes, "links": links, "areas": town["areas"][:5]}
    return [json.dumps(small).encode()]


def _use_town(box: Path) -> None:
    with towns_also_from(box / "towns"):
        town = load_town("fuzzed")
    _used(town.edges is not None)
    _used(town.links_from is not None)
    _used(town.extent)
    _used(town.lane_km >= 0.0)
    town.to_json()


# Runs


def _run(folder: RunFolder) -> None:
    suite = load_suite("longest6")
    folder.create()
    told = provenance(
        "stranger",
        "a" * 64,
        suite,
        suite="longest6",
        seed=0,
        density="dense",
        hazards=True,
        repetitions=1,
    )
    folder.write("run.json", told.model_dump_json(indent=1) + "\n")
    for job in make_jobs("stranger", "a" * 64, suite[:2], repetitions=1, seed=0, density="dense"):
        hit = {"kind": InfractionKind.COLLISION_VEHICLE, "time": 1.0, "x": 1.0, "y": 2.0}
        result = EpisodeResult(
            **job.header(frozenset()).model_dump(),
            status=Status.TIMED_OUT,
            route_length=job.route.length,
            completion=0.5,
            distance=100.0,
            duration=100.0,
            infractions=(Infraction.model_validate(hit | {"progress": 3.0, "cause": "ego"}),),
            hazards=(HazardRecord(kind=HazardKind.CUT_IN, at=5.0, phase=Phase.DONE, time=2.0),),
        )
        folder.save(episode_name(job), result, None)
    write_summary(folder)


@functools.cache
def _run_files() -> dict[str, bytes]:
    with tempfile.TemporaryDirectory() as place:
        folder = RunFolder(Path(place) / "run")
        _run(folder)
        files = [path for path in folder.path.rglob("*") if path.is_file()]
        return {path.relative_to(place).as_posix(): path.read_bytes() for path in files}


def _put_run(box: Path) -> None:
    submission.load_suite = functools.cache(load_suite)  # ours, which is not what is broken here
    for name, content in _run_files().items():
        (box / name).parent.mkdir(parents=True, exist_ok=True)
        (box / name).write_bytes(content)


def _record_seeds() -> list[bytes]:
    return [text for name, text in _run_files().items() if "episodes/" in name]


def _use_record(box: Path) -> None:
    record = EpisodeResult.load(box / "record.json")
    record.to_json()
    _used(record.driving_score is not None)
    record.as_format(1).to_json()
    summary_texts([record, record.model_copy(update={"repetition": record.repetition ^ 1})])


def _use_provenance(box: Path) -> None:
    from plant_bench.reports.carla_checkpoint_run import run_checkpoint

    told = Provenance.load(box / "run" / "run.json")
    _used(told.identity)
    run_checkpoint(RunFolder(box / "run"))
    read_submission(box / "run")


def _use_submission(box: Path) -> None:
    read_submission(box / "run")


def _timing_seeds() -> list[bytes]:
    values = dict.fromkeys(Timing.model_fields, 1.0) | {"ticks": 5, "processor": "x"}
    return [Timing.model_validate(values).model_dump_json().encode()]


def _use_timing(box: Path) -> None:
    speed_of(read_timings(RunFolder(box), ["t"]))


def _ranking_seeds() -> list[bytes]:
    spread = {"mean": 50.0, "std": None}
    score = {
        "agent": "expert-filtered@plant:plant",
        "protocol": "longest6-sumo-v1",
        "law": "lb1.0",
        **dict.fromkeys(("score", "filtered", "whole"), spread),
        "repetitions": [50.0],
        "episodes": 1,
        "unmatched": 0,
        "planner_checksum": "",
    }
    return [json.dumps(score).encode()]


def _use_ranking(box: Path) -> None:
    from plant_bench.reports.leaderboard.sources import read_ranking

    read_ranking(box / "run")


def _carla_seeds() -> list[bytes]:
    from plant_bench.reports.carla_checkpoint_run import run_checkpoint

    with tempfile.TemporaryDirectory() as place:
        folder = RunFolder(Path(place) / "run")
        _run(folder)
        return [json.dumps(run_checkpoint(folder).content).encode()]


def _use_carla(box: Path) -> None:
    from plant_bench.reports.carla_checkpoint import load_checkpoint
    from plant_bench.reports.leaderboard.imported import imported_line

    imported_line(load_checkpoint(box / "carla.json"), id="x", planner="y")


# Collected data and recordings


def _recording_seeds() -> list[bytes]:
    found = []
    with tempfile.TemporaryDirectory() as place:
        for every in (1, 10):
            recorder = Recorder(Path(place) / "r.parquet", {"route": "town01-0"}, every=every)
            for tick in range(60):
                recorder.add(_scene(tick), *_answer(tick))
            recorder.close(hazards=[])
            found.append((Path(place) / "r.parquet").read_bytes())
    return found


def _scene(tick: int) -> Scene:
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


def _answer(tick: int) -> tuple[Plan | Control | None, Reason | None]:
    if tick % 3 == 0:
        return None, None
    reason = Reason(next(iter(Cause)), 3)
    return (Control(1.0, 0.1) if tick % 3 == 1 else Plan(np.ones((4, 2)))), reason


def _use_recording(box: Path) -> None:
    recording = Recording.load(box / "r.parquet")
    for row in recording.whole:
        _used(len(recording[row].actors) >= 0)
    _used(len(recording.actions) == len(recording.reasons) == len(recording))
    _used(len(recording.egos) == len(recording.disturbed))


def _origin_seeds() -> list[bytes]:
    names = ("density", "protocol", "agent", "agent_checksum", "rules")
    told = dict.fromkeys(names, "x") | {"seed": 0, "perturb": 0.1, "versions": {"a": "1"}}
    return [Origin.model_validate(told).model_dump_json().encode()]


def _use_origin(box: Path) -> None:
    from plant_bench.training.sources import source_of

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
        folder.save_visits("town01", [[replace(route, **_first(route, 40))]])
        return [(Path(place) / "routes" / "town01.json").read_bytes()]


def _use_visits(box: Path) -> None:
    DataFolder(box).visits("town01")


def _data_summary_seeds() -> list[bytes]:
    return [b'{"request": {"frames": 100}, "episodes": 3}']


def _put_origin(box: Path) -> None:
    (box / "collect.json").write_bytes(_origin_seeds()[0])


def _spec_seeds() -> list[bytes]:
    return [path.read_bytes() for path in sorted(networks_dir().glob("town0[12]/spec.toml"))]


def _use_spec(box: Path) -> None:
    from plant_bench.towns.spec import read_spec

    read_spec(box / "spec.toml")


# Models


def _small() -> None:
    """Let PlanT's smallest size be a tiny one, so that its files are quick to break."""
    from plant_bench.agents.plant.config import SIZES, Size

    SIZES["mini"] = Size(1, 32, 2)


def _put_model(box: Path) -> None:
    from plant_bench.agents.plant.config import PlanTConfig
    from plant_bench.agents.plant.network import PlanTNetwork
    from plant_bench.agents.plant.weights import save_network

    _small()
    save_network(PlanTNetwork(PlanTConfig()), box / "model")


def _model_file(name: str) -> bytes:
    with tempfile.TemporaryDirectory() as place:
        _put_model(Path(place))
        if name.endswith(".onnx"):
            from plant_bench.agents.plant.export import export_graph

            export_graph(Path(place) / "model", 32)
        return (Path(place) / "model" / name).read_bytes()


def _use_config(box: Path) -> None:
    from plant_bench.agents.plant.config import load_config

    config = load_config(box / "model")
    _used(config.bins)
    _used(config.encoder)


def _use_weights(box: Path) -> None:
    from plant_bench.agents.plant.weights import load_network, weights_hash
    from plant_bench.reports.leaderboard.weights import parameter_count

    weights_hash(box / "model")
    parameter_count(f"x@{box / 'model'}")
    load_network(box / "model")


def _use_graph(box: Path) -> None:
    from plant_bench.agents.plant.graph import GraphPredictor

    GraphPredictor(box / "model" / "network.onnx")


IDENTITY = {"data": "x"}


def _checkpoint_seeds() -> list[bytes]:
    import torch

    from plant_bench.training.checkpoint import CHECKPOINT_FILE, Progress, save_checkpoint

    network = torch.nn.Linear(3, 2)
    optimizer = torch.optim.AdamW(network.parameters())
    network(torch.ones(1, 3)).sum().backward()
    optimizer.step()
    with tempfile.TemporaryDirectory() as place:
        states = network.state_dict(), optimizer.state_dict()
        save_checkpoint(Path(place), Progress(1, 2), IDENTITY, *states)
        return [(Path(place) / CHECKPOINT_FILE).read_bytes()]


def _use_checkpoint(box: Path) -> None:
    from plant_bench.training.checkpoint import load_checkpoint

    load_checkpoint(box, IDENTITY)


def _shard_seeds() -> list[bytes]:
    from dataclasses import fields

    from plant_bench.training.samples import Samples

    with tempfile.TemporaryDirectory() as place:
        path = Path(place) / "s.npz"
        columns: dict[str, Any] = {
            item.name: np.zeros((3, 2), np.float32) for item in fields(Samples)
        }
        np.savez_compressed(path, route=np.array("town01-0"), **columns)
        return [path.read_bytes()]


def _use_shard(box: Path) -> None:
    from plant_bench.training.shards import _read

    _read(box / "s.npz")


def _index_seeds() -> list[bytes]:
    return [b'plantBenchIndex({"leaderboard":"","replays":[{"id":"a-1","title":"x"}]});\n']


def _use_index(box: Path) -> None:
    from plant_bench.reports.replay.site import _listed_before

    _listed_before(box, set(), {"id", "title"})


_ALL = (
    Format("routes", "json", "routes.json", _route_seeds, _use_routes),
    Format("town", "json", "towns/fuzzed/town.json", _town_seeds, _use_town),
    Format("record", "json", "record.json", _record_seeds, _use_record),
    Format(
        "run", "json", "run/run.json", lambda: [_run_files()["run/run.json"]], _use_provenance,
        _put_run,
    ),
    Format(
        "summary", "json", "run/summary.json", lambda: [_run_files()["run/summary.json"]],
        _use_submission, _put_run,
    ),
    Format("timing", "json", "timing/t.json", _timing_seeds, _use_timing),
    Format("rfds", "json", "run/rfds.json", _ranking_seeds, _use_ranking, _put_run),
    Format("carla", "json", "carla.json", _carla_seeds, _use_carla),
    Format("recording", "parquet", "r.parquet", _recording_seeds, _use_recording),
    Format("collect", "json", "collect.json", _origin_seeds, _use_origin),
    Format("note", "json", "records/a.json", _note_seeds, _use_notes),
    Format("visits", "json", "routes/town01.json", _visit_seeds, _use_visits),
    Format("data", "json", "data.json", _data_summary_seeds, _use_origin, _put_origin),
    Format("spec", "bytes", "spec.toml", _spec_seeds, _use_spec),
    Format(
        "config", "json", "model/config.json", lambda: [_model_file("config.json")], _use_config,
        _put_model,
    ),
    Format(
        "weights", "safetensors", "model/weights.safetensors",
        lambda: [_model_file("weights.safetensors")], _use_weights, _put_model,
    ),
    Format(
        "onnx", "bytes", "model/network.onnx", lambda: [_model_file("network.onnx")], _use_graph,
        _put_model,
    ),
    Format(
        "checkpoint", "safetensors", "checkpoint.safetensors", _checkpoint_seeds, _use_checkpoint
    ),
    Format("shard", "bytes", "s.npz", _shard_seeds, _use_shard),
    Format("index", "bytes", "replays/index.js", _index_seeds, _use_index),
)  # fmt: skip
FORMATS = {item.name: item for item in _ALL}
