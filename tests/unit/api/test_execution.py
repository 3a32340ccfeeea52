import pytest

from plant_bench.api import execution
from plant_bench.api.execution import chosen_executor, isolation_for
from plant_bench.errors import InputError


def test_local_executor_is_the_default():
    assert chosen_executor("local", None, 3) is None


def test_ray_executor_is_used_on_request():
    executor = chosen_executor("ray", "ray://head:10001", 3)

    assert str(executor) == "3 workers of the Ray cluster at ray://head:10001"


def test_missing_ray_says_what_to_install(monkeypatch):
    monkeypatch.setattr(execution, "find_spec", lambda name: None)

    with pytest.raises(InputError, match=r"pip install '\.\[ray\]' in a checkout"):
        chosen_executor("ray", None, None)


def test_an_address_without_ray_is_refused():
    with pytest.raises(InputError, match="requires --executor ray"):
        chosen_executor("local", "auto", None)


def test_an_unknown_executor_is_refused():
    with pytest.raises(InputError, match="expected 'local' or 'ray', got 'slurm'"):
        chosen_executor("slurm", None, None)


def test_workers_load_a_planner_unless_it_is_isolated():
    assert isolation_for("cruise", isolate=False) is None


def test_limits_without_isolate_are_refused():
    with pytest.raises(InputError, match="--tick-limit requires --isolate"):
        isolation_for("cruise", isolate=False, limits={"tick": 1.0, "memory": None})
