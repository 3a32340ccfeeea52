import os
import signal
import threading

import pytest

from plant_bench.errors import InputError
from plant_bench.runner.run.episode_queue import EpisodeEnded, EpisodeRetried, run_suite
from plant_bench.runner.run.score_run import ScoreRequest, open_run
from plant_bench.scoring.infractions import Status

SCRIPTED = "scripted_episode:run_episode"


@pytest.fixture
def go(script, tmp_path, suite_file):
    """Score a suite of routes as the command line does, with scripted episodes."""

    def run(*routes, workers=2, out="run", on_event=lambda event: None, overwrite=False, **request):
        suite = str(suite_file(tmp_path / "suite.json", *routes))
        wanted = ScoreRequest(**({"agent": "cruise", "suite": suite, "repetitions": 1} | request))
        run = open_run(wanted, tmp_path / out, overwrite=overwrite)
        run_suite(run.missing, run.folder, workers=workers, on_event=on_event, run_episode=SCRIPTED)
        return run

    return run


def contents(run):
    return {path.name: path.read_bytes() for path in run.folder.record_files()}


def test_each_episode_has_record_timing_and_recording(go, route):
    run = go(route("a"), route("b"), repetitions=2)

    names = [path.stem for path in run.folder.record_files()]
    assert len(names) == 4
    assert sorted(path.stem for path in (run.folder.path / "timing").iterdir()) == names
    assert sorted(path.stem for path in (run.folder.path / "recordings").iterdir()) == names
    assert names[0].startswith("a_r0_")


def test_records_do_not_depend_on_workers_or_order(go, route):
    routes = [route(name, metres) for name, metres in (("a", 30), ("b", 60), ("c", 45))]

    one = go(*routes, workers=1, out="one", repetitions=2)
    many = go(*reversed(routes), workers=3, out="many", repetitions=2)

    assert contents(one) == contents(many)


def test_longest_routes_start_first(go, route, script):
    go(route("short", 20), route("long", 80), route("middle", 50), workers=1)

    assert script.read_text().split("\n")[:3] == ["long r0", "middle r0", "short r0"]


def test_repeated_command_runs_only_missing_episodes(go, route, script):
    first = go(route("a"), route("b"))
    before = contents(first)
    first.folder.record_files()[0].unlink()

    again = go(route("a"), route("b"))

    assert [job.route.id for job in again.missing] == ["a"]
    assert script.read_text().count("a r0") == 2
    assert script.read_text().count("b r0") == 1
    assert contents(again) == before


def test_additional_repetitions_keep_the_existing_ones(go, route):
    go(route("a"))

    assert [job.repetition for job in go(route("a"), repetitions=3).missing] == [1, 2]
    assert go(route("a")).missing == []


def test_overwrite_drives_everything_again(go, route):
    go(route("a"))

    assert len(go(route("a"), overwrite=True).missing) == 1


def test_half_written_record_is_driven_again(go, route):
    run = go(route("a"))
    before = contents(run)
    path = run.folder.record_files()[0]
    path.write_bytes(path.read_bytes()[:50])
    (path.parent / "b.json.part").write_text("{")

    again = go(route("a"))

    assert contents(again) == before
    assert not list(path.parent.glob("*.part"))


def test_dead_worker_is_recorded_and_the_others_continue(go, route, script):
    events = []

    run = go(route("dies"), route("fails"), route("fine"), on_event=events.append)

    status = {result.route: result.status for result in run.folder.results()}
    assert status == {
        "dies": Status.AGENT_CRASHED,  # only a planner ends its process with an exit code
        "fails": Status.SIMULATION_CRASHED,
        "fine": Status.TIMED_OUT,
    }
    reasons = {result.route: result.reason for result in run.folder.results()}
    assert reasons["dies"] == "The worker process ended with exit code 3."
    assert reasons["fails"] == "the ego was lost"
    assert script.read_text().count("dies r0") == 2
    assert sum(isinstance(event, EpisodeRetried) for event in events) == 2
    assert sum(isinstance(event, EpisodeEnded) for event in events) == 3
    assert go(route("dies"), route("fails"), route("fine")).missing == []


def test_ctrl_c_keeps_finished_episodes(go, route, tmp_path):
    def stop_soon(event):
        if isinstance(event, EpisodeEnded):
            threading.Timer(0.2, os.kill, (os.getpid(), signal.SIGINT)).start()

    routes = [route("quick", 60), route("slow", 20)]
    with pytest.raises(KeyboardInterrupt):
        go(*routes, workers=1, on_event=stop_soon)

    suite = str(tmp_path / "suite.json")
    run = open_run(ScoreRequest("cruise", suite, repetitions=1), tmp_path / "run")
    assert [job.route.id for job in run.missing] == ["slow"]


def test_changed_route_supersedes_its_record(go, route):
    go(route("a"), route("b"))

    run = go(route("a", 50), route("b"))

    assert [job.route.id for job in run.missing] == ["a"]
    assert run.notes
    assert len(run.folder.record_files()) == 2
    for part in ("episodes", "timing", "recordings"):
        assert len(list((run.folder.path / "superseded" / part).iterdir())) == 1


def test_a_folder_of_another_run_is_refused(go, route):
    go(route("a"))

    with pytest.raises(InputError, match="holds another run .seed 0."):
        go(route("a"), seed=1)
    assert len(go(route("a"), seed=1, overwrite=True).folder.results()) == 1


def test_unwritable_folder_is_refused(go, route, tmp_path):
    (tmp_path / "file").touch()

    with pytest.raises(InputError, match="Cannot write to"):
        go(route("a"), out="file/run")


def test_unknown_density_is_refused_before_driving(go, route, tmp_path):
    with pytest.raises(InputError, match="density"):
        go(route("a"), density="packed")
    assert not (tmp_path / "run").exists()
