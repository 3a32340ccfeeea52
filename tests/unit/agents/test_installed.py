"""Planners of installed packages, found by name."""

import importlib
import sys

import pytest

from plant_bench.agent import Agent
from plant_bench.agents.loading.checksum import agent_checksum
from plant_bench.agents.loading.installed import installed_planners
from plant_bench.agents.loading.planner_spec import AGENTS
from plant_bench.agents.loading.registry import agent_factory, load_agent
from plant_bench.errors import InputError

MODULE = """
class Theirs:
    \"\"\"Stands still.\"\"\"
    inputs = frozenset()
    def reset(self, route): ...
    def act(self, observation): ...
"""
ENTRIES = """
[plant_bench.agents]
theirs = {package}.agent:Theirs
expert = {package}.agent:Theirs
broken = {package}.missing:Theirs
nameless = {package}
"""


@pytest.fixture
def package(tmp_path, monkeypatch):
    """Install a package as pip leaves it; returns its folder."""
    folder = tmp_path / "their_planners"
    facts = tmp_path / "their_planners-1.5.dist-info"
    for path in (folder, facts):
        path.mkdir()
    (folder / "__init__.py").touch()
    (folder / "agent.py").write_text(MODULE)
    (folder / "unused.py").write_text("SPEED = 1\n")
    (facts / "METADATA").write_text("Metadata-Version: 2.1\nName: their-planners\nVersion: 1.5\n")
    (facts / "entry_points.txt").write_text(ENTRIES.format(package="their_planners"))
    monkeypatch.syspath_prepend(str(tmp_path))
    importlib.invalidate_caches()
    installed_planners.cache_clear()
    yield folder
    installed_planners.cache_clear()
    for name in [name for name in sys.modules if name.partition(".")[0] == "their_planners"]:
        del sys.modules[name]


def test_installed_planner_is_found_by_its_name(package):
    assert isinstance(load_agent("theirs"), Agent)
    assert installed_planners()["theirs"].distribution == "their-planners 1.5"
    with pytest.raises(InputError, match="Did you mean 'theirs'"):
        load_agent("theris")


def test_built_in_planner_takes_precedence_over_an_installed_one(package):
    assert agent_factory("expert").__module__ == "plant_bench.agents.expert"


def test_checksum_covers_the_whole_package(package):
    before = agent_checksum("theirs")
    (package / "unused.py").write_text("SPEED = 2\n")

    assert agent_checksum("theirs") != before


def test_broken_installed_planner_does_not_affect_the_others(package):
    from typer.testing import CliRunner

    from plant_bench.cli import app

    done = CliRunner().invoke(app, ["agents"])

    assert done.exit_code == 0
    lines = done.output.splitlines()
    assert [name for name in AGENTS if not any(line.startswith(name) for line in lines)] == []
    assert any(line.split()[:2] == ["theirs", "Stands"] for line in lines)
    assert "from their-planners 1.5" in done.output
    assert "No module named 'their_planners.missing'" in done.output
    assert "'expert' of their-planners 1.5 is hidden" in done.output
    with pytest.raises(InputError, match="cannot be loaded"):
        load_agent("broken")
    with pytest.raises(InputError):
        load_agent("nameless")
