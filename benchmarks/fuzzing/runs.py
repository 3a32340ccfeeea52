"""Fuzzing of run folders and their additional files: valid files and their readers."""

import functools
import json
import os
import shutil
import socket
import tempfile
from dataclasses import asdict, replace
from pathlib import Path

from fuzzing.form import Format, used
from plant_bench.runner.episode.jobs import episode_name, make_jobs
from plant_bench.runner.episode.timing import Timing
from plant_bench.runner.review import submission
from plant_bench.runner.review.submission import read_submission
from plant_bench.runner.run.folder import RunFolder
from plant_bench.runner.run.provenance import Provenance, provenance
from plant_bench.runner.run.run_lock import LockInfo, Shard, locked
from plant_bench.runner.run.speed import read_timings, speed_of
from plant_bench.runner.run.summary_files import summary_texts, write_summary
from plant_bench.scoring.infractions import Infraction, InfractionKind, Status
from plant_bench.scoring.results import EpisodeResult, HazardRecord
from plant_bench.world.hazard import HazardKind, Phase
from plant_bench.world.route import load_suite


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
def run_files() -> dict[str, bytes]:
    """Return the files of a run of two episodes, by their paths."""
    with tempfile.TemporaryDirectory() as place:
        folder = RunFolder(Path(place) / "run")
        _run(folder)
        files = [path for path in folder.path.rglob("*") if path.is_file()]
        return {path.relative_to(place).as_posix(): path.read_bytes() for path in files}


def put_run(box: Path) -> None:
    """Put a run into a case's folder."""
    submission.load_suite = functools.cache(load_suite)  # ours, which is not what is broken here
    for name, content in run_files().items():
        (box / name).parent.mkdir(parents=True, exist_ok=True)
        (box / name).write_bytes(content)


def _record_seeds() -> list[bytes]:
    return [text for name, text in run_files().items() if "episodes/" in name]


def _use_record(box: Path) -> None:
    record = EpisodeResult.load(box / "record.json")
    record.to_json()
    used(record.driving_score is not None)
    record.as_format(1).to_json()
    summary_texts([record, record.model_copy(update={"repetition": record.repetition ^ 1})])


def _use_provenance(box: Path) -> None:
    from plant_bench.reports.carla_checkpoint_run import run_checkpoint

    told = Provenance.load(box / "run" / "run.json")
    used(told.identity)
    run_checkpoint(RunFolder(box / "run"))
    read_submission(box / "run")


def _use_submission(box: Path) -> None:
    read_submission(box / "run")


def _timing_seeds() -> list[bytes]:
    values = dict.fromkeys(Timing.model_fields, 1.0) | {"ticks": 5, "processor": "x", "log": "x"}
    return [Timing.model_validate(values).model_dump_json().encode()]


def _use_timing(box: Path) -> None:
    speed_of(read_timings(RunFolder(box), ["t"]))


def _ranking_seeds() -> list[bytes]:
    spread = {"mean": 50.0, "std": None}
    score = {
        "agent": "expert-filtered@plant:plant",
        "protocol": "longest6-sumo-v2-rc2",
        "penalties": "lb1.0",
        **dict.fromkeys(("score", "filtered", "whole"), spread),
        "repetitions": [50.0],
        "episodes": 1,
        "unmatched": 0,
        "planner_checksum": "",
    }
    return [json.dumps(score).encode()]


def _use_ranking(box: Path) -> None:
    from plant_bench.reports.leaderboard.score_sources import read_ranking

    read_ranking(box / "run")


def _carla_seeds() -> list[bytes]:
    from plant_bench.reports.carla_checkpoint_run import run_checkpoint

    with tempfile.TemporaryDirectory() as place:
        folder = RunFolder(Path(place) / "run")
        _run(folder)
        return [json.dumps(run_checkpoint(folder).content).encode()]


def _use_carla(box: Path) -> None:
    from plant_bench.reports.carla_checkpoint import load_checkpoint
    from plant_bench.reports.leaderboard.imported_checkpoints import imported_row

    imported_row(load_checkpoint(box / "carla.json"), id="x", planner="y")


def _claim_seeds() -> list[bytes]:
    lock_owner = LockInfo("1of2", "v", socket.gethostname(), os.getpid(), 1, "2026-01-01", "ab")
    return [
        json.dumps(asdict(item)).encode()
        for item in (lock_owner, replace(lock_owner, what="whole"))
    ]


def _use_claim(box: Path) -> None:
    """Lock a folder that may hold a mutated lock; an expired one is taken over."""
    shutil.rmtree(box / "run", ignore_errors=True)
    for name in ("1of2", "2of2"):
        place = box / "run" / "claims" / f"{name}.json"
        place.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(box / "claim.json", place)
    with locked(box / "run", Shard(1, 2), "v"):
        pass


def _index_seeds() -> list[bytes]:
    return [b'plantBench.setIndex({"leaderboard":"","replays":[{"id":"a-1","title":"x"}]});\n']


def _use_index(box: Path) -> None:
    from plant_bench.reports.replay.replay_site import _listed_before

    _listed_before(box, set(), {"id", "title"})


FORMATS = (
    Format("record", "json", "record.json", _record_seeds, _use_record),
    Format(
        "run", "json", "run/run.json", lambda: [run_files()["run/run.json"]], _use_provenance,
        put_run,
    ),
    Format(
        "summary", "json", "run/summary.json", lambda: [run_files()["run/summary.json"]],
        _use_submission, put_run,
    ),
    Format("timing", "json", "timing/t.json", _timing_seeds, _use_timing),
    Format("rfds", "json", "run/rfds.json", _ranking_seeds, _use_ranking, put_run),
    Format("carla", "json", "carla.json", _carla_seeds, _use_carla),
    Format("claim", "json", "claim.json", _claim_seeds, _use_claim),
    Format("index", "bytes", "replays/index.js", _index_seeds, _use_index),
)  # fmt: skip
