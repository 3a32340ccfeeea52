"""Collection until the requested number of frames, with simulated episode results."""

import json
import random
from dataclasses import replace

import pytest

from plant_bench import source_code
from plant_bench.errors import InputError, SimulationError
from plant_bench.runner.collect import collection as collecting
from plant_bench.runner.collect import episode_plan as collecting_plan
from plant_bench.runner.collect.collect_task import DriveTask, TownTask
from plant_bench.runner.collect.collection import DriveEnded, collect, collecting_checksum
from plant_bench.runner.collect.data_folder import DataFolder, EpisodeNote
from plant_bench.runner.collect.episode_plan import benchmark_seeds, planned_episodes, training_seed
from plant_bench.runner.collect.request import CollectRequest
from plant_bench.runner.workers.executors import Finished, Started
from plant_bench.source_code import module_file
from plant_bench.towns.training_towns import TrainingTown
from plant_bench.training.data_provenance import source_of
from plant_bench.training.frame_store import check_targets

drivers = [""]  # of the episodes that are driven
TOWNS = [TrainingTown("town01", "town01", 0), TrainingTown("town02", "town02", 0)]


@pytest.fixture
def pretend(monkeypatch, route):
    """Drive nothing: a route of n metres gives n / 2 frames, one called "bad" none."""
    monkeypatch.setattr(collecting, "training_towns", lambda: TOWNS)
    driven = []
    one = route("town01-long-0", 40)

    def run_tasks(tasks, work, *, workers, on_event, logs):
        order = list(range(len(tasks)))
        random.Random(workers).shuffle(order)
        for place in order:
            task = tasks[place]
            if isinstance(task, TownTask):
                name = task.town.name
                visits = [
                    [replace(one, id=f"{name}-{kind}-{visit}") for kind in ("long", "bad", "left")]
                    for visit in range(collecting_plan.VISITS)
                ]
                task.folder.save_visits(name, visits)
                continue
            assert isinstance(task, DriveTask)
            name = task.episode.name
            driven.append(name)
            assert task.episode.driver == drivers[0]
            bad = "-bad-" in name
            if not bad:
                task.folder.episode(name).write_bytes(b"recording")
            note = EpisodeNote(
                route=task.episode.job.route.id,
                status="Failed - Agent got blocked" if bad else "Completed",
                left_out="Agent got blocked" if bad else "",
                frames=20,
            )
            on_event(Started(0, place))
            on_event(Finished(0, place, (note, None)))

    monkeypatch.setattr(collecting, "run_tasks", run_tasks)
    return driven


def go(tmp_path, frames, *, out="data", workers=1, **request):
    events = []
    asked = CollectRequest(frames, **request)
    drivers[:] = [asked.driver]
    notes = collect(asked, tmp_path / out, workers=workers, on_event=events.append)
    return notes, events


def files(tmp_path, out="data"):
    return sorted(path.name for path in (tmp_path / out).glob("*/*.*"))


def test_collection_stops_at_the_requested_frames(tmp_path, pretend):
    notes, _ = go(tmp_path, 300)
    frames = sum(note.frames for note in notes if not note.left_out)
    assert 300 <= frames <= 340


def test_failed_episodes_are_counted_but_not_kept_as_data(tmp_path, pretend):
    notes, _ = go(tmp_path, 100)
    left_out = [note for note in notes if note.left_out]
    assert left_out
    assert all("-bad-" in note.route for note in left_out)
    assert not list((tmp_path / "data" / "episodes").glob("*-bad-*"))
    assert len(DataFolder(tmp_path / "data").notes()) == len(notes)


def test_repeating_a_finished_command_drives_nothing(tmp_path, pretend):
    go(tmp_path, 200)
    before = files(tmp_path)
    pretend.clear()
    _, events = go(tmp_path, 200)
    assert pretend == []
    assert all(event.worker is None for event in events if isinstance(event, DriveEnded))
    assert files(tmp_path) == before


def test_only_missing_episodes_are_driven_again(tmp_path, pretend):
    go(tmp_path, 200)
    before = files(tmp_path)
    gone = min((tmp_path / "data" / "episodes").iterdir())
    gone.unlink()
    broken = max((tmp_path / "data" / "records").iterdir())
    broken.write_text("{")
    pretend.clear()
    go(tmp_path, 200)
    assert sorted(pretend) == sorted([gone.stem, broken.stem])
    assert files(tmp_path) == before


def test_requesting_more_frames_extends_the_data(tmp_path, pretend):
    go(tmp_path, 100)
    first = set(pretend)
    pretend.clear()
    go(tmp_path, 300)
    assert pretend
    assert first.isdisjoint(pretend)


def test_data_does_not_depend_on_the_number_of_workers(tmp_path, pretend):
    go(tmp_path, 300, out="one", workers=1)
    go(tmp_path, 300, out="three", workers=3)
    assert files(tmp_path, "one") == files(tmp_path, "three")


def test_repeated_routes_use_other_seeds(tmp_path, pretend):
    go(tmp_path, 600)  # 20 good routes of 20 frames
    again = [name for name in pretend if "_r1_" in name]
    assert again
    assert len(set(pretend)) == len(pretend)


def test_folder_with_other_data_is_refused(tmp_path, pretend):
    go(tmp_path, 40)
    with pytest.raises(InputError, match="holds data of another origin .seed 0, perturb 0.0."):
        go(tmp_path, 40, seed=1, perturb=0.5)


def test_folder_of_a_run_is_refused_and_unchanged(tmp_path, pretend):
    (tmp_path / "data").mkdir()
    (tmp_path / "data" / "run.json").write_text("{}")
    with pytest.raises(InputError, match="holds a run of `plant-bench score`"):
        go(tmp_path, 40)
    assert [path.name for path in (tmp_path / "data").iterdir()] == ["run.json"]


def test_data_of_another_driver_has_another_origin(tmp_path, pretend):
    go(tmp_path, 40, driver="idm")
    kept = DataFolder(tmp_path / "data").origin()
    assert kept is not None
    assert (kept.agent, kept.driver) == ("expert", "idm")
    assert kept.driver_checksum not in ("", kept.agent_checksum)
    go(tmp_path, 40, driver="idm")
    for other in ("rule-based", ""):
        with pytest.raises(InputError, match="another origin .driver idm, driver_checksum"):
            go(tmp_path, 40, driver=other)


@pytest.mark.parametrize("known", ["0123456789abcdef0123", None])
def test_data_of_changed_code_is_readable_but_not_extended(tmp_path, pretend, known):
    go(tmp_path, 40)
    kept = tmp_path / "data" / "collect.json"
    facts = json.loads(kept.read_text())
    del facts["collecting"]
    kept.write_text(json.dumps(facts | ({"collecting": known} if known else {})))

    assert source_of(tmp_path / "data", 2).startswith("2 episodes of data: `plant-bench collect")
    check_targets(tmp_path / "data", "future")
    with pytest.raises(
        InputError, match=f"origin .collecting {known[:16] if known else 'unknown'}\\)"
    ):
        go(tmp_path, 80)


@pytest.mark.parametrize(
    "module",
    [
        "plant_bench.runner.collect.perturbation",
        "plant_bench.runner.collect.dagger",
        "plant_bench.runner.decisions",
        "plant_bench.sensing.observe",
        "plant_bench.towns.training_routes",
    ],
)
def test_collection_checksum_covers_everything_that_affects_driving(monkeypatch, module):
    before = collecting_checksum()
    real, changed = source_code.source_of, module_file(module)
    other = source_code.source_in(changed.read_bytes() + b"ADDED = 1\n")
    monkeypatch.setattr(
        source_code, "source_of", lambda path: other if path == changed else real(path)
    )
    assert collecting_checksum.__wrapped__() != before


def test_another_name_for_the_same_driver_has_the_same_origin(tmp_path, pretend):
    go(tmp_path, 40, driver="idm")
    kept = DataFolder(tmp_path / "data").origin()
    assert kept is not None
    assert not kept.differences(kept.model_copy(update={"driver": "plant_bench.agents:Idm"}))


def test_unfinished_files_are_removed(tmp_path, pretend):
    go(tmp_path, 40)
    (tmp_path / "data" / "unfinished" / "x.parquet").write_text("half")
    go(tmp_path, 40)
    assert not list((tmp_path / "data" / "unfinished").iterdir())


def test_collection_ends_if_the_expert_finishes_no_episode(tmp_path, pretend, monkeypatch):
    monkeypatch.setattr(collecting, "training_towns", lambda: TOWNS[:1])
    monkeypatch.setattr(collecting._Collection, "_frames", lambda self: 0)
    with pytest.raises(SimulationError, match="none can be used as data"):
        go(tmp_path, 400)


@pytest.mark.parametrize(
    ("request_", "words"),
    [
        (CollectRequest(0), "at least 1"),
        (CollectRequest(10, perturb=1.5), "a fraction of episodes"),
        (CollectRequest(10, perturb=0.5, driver="idm"), "exclude each other"),
        (CollectRequest(10, driver="imd"), "Did you mean 'idm'"),
        (CollectRequest(10, driver="expert-nearest"), "inputs include privileged"),
    ],
)
def test_impossible_requests_are_refused(request_, words, tmp_path):
    with pytest.raises(InputError, match=words):
        collect(request_, tmp_path / "data", workers=1, on_event=lambda _event: None)
    assert not (tmp_path / "data").exists()


def test_collection_seeds_never_equal_benchmark_seeds(monkeypatch):
    first = training_seed(0, "town01-long-0", 0)
    assert first not in benchmark_seeds()
    monkeypatch.setattr(collecting_plan, "benchmark_seeds", lambda: {first})
    assert training_seed(0, "town01-long-0", 0) != first


def test_share_of_perturbed_episodes_is_as_requested(route):
    one = route("town01-long-0")
    visits = [[replace(one, id=f"town01-long-{v}-{i}") for i in range(80)] for v in range(5)]
    plan = planned_episodes(CollectRequest(1, perturb=0.25), TOWNS[:1], lambda _town: visits, "x")
    share = sum(next(plan).perturbed for _ in range(400)) / 400
    assert 0.18 < share < 0.32
