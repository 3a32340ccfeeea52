import pytest

from plant_bench.cli.drive import Driving, drive_missing
from plant_bench.errors import InputError
from plant_bench.runner.ray_executor import RayExecutor
from plant_bench.runner.run import ScoreRequest


def test_a_cluster_that_is_not_there_leaves_no_run_behind(tmp_path):
    how = Driving(workers=1, executor=RayExecutor("ray://127.0.0.1:1"))

    with pytest.raises(InputError, match="Nobody answers"):
        drive_missing(ScoreRequest("cruise"), tmp_path / "run", how)

    assert not list(tmp_path.iterdir())
