import multiprocessing

import pytest

from plant_bench.agents.remote.process import Limits
from plant_bench.agents.remote.programs import program_of
from plant_bench.cli import drive
from plant_bench.cli.drive import Driving, drive_missing
from plant_bench.errors import InputError
from plant_bench.runner.isolation import Isolation
from plant_bench.runner.ray_executor import RayExecutor
from plant_bench.runner.run import ScoreRequest
from plant_bench.runner.suite import modules_needed


def test_a_cluster_that_is_not_there_leaves_no_run_behind(tmp_path):
    how = Driving(workers=1, executor=RayExecutor("ray://127.0.0.1:1"))

    with pytest.raises(InputError, match="Nobody answers"):
        drive_missing(ScoreRequest("cruise"), tmp_path / "run", how)

    assert not list(tmp_path.iterdir())


def test_workers_load_what_they_need_while_the_request_is_read(tmp_path, monkeypatch):
    """A mistyped request ends them again."""
    standing_by = []

    def open_run(*_, **__):
        standing_by.extend(multiprocessing.active_children())
        message = "no such planner"
        raise InputError(message)

    monkeypatch.setattr(drive, "open_run", open_run)
    with pytest.raises(InputError, match="no such planner"):
        drive_missing(ScoreRequest("cruise"), tmp_path / "run", Driving(workers=2))

    assert len(standing_by) == 2
    assert not any(child.is_alive() for child in standing_by)


def test_only_own_planners_of_the_workers_are_loaded_beforehand():
    episode = "plant_bench.runner.episode"
    apart = Isolation(program_of("expert"), Limits(), None)

    assert modules_needed("plant@weights", None) == (episode, "plant_bench.agents.plant.guarded")
    assert modules_needed("their.module:Planner", None) == (episode,)
    assert modules_needed("expert", apart) == (episode,)
