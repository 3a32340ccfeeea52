import numpy as np
import pytest
from safetensors.numpy import save_file

from plant_bench.reports.leaderboard.parameter_count import parameter_count


@pytest.fixture
def weights(tmp_path):
    tensors = {"a": np.zeros((3, 4), np.float16), "b": np.zeros(5, np.float32)}
    save_file(tensors, tmp_path / "weights.safetensors", metadata={"x": "y"})
    return tmp_path


def test_parameter_count_covers_all_tensors(weights):
    assert parameter_count(f"plant@{weights}") == 17
    assert parameter_count(f"mine.py:Agent@{weights / 'weights.safetensors'}") == 17


def test_parameters_of_other_learners_are_counted(weights):
    assert parameter_count(f"my_package.agent:Mine@{weights}") == 17


@pytest.mark.parametrize("agent", ["plant", "plant-unguarded"])
def test_shipped_planner_has_a_parameter_count(agent):
    assert (parameter_count(agent) or 0) > 1_000_000


@pytest.mark.parametrize("agent", ["expert", "plant@/gone", "x.py:A", "a@" + "x" * 10_000])
def test_planner_without_weights_has_no_parameter_count(agent):
    assert parameter_count(agent) is None


@pytest.mark.parametrize("broken", [b"", b"\xff" * 8, b"\x02" + b"\0" * 7 + b"[]"])
def test_broken_weights_have_no_parameter_count(tmp_path, broken):
    (tmp_path / "w.safetensors").write_bytes(broken)
    assert parameter_count(f"plant@{tmp_path}") is None
