"""How the soak test tells apart what ended an episode badly, and its exit code."""

import importlib
from pathlib import Path
from types import SimpleNamespace

import pytest

import plant_bench
from plant_bench.scoring.infractions import Status
from plant_bench.scoring.results import HazardRecord
from plant_bench.world.hazard import HazardKind, Phase
from tests.unit.reports.checkpoint_files import episode

BENCHMARKS = Path(__file__).parents[2] / "benchmarks"


@pytest.fixture
def soak(monkeypatch):
    monkeypatch.syspath_prepend(str(BENCHMARKS))
    return importlib.import_module("soak")


def hazard(phase: Phase, at: float = 500.0, reason: str = "") -> HazardRecord:
    return HazardRecord(kind=HazardKind.CROSSING, at=at, phase=phase, time=1.0, reason=reason)


def blocked(*hazards: HazardRecord, status: Status = Status.BLOCKED):
    return episode(hazards=hazards, status=status)  # at 500 of 1000 m


@pytest.mark.parametrize(
    ("phase", "at", "blocks"),
    [
        (Phase.COMMITTED, 500.0, True),
        (Phase.DONE, 500.0, True),
        (Phase.DONE, 460.0, True),
        (Phase.DONE, 540.0, True),
        (Phase.DONE, 459.9, False),
        (Phase.DONE, 540.1, False),
        (Phase.VOID, 500.0, False),
        (Phase.DORMANT, 500.0, False),
    ],
)
def test_triggered_hazards_near_a_blocked_ego_block_it(soak, phase, at, blocks) -> None:
    near = hazard(phase, at)
    assert soak.blocking_hazards(blocked(near)) == ((near,) if blocks else ())


@pytest.mark.parametrize("status", [Status.COMPLETED, Status.SIMULATION_CRASHED])
def test_an_ego_that_was_not_blocked_is_blocked_by_nothing(soak, status) -> None:
    assert soak.blocking_hazards(blocked(hazard(Phase.DONE), status=status)) == ()


def test_endings_say_which_hazard_blocked_the_ego(soak) -> None:
    void = hazard(Phase.VOID, 510.0, "no gap")
    assert soak.ending(blocked(hazard(Phase.DONE), void)) == (
        "blocked by crossing at 500 m (done) at 500 of 1000 m; "
        "also near: crossing at 510 m (void: no gap)"
    )
    assert soak.ending(blocked(void)) == (
        "blocked, by no hazard, at 500 of 1000 m; also near: crossing at 510 m (void: no gap)"
    )
    assert soak.ending(blocked(status=Status.COMPLETED)) == ""


@pytest.mark.parametrize(
    ("results", "code"),
    [
        ([blocked(hazard(Phase.VOID)), blocked(status=Status.COMPLETED)], 0),
        ([blocked(status=Status.COMPLETED), blocked(hazard(Phase.DONE))], 1),
        ([blocked(status=Status.SIMULATION_CRASHED)], 1),
    ],
)
def test_exit_code_and_folders_of_several_suites(
    soak, monkeypatch, tmp_path, results, code
) -> None:
    calls = []

    def score(agent, *, suite, repetitions, out, **_):
        calls.append((agent, suite, repetitions, out))
        return SimpleNamespace(results=results if suite == "b/routes" else [])

    monkeypatch.setattr(plant_bench, "score", score)
    monkeypatch.setattr(plant_bench, "load_suite", lambda suite: [None] * 3)
    line = ["--suite", "a/routes", "--suite", "b/routes", "--agent", "cruise"]

    assert soak.main([*line, "--episodes", "13", "--out", str(tmp_path)]) == code
    assert calls == [
        ("cruise", "a/routes", 3, tmp_path / "a-routes" / "cruise"),
        ("cruise", "b/routes", 3, tmp_path / "b-routes" / "cruise"),
    ]


def test_all_odd_planners_are_driven(soak, monkeypatch, tmp_path) -> None:
    planners = importlib.import_module("odd_planners")
    driven = []

    def score(agent, **_):
        driven.append(agent)
        return SimpleNamespace(results=[])

    monkeypatch.setattr(plant_bench, "score", score)
    assert soak.main(["--out", str(tmp_path)]) == 0

    file = BENCHMARKS / "odd_planners.py"
    assert driven == [f"{file}:{name}" for name in planners.NAMES]
    found = {
        name
        for name, kind in vars(planners).items()
        if isinstance(kind, type)
        and kind.__module__ == "odd_planners"
        and not name.startswith("_")
        and hasattr(kind, "act")
    }
    assert found == set(planners.NAMES)
