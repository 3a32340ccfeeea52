"""`plant-bench replay` and `plant-bench serve`, in this process."""

import json
from http.server import ThreadingHTTPServer

import numpy as np
import pytest
from typer.testing import CliRunner

from plant_bench.cli import app
from plant_bench.cli.options import EXIT_INTERRUPTED
from plant_bench.errors import InputError
from tests.unit.reports.replay.drives import drive


def called(*arguments):
    return CliRunner().invoke(app, [str(item) for item in arguments])


@pytest.fixture
def runs(tmp_path):
    folders = []
    for name in ("ours", "theirs"):
        source = drive(tmp_path, run=name)
        folder = source.recording.parents[1]
        (folder / "episodes").mkdir()
        (folder / "episodes" / "town01-0_r0_abc.json").write_text(source.result.to_json())
        provenance = {"agent": "cruise", "agent_checksum": "0", "suite": "longest6", "seed": 0}
        provenance |= {"density": "dense", "protocol": "p", "towns": {}, "routes": {}}
        provenance |= {"repetitions": 1, "command": "", "versions": {}, "processor": ""}
        (folder / "run.json").write_text(json.dumps(provenance))
        folders.append(folder)
    return folders


def test_replay_of_two_runs_is_written_and_its_address_printed(runs, tmp_path):
    ours, theirs = runs
    out = tmp_path / "site"
    done = called("replay", ours, "town01-0", "--against", theirs, "--html", out)
    assert done.exit_code == 0, done.output
    address = f"{out}/replay.html#ours/town01-0_r0_abc&theirs/town01-0_r0_abc"
    assert address in done.output.splitlines()
    assert (out / "replays" / "theirs" / "town01-0_r0_abc.js").is_file()


def test_pictures_are_written_and_their_paths_printed(runs, tmp_path):
    path = tmp_path / "deep" / "a.png"
    done = called("replay", runs[0], "town01-0", "--png", path, "--time", "1")
    assert done.exit_code == 0, done.output
    assert path.is_file()
    assert str(path) in done.output.splitlines()


@pytest.mark.parametrize(
    ("options", "told"),
    [
        (("--png", "{}/a.jpg"), "ends with .png"),
        (("--png", "{}/a.png", "--time", "99"), "--time 99: expected 0 to 4.0 s"),
        (("--gif", "{}/a.gif", "--from", "3", "--to", "2"), "From 3 to 2 s is empty"),
        (("--png", "{}/ours/run.json/a.png"), "is not a folder"),
    ],
)
def test_options_are_checked_before_the_episode_is_read(runs, tmp_path, monkeypatch, options, told):
    def read(_source):
        pytest.fail("the episode was read")

    monkeypatch.setattr("plant_bench.reports.replay.replay_episode.load_recording", read)
    done = called("replay", runs[0], "town01-0", *(item.format(tmp_path) for item in options))
    assert isinstance(done.exception, InputError)
    assert told in str(done.exception)


@pytest.mark.parametrize(
    "options",
    [
        ("--html", "site"),
        ("--png", "a.png"),
        ("--gif", "a.gif"),
        ("--mp4", "a.mp4"),
        ("--against", "other"),
        ("--time", "0"),
        ("--from", "0"),
        ("--to", "1"),
        ("--fps", "10"),
        ("--dark",),
        ("--expert",),
    ],
)
def test_window_refuses_options_of_pages_and_files(runs, monkeypatch, options):
    monkeypatch.setattr("plant_bench.api.gui.use_gui", lambda _: pytest.fail("it was shown"))

    done = called("replay", runs[0], "town01-0", "--gui", *options)

    assert isinstance(done.exception, InputError)
    assert f"--gui cannot be combined with {options[0]}: it only shows" in str(done.exception)


def test_window_names_all_options_that_it_refuses(runs):
    done = called("replay", runs[0], "0", "--gui", "--time", "3", "--png", "a.png")

    assert "cannot be combined with --png, --time: " in str(done.exception)


@pytest.mark.parametrize(
    ("command", "work"),
    [
        ("report", "plant_bench.api.report.write_report"),
        ("why", "plant_bench.reports.why.incident_list.print_infractions"),
    ],
)
def test_ctrl_c_ends_report_and_why_with_a_message(runs, monkeypatch, command, work):
    def interrupted(*_given, **_more):
        raise KeyboardInterrupt

    monkeypatch.setattr(work, interrupted)
    done = called(command, runs[0])
    assert done.exit_code == EXIT_INTERRUPTED
    assert done.output == "Stopped.\n"


def test_ctrl_c_during_a_video_leaves_no_file(runs, tmp_path, monkeypatch):
    drawn = []

    def interrupted(_panels, times):
        drawn.append(times)
        if len(drawn) > 2:
            raise KeyboardInterrupt
        return np.zeros((8, 8, 3), np.uint8)

    monkeypatch.setattr("plant_bench.reports.replay.image_layout.SceneGrid.draw", interrupted)
    done = called("replay", runs[0], "town01-0", "--gif", tmp_path / "a.gif")
    assert done.exit_code == EXIT_INTERRUPTED
    assert not list(tmp_path.glob("a.*"))


def test_serve_prints_its_address_and_ends_with_ctrl_c(tmp_path, monkeypatch):
    def interrupted(_server):
        raise KeyboardInterrupt

    monkeypatch.setattr(ThreadingHTTPServer, "serve_forever", interrupted)
    (tmp_path / "leaderboard.html").write_text("")
    done = called("serve", tmp_path, "--port", "0")
    assert done.exit_code == EXIT_INTERRUPTED
    assert "at http://127.0.0.1:" in done.output
    assert "/leaderboard.html (stop with Ctrl-C)" in done.output
