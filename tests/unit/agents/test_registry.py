"""Finding planners by name, module and file."""

from pathlib import Path

import pytest

from plant_bench.agent import Agent
from plant_bench.agents.loading.checksum import agent_checksum, agent_files
from plant_bench.agents.loading.planner_spec import AGENTS
from plant_bench.agents.loading.registry import load_agent
from plant_bench.errors import InputError
from plant_bench.user_modules import own_files

PLANNER = """
from plant_bench.agent import Control, Input

class Mine:
    inputs = frozenset({Input.ROUTE})
    def reset(self, route): ...
    def act(self, observation): return Control(0.0, 0.0)

class Odd(Mine):
    inputs = frozenset({"everything"})

class Broken(Mine):
    def __init__(self): raise RuntimeError("no weights")

class NoAgent: ...
"""


@pytest.fixture
def planner(tmp_path: Path) -> Path:
    path = tmp_path / "mine.py"
    path.write_text(PLANNER)
    return path


@pytest.mark.parametrize("name", list(AGENTS))
def test_all_registered_agents_load(name: str) -> None:
    assert isinstance(load_agent(name), Agent)


def test_planner_file_is_loaded_and_hashed_by_content(planner: Path) -> None:
    spec = f"{planner}:Mine"
    assert isinstance(load_agent(spec), Agent)
    before = agent_checksum(spec)
    planner.write_text(PLANNER + "CHANGED = 1\n")
    assert agent_checksum(spec) != before


def test_planner_file_edited_after_loading_keeps_its_first_code(planner: Path) -> None:
    """All episodes of a worker are driven by the code that the run's key names."""
    spec = f"{planner}:Mine"
    first = type(load_agent(spec))
    planner.write_text(PLANNER + "Mine.edited = True\n")
    assert type(load_agent(spec)) is first


@pytest.mark.parametrize(
    ("spec", "message"),
    [
        ("expart", "Did you mean 'expert'"),
        ("nonsense", "Agents: cruise"),
        ("no.such.module:Agent", "cannot be loaded"),
        ("plant_bench.agents.expert:Exprt", "Did you mean 'Expert'"),
        ("missing.py:Agent", "There is no file"),
    ],
)
def test_misspelt_planner_gives_one_message(spec: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        load_agent(spec)


def test_text_after_the_at_sign_is_passed_to_the_class(planner: Path) -> None:
    with planner.open("a") as file:
        file.write("class Told(Mine):\n    def __init__(self, what='a@b:c'): self.what = what\n")
    assert vars(load_agent(f"{planner}:Told@models/mine"))["what"] == "models/mine"
    assert vars(load_agent(f"{planner}:Told"))["what"] == "a@b:c"
    with pytest.raises(InputError, match="takes no arguments"):
        load_agent(f"{planner}:Mine@models/mine")
    with pytest.raises(InputError, match="Did you mean 'plant'"):
        load_agent("plannt@models/mine")


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("NoAgent", "is not a planner"),
        ("Odd", "choose from"),
        ("Broken", "no weights"),
        ("Mien", "Mine"),
    ],
)
def test_class_that_is_not_an_agent_is_refused(planner: Path, name: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        load_agent(f"{planner}:{name}")


def test_checksum_covers_the_modules_that_make_inputs() -> None:
    assert {"inputs.py", "tokens.py"} <= {path.name for path in agent_files("plant")}
    assert {"driver.py", "limits.py"} <= {path.name for path in agent_files("expert")}


def test_checksum_covers_helpers_imported_late(tmp_path: Path) -> None:
    (tmp_path / "late.py").write_text("GAIN = 1\n")
    (tmp_path / "beside.py").write_text("GAIN = 1\n")
    source = PLANNER + "\n\ndef later():\n    from late import GAIN\n    return GAIN\n"
    (tmp_path / "mine_late.py").write_text(source)
    spec = f"{tmp_path / 'mine_late.py'}:Mine"
    before = agent_checksum(spec)

    (tmp_path / "beside.py").write_text("GAIN = 2\n")
    assert agent_checksum(spec) == before
    (tmp_path / "late.py").write_text("GAIN = 2\n")
    assert agent_checksum(spec) != before


def test_checksum_follows_relative_imports(tmp_path: Path) -> None:
    package = tmp_path / "relatively"
    package.mkdir()
    (package / "__init__.py").write_text("")
    (package / "gains.py").write_text("GAIN = 1\n")
    (package / "agent.py").write_text("from .gains import GAIN\n" + PLANNER)

    assert {"agent.py", "gains.py", "__init__.py"} <= {
        path.name for path in own_files(package / "agent.py")
    }
