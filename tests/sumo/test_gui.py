"""Episodes shown in sumo-gui are the same as without it; needs Xvfb."""

import os
import shutil
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest

import plant_bench.api.why
from plant_bench.api.gui import use_gui
from plant_bench.cli import app, main
from plant_bench.errors import InputError
from plant_bench.runner.workers.window import VARIABLE, WINDOW_CLOSED
from plant_bench.runner.workers.worker import Failed, failure
from plant_bench.sim.sumo_library import GUI_VARIABLE

pytestmark = pytest.mark.sumo
XVFB = shutil.which("xvfb-run")


def score(out: Path, *options: str) -> None:
    command = [sys.executable, "-m", "plant_bench", "score", "--agent", "cruise", "--routes", "5"]
    window = [] if not options or XVFB is None else [XVFB, "-a"]
    done = subprocess.run(
        [*window, *command, "--repetitions", "1", "--workers", "1", "--out", str(out), *options],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr


def files(run: Path) -> dict[str, bytes]:
    """Return the contents of a run's records and recordings by name."""
    return {
        str(path.relative_to(run)): path.read_bytes()
        for folder in ("episodes", "recordings")
        for path in sorted((run / folder).iterdir())
    }


@pytest.mark.slow
@pytest.mark.skipif(XVFB is None, reason="xvfb-run is not installed")
def test_episode_in_a_window_equals_one_without_it_byte_for_byte(tmp_path):
    score(tmp_path / "plain")
    score(tmp_path / "window", "--gui", "--gui-speed", "100")
    assert files(tmp_path / "plain") == files(tmp_path / "window")
    assert len(files(tmp_path / "plain")) == 2


def test_window_without_a_display_is_refused(monkeypatch):
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.setattr(sys, "platform", "linux")
    with pytest.raises(InputError, match="--gui needs a display, and DISPLAY is not set"):
        use_gui(1.0)


def test_variable_of_the_window_has_one_name():
    assert VARIABLE == GUI_VARIABLE


@pytest.fixture
def display(monkeypatch):
    """A display that is never opened; the variable of the window is removed afterwards."""
    monkeypatch.setenv("DISPLAY", ":987")
    monkeypatch.setenv(VARIABLE, "")


@pytest.mark.parametrize(
    "options", [["--workers", "2"], ["--executor", "ray"], ["--workers", "1", "--executor", "ray"]]
)
def test_window_shows_one_episode_at_a_time(options, display, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    line = ["plant-bench", "score", "--agent", "cruise", "--gui", *options]
    monkeypatch.setattr(sys, "argv", line)
    with pytest.raises(SystemExit) as ended:
        main()

    assert ended.value.code == 2
    assert "--gui shows one episode at a time: use --workers 1" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


class FatalTraCIError(Exception):
    """As that of `traci`, which is imported only with a window."""


def test_replay_simulates_the_episode_in_the_window(display, monkeypatch, capsys):
    calls = []

    def simulate(*arguments):
        calls.append((*arguments, os.environ[VARIABLE]))
        yield SimpleNamespace(difference="", row=0)
        yield SimpleNamespace(difference="ego.x", row=1)

    monkeypatch.setattr(plant_bench.api.why, "simulate_recorded", simulate)
    app(
        ["replay", "run", "5", "--repetition", "1", "--gui", "--gui-speed", "4"],
        prog_name="plant-bench",
        standalone_mode=False,
    )

    assert calls == [(Path("run"), "5", 1, "12.5")]
    assert capsys.readouterr().out == "At tick 1, the simulation differs: ego.x.\n"


def test_replay_ends_when_its_window_is_closed(display, monkeypatch, capsys):
    def simulate(*_):
        yield SimpleNamespace(difference="", row=0)
        raise FatalTraCIError("Connection closed by SUMO.")

    monkeypatch.setattr(plant_bench.api.why, "simulate_recorded", simulate)
    app(["replay", "run", "5", "--gui"], prog_name="plant-bench", standalone_mode=False)

    assert capsys.readouterr().out == f"{WINDOW_CLOSED}\n"


@pytest.mark.parametrize(
    "error", [FatalTraCIError("Connection closed by SUMO."), BrokenPipeError(32, "Broken pipe")]
)
def test_closing_the_window_ends_the_run_without_a_record(error, monkeypatch):
    monkeypatch.setenv(VARIABLE, "50")
    assert failure(error) == Failed(WINDOW_CLOSED, fatal=True)


def test_lost_simulator_without_a_window_is_a_crash(monkeypatch):
    monkeypatch.delenv(VARIABLE, raising=False)
    try:
        raise FatalTraCIError("Connection closed by SUMO.")
    except FatalTraCIError as error:
        failed = failure(error)
    assert not failed.fatal
    assert failed.reason.startswith("FatalTraCIError: Connection closed by SUMO. (test_gui.py:")


def test_variable_selects_sumo_gui():
    code = "from plant_bench.sim.sumo_library import PROGRAM, libsumo; print(PROGRAM, libsumo)"
    said = subprocess.run(
        [sys.executable, "-c", code],
        env=os.environ | {VARIABLE: "50"},
        capture_output=True,
        text=True,
        check=True,
    ).stdout
    assert "sumo-gui <module 'traci'" in said
