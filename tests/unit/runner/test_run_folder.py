import json

import pytest

from plant_bench.errors import InputError
from plant_bench.runner.episode.timing import Timing
from plant_bench.runner.run.folder import RunFolder
from plant_bench.runner.run.provenance import installed_versions, processor_name
from plant_bench.runner.run.speed import read_timings, speed_of

TIMING = {
    "wall_s": 10.0,
    "start_up_s": 0.5,
    "recording_s": 0.5,
    "simulation_s": 4.0,
    "privileged_s": 1.0,
    "agent_s": 2.0,
    "referee_s": 1.0,
    "simulated_s": 200.0,
    "ticks": 4000,
    "latency_p50_ms": 1.0,
    "latency_p95_ms": 2.0,
    "latency_p99_ms": 3.0,
    "late_share": 0.0,
}


@pytest.fixture
def folder(tmp_path):
    folder = RunFolder(tmp_path / "run")
    folder.create()
    return folder


def test_file_is_written_completely_or_not_at_all(folder, monkeypatch):
    folder.write("summary.json", "first")
    monkeypatch.setattr("os.fsync", lambda file: (_ for _ in ()).throw(OSError(28, "Disk full")))

    with pytest.raises(InputError, match="Disk full. Finished episodes are kept"):
        folder.write("summary.json", "second")

    assert (folder.path / "summary.json").read_text() == "first"


def test_creating_the_folder_again_removes_partial_files(folder):
    (folder.path / "recordings" / "a.parquet.part").touch()

    folder.create()

    assert not list(folder.path.rglob("*.part"))


def test_only_partial_files_of_killed_workers_are_removed(folder):
    (folder.path / "episodes" / "a.json").touch()
    (folder.path / "episodes" / "b.json.part").touch()

    folder.remove_partial_files()

    assert [path.name for path in (folder.path / "episodes").iterdir()] == ["a.json"]


def test_folder_without_run_json_is_refused(folder):
    with pytest.raises(InputError, match=r"is not a run of plant-bench: it has no run\.json"):
        RunFolder.open(folder.path)


def test_broken_run_json_is_refused(folder):
    folder.write("run.json", "{}")

    with pytest.raises(InputError, match=r"cannot read run\.json"):
        RunFolder.open(folder.path).provenance()


def test_latency_is_weighted_by_ticks():
    slow = Timing(**TIMING | {"ticks": 1000, "latency_p50_ms": 6.0, "late_share": 0.5})

    speed = speed_of([Timing(**TIMING), slow])

    assert speed.p50_ms == pytest.approx(2.0)
    assert speed.late_share == pytest.approx(0.1)
    assert speed.shares == pytest.approx(
        {"simulation": 0.5, "planner": 0.2, "referee": 0.1, "rest": 0.2}
    )


def test_no_timings_give_no_speed():
    assert speed_of([]).episodes == 0


def test_unreadable_timings_are_left_out(folder):
    folder.write("timing/a.json", json.dumps(TIMING | {"more": 1}))
    folder.write("timing/b.json", "{")

    assert len(read_timings(folder, ["a", "b", "c"])) == 1


def test_provenance_names_versions_checksums_and_seeds():
    assert {"plant-bench", "python", "libsumo", "numpy"} <= installed_versions().keys()
    assert processor_name()
