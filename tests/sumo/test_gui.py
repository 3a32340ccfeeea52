"""Episodes shown in sumo-gui are the same as without it; needs Xvfb."""

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from plant_bench.api.gui import VARIABLE, use_gui
from plant_bench.errors import InputError
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
