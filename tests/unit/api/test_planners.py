"""Planners as texts that worker processes can load."""

import importlib
import sys
from functools import partial
from pathlib import Path

import pytest

from plant_bench.agent import Agent, Control, Input, Observation
from plant_bench.agents.cruise import Cruise
from plant_bench.agents.loading.checksum import agent_checksum
from plant_bench.agents.loading.registry import load_agent
from plant_bench.api.planners import resolve, spec_of
from plant_bench.errors import InputError
from plant_bench.world.route import Route

SOURCE = """
from plant_bench.agent import Control

class Mine:
    inputs = frozenset()
    def reset(self, route): ...
    def act(self, observation): return Control(1.0, 0.0)
"""


class Steady:
    """A planner of a module that only this process can import, as loaded by pytest."""

    inputs = frozenset({Input.ROUTE})

    def __init__(self, speed: float = 5.0) -> None:
        self.speed = speed
        self.driven = [0.0]

    def reset(self, route: Route | None) -> None:
        assert route is not None

    def act(self, observation: Observation) -> Control:
        return Control(self.speed - observation.ego.speed, 0.0)


@pytest.fixture(autouse=True)
def elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def test_planner_given_as_text_is_unchanged() -> None:
    assert resolve("plant@models/mine").spec == "plant@models/mine"
    assert not list(Path().iterdir())


def test_built_in_class_resolves_to_its_name() -> None:
    assert resolve(Cruise).spec == "cruise"


def test_class_of_a_module_resolves_to_module_and_class(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "my_module.py").write_text(SOURCE)
    monkeypatch.syspath_prepend(tmp_path)
    module = importlib.import_module("my_module")

    assert resolve(module.Mine).spec == "my_module:Mine"
    assert isinstance(load_agent(resolve(module.Mine).spec), module.Mine)


def test_class_of_a_file_resolves_to_file_and_class(tmp_path: Path) -> None:
    file = tmp_path / "my_file.py"
    file.write_text(SOURCE)
    made = load_agent(f"{file}:Mine")

    spec = resolve(type(made)).spec

    assert spec == f"{file}:Mine"


def test_each_load_of_a_planner_object_is_a_new_copy() -> None:
    mine = Steady(7.0)
    spec = resolve(mine).spec
    first = load_agent(spec)
    first.driven.append(1.0)  # type: ignore[attr-defined]
    mine.driven.append(2.0)

    second = load_agent(spec)

    assert isinstance(second, Agent)
    assert vars(second) == {"speed": 7.0, "driven": [0.0]}


def test_planner_object_loads_without_its_module(monkeypatch: pytest.MonkeyPatch) -> None:
    spec = resolve(Steady(3.0)).spec
    monkeypatch.delitem(sys.modules, __name__)

    assert vars(load_agent(spec))["speed"] == 3.0


def test_different_attributes_make_different_planners() -> None:
    specs = [resolve(planner).spec for planner in (Steady(1.0), Steady(1.0), Steady(2.0), Steady)]

    assert specs[0] == specs[1]
    assert len(set(specs)) == 3
    assert len({agent_checksum(spec) for spec in specs}) == 3


def test_factory_is_called_for_each_episode() -> None:
    spec = resolve(partial(Steady, 9.0)).spec

    assert vars(load_agent(spec))["speed"] == 9.0


@pytest.mark.parametrize("planner", [7, object(), None, {"inputs": ()}])
def test_value_that_is_not_a_planner_is_refused(planner: object) -> None:
    with pytest.raises(InputError, match=r"expected a name, a class or an object .*, got a "):
        resolve(planner)


def test_class_that_requires_arguments_is_refused() -> None:
    class Wants(Steady):
        def __init__(self, speed: float) -> None:
            super().__init__(speed)

    with pytest.raises(InputError, match="missing 1 required positional argument: 'speed'"):
        load_agent(resolve(Wants).spec)


def test_planner_that_cannot_be_copied_is_refused() -> None:
    mine = Steady()
    mine.log = Path("log").open("w")  # type: ignore[attr-defined]  # noqa: SIM115

    with pytest.raises(InputError, match="Steady cannot be sent to worker processes"):
        resolve(mine)
    mine.log.close()  # type: ignore[attr-defined]


def test_planner_object_is_refused_where_a_name_is_required() -> None:
    assert spec_of(Cruise, "rfds") == "cruise"
    with pytest.raises(InputError, match=r"rfds: expected a name .*, got Steady-"):
        spec_of(Steady(), "rfds")


def test_a_file_that_has_been_edited_is_loaded_again(tmp_path):
    (tmp_path / "mine.py").write_text(SOURCE)
    spec = f"{tmp_path / 'mine.py'}:Mine"
    assert type(load_agent(resolve(spec).spec)).__name__ == "Mine"

    (tmp_path / "mine.py").write_text(SOURCE + "Mine.edited = True\n")

    assert vars(type(load_agent(resolve(spec).spec)))["edited"]
