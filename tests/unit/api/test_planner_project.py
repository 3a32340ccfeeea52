"""Projects that `plant-bench new-agent` writes."""

import tomllib

import pytest

from plant_bench.agent import Agent
from plant_bench.agents.loading.registry import load_agent
from plant_bench.api.planner_project import Kind, write_project
from plant_bench.errors import InputError


@pytest.mark.parametrize("kind", list(Kind))
def test_new_project_is_complete_and_its_planner_loads(tmp_path, kind):
    project = write_project(f"my_{kind}_planner", tmp_path, kind)

    assert isinstance(load_agent(project.spec), Agent)
    assert len(project.files) == (6 if kind is Kind.TORCH else 5)
    facts = tomllib.loads((project.folder / "pyproject.toml").read_text())["project"]
    (target,) = facts["entry-points"]["plant_bench.agents"].values()
    assert target == f"my_{kind}_planner.agent:My{kind.capitalize()}Planner"
    assert ("torch" in facts["dependencies"]) == (kind is Kind.TORCH)
    assert "$" not in "".join((project.folder / file).read_text() for file in project.files)
    assert [path.name for path in tmp_path.iterdir()] == [project.folder.name]


@pytest.mark.parametrize("name", ["control", "plan", "network", "light"])
def test_planner_named_like_a_contract_class_does_not_shadow_it(tmp_path, name):
    kind = Kind.TORCH if name in ("plan", "network") else Kind.RULES

    project = write_project(name, tmp_path, kind)

    assert project.spec.endswith(f":{name.capitalize()}Planner")
    assert isinstance(load_agent(project.spec), Agent)


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("My-Planner", "Try my_planner"),
        ("class", "not a Python keyword"),
        ("1st", "beginning with a letter"),
        ("../up", "not a valid package name"),
        ("", "not a valid package name"),
        ("numpy", "an installed package"),
        ("json", "an installed package"),
        ("rule_based", "is a built-in planner"),
    ],
)
def test_unusable_project_names_are_refused(tmp_path, name, words):
    with pytest.raises(InputError, match=words):
        write_project(name, tmp_path, Kind.RULES)
    assert list(tmp_path.iterdir()) == []


def test_existing_files_are_not_overwritten(tmp_path):
    (tmp_path / "kept_planner").mkdir()
    (tmp_path / "kept_planner" / "work.py").write_text("years")

    with pytest.raises(InputError, match="exists already"):
        write_project("kept_planner", tmp_path, Kind.RULES)
    with pytest.raises(InputError, match="There is no folder"):
        write_project("other", tmp_path / "nowhere", Kind.RULES)
    assert [path.name for path in tmp_path.rglob("*")] == ["kept_planner", "work.py"]
