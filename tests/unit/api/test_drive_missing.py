import multiprocessing

import pytest

from plant_bench.api import score
from plant_bench.api.score import ExecutionSettings, drive_missing, silent_monitor
from plant_bench.errors import InputError
from plant_bench.runner.ray.executor import RayExecutor
from plant_bench.runner.run.score_run import ScoreRequest


def test_unreachable_cluster_leaves_no_run_folder(tmp_path):
    settings = ExecutionSettings(workers=1, executor=RayExecutor("ray://127.0.0.1:1"))

    with pytest.raises(InputError, match="No response"):
        drive_missing(ScoreRequest("cruise"), tmp_path / "run", settings, silent_monitor())

    assert not list(tmp_path.iterdir())


def test_workers_start_while_the_request_is_checked(tmp_path, monkeypatch):
    """An invalid request ends them."""
    standing_by = []

    def open_run(*_, **__):
        standing_by.extend(multiprocessing.active_children())
        message = "no such planner"
        raise InputError(message)

    monkeypatch.setattr(score, "open_run", open_run)
    with pytest.raises(InputError, match="no such planner"):
        drive_missing(
            ScoreRequest("cruise"), tmp_path / "run", ExecutionSettings(workers=2), silent_monitor()
        )

    assert len(standing_by) == 2
    assert not any(child.is_alive() for child in standing_by)
