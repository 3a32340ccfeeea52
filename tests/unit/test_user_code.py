"""Users' code that raises, changes the working folder, leaves threads or ends the process."""

import os
import subprocess
import sys
import threading
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from plant_bench.agents.loading.checksum import agent_checksum
from plant_bench.agents.loading.registry import load_agent
from plant_bench.agents.loading.reported_planner import ReportedPlanner
from plant_bench.errors import InputError
from plant_bench.user_code import PLANNER_LOG, contained, located_text, planner_log
from tests.builders import make_observation

PLANNER = """
import os
import threading
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from plant_bench.agent import Control, Input

class Mine:
    inputs = frozenset({Input.ROUTE})
    interval = 2
    def reset(self, route): raise KeyError(f"lane at {object()}")  # line 12
    def act(self, observation): return np.linalg.inv(np.zeros((2, 2)))  # line 13
    def explain(self): self.missing()  # line 14
    def inv(self): return self.act(None)

class Broken(Mine):
    def __init__(self): raise RuntimeError("no weights")  # line 18

class Moves(Mine):
    files = ("weights.txt",)
    def __init__(self): os.chdir("elsewhere")

class Ends(Mine):
    def __init__(self): os._exit(3)  # line 25

class Waits(Mine):
    def __init__(self): threading.Thread(target=threading.Event().wait, name="mine").start()

class Pools(Mine):
    def __init__(self): ThreadPoolExecutor(1).submit(threading.Event().wait)

class Silent(Exception):
    def __str__(self): raise ValueError

class Odd(Mine):
    def reset(self, route): raise Silent  # line 37
"""


@pytest.fixture
def mine(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    """A planner's file, named relative to the working folder."""
    name = f"mine_{tmp_path.name.replace('-', '_')}.py"
    (tmp_path / name).write_text(PLANNER)
    monkeypatch.chdir(tmp_path)
    return name


def test_exception_says_where_the_planners_own_code_raised_it(mine, tmp_path):
    planner = ReportedPlanner(load_agent(f"{mine}:Mine"))
    with planner_log(tmp_path / "logs" / "planner.log"):
        with pytest.raises(Exception, match="lane at <object") as raised:
            planner.reset(None)
        with pytest.raises(Exception, match="Singular matrix") as raised_in_numpy:
            planner.act(make_observation())
        with pytest.raises(Exception, match="no attribute 'missing'") as not_explained:
            planner.explain()

    assert type(raised.value).__name__ == "KeyError"
    assert str(raised.value) == f"'lane at <object object at 0x...>' ({mine}:12)"
    assert type(raised_in_numpy.value).__name__ == "LinAlgError"
    assert str(raised_in_numpy.value).endswith(f" ({mine}:13)")
    assert str(not_explained.value).endswith(f" ({mine}:14)")
    log = (tmp_path / "logs" / "planner.log").read_text()
    assert log.count("Traceback (most recent call last)") == 3
    assert "# line 12" in log
    assert "linalg" in log
    assert planner.interval == 2


def test_exception_whose_text_cannot_be_read_is_located(mine):
    with pytest.raises(Exception, match="no text") as raised:
        ReportedPlanner(load_agent(f"{mine}:Odd")).reset(None)
    assert str(raised.value) == f"no text ({mine}:37)"


def test_long_text_keeps_its_place(mine):
    planner: Any = load_agent(f"{mine}:Mine")
    with pytest.raises(np.linalg.LinAlgError) as raised:
        planner.inv()
    raised.value.args = ("very long\n" * 100,)
    text = located_text(raised.value)
    assert len(text) <= 200
    assert text.endswith(f"... ({mine}:13)")
    assert "\n" not in text


def test_planner_that_cannot_be_created_is_logged_and_the_message_names_the_log(mine):
    log = Path("run") / "logs" / "planner.log"
    with pytest.raises(InputError) as raised, planner_log(log):
        load_agent(f"{mine}:Broken")

    assert str(raised.value) == (
        f"The agent '{mine}:Broken' cannot be created: RuntimeError: no weights ({mine}:18). "
        "Log: run/logs/planner.log"
    )
    assert "# line 18" in log.read_text()
    assert PLANNER_LOG not in os.environ


@pytest.mark.parametrize(
    ("code", "ending"),
    [
        ("x = 1\ny = undefined\n", "NameError: name 'undefined' is not defined ({}:2). Log: p.log"),
        ("x = 1\nx x\n", "SyntaxError: invalid syntax ({}:2). Log: p.log"),
    ],
)
def test_planner_that_cannot_be_loaded_is_located(mine, code, ending):
    Path(mine).write_text(code)
    with pytest.raises(InputError) as raised, planner_log(Path("p.log")):
        load_agent(f"{mine}:Mine")
    assert str(raised.value).endswith(ending.format(mine))


def test_mistyped_planner_leaves_no_log(mine):
    for spec in ("no.such.module:Mine", f"{mine}:Mnie", "nowhere.py:Mine"):
        with pytest.raises(InputError) as raised, planner_log(Path("logs") / "p.log"):
            load_agent(spec)
        assert "Log:" not in str(raised.value)
    assert not Path("logs").exists()


def test_planner_that_changes_the_working_folder_is_hashed_and_the_folder_is_restored(mine):
    Path("elsewhere").mkdir()
    Path("elsewhere", "weights.txt").write_text("1")
    before = Path.cwd()

    first = agent_checksum(f"{mine}:Moves")

    assert Path.cwd() == before
    Path("elsewhere", "weights.txt").write_text("2")
    assert agent_checksum(f"{mine}:Moves") != first


def test_exit_of_the_process_while_a_planner_is_created_is_an_error(mine):
    with pytest.raises(InputError) as raised:
        agent_checksum(f"{mine}:Ends")
    assert str(raised.value).endswith(f"SystemExit: os._exit(3) ({mine}:25)")
    assert os._exit.__module__ == "posix"


@pytest.mark.parametrize("name", ["Waits", "Pools"])
def test_threads_of_a_loaded_planner_do_not_keep_the_process_alive(mine, name):
    code = (
        "from plant_bench.agents.loading.checksum import agent_checksum\n"
        f"agent_checksum('{mine}:{name}')\n"
        "print('done')\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=200, check=True
    )
    assert done.stdout == "done\n"


def test_forked_child_may_exit_in_the_context():
    with contained():
        child = os.fork()
        if child == 0:
            os._exit(7)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 7


def test_functions_are_restored_after_an_error():
    start = threading.Thread.start
    with pytest.raises(ValueError, match="x"), contained():
        raise ValueError("x")
    assert threading.Thread.start is start
