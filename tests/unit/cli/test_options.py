import pytest

from plant_bench.cli import options
from plant_bench.cli.options import Where, chosen_executor
from plant_bench.errors import InputError


def test_this_machine_drives_unless_asked_otherwise():
    assert chosen_executor(Where.LOCAL, None, 3) is None


def test_ray_drives_where_it_is_asked_for():
    executor = chosen_executor(Where.RAY, "ray://head:10001", 3)

    assert str(executor) == "3 workers of the Ray cluster at ray://head:10001"


def test_without_ray_one_line_says_what_to_install(monkeypatch):
    monkeypatch.setattr(options, "find_spec", lambda name: None)

    with pytest.raises(InputError, match=r"pip install 'plant-bench\[ray\]'"):
        chosen_executor(Where.RAY, None, None)


def test_an_address_without_ray_is_refused():
    with pytest.raises(InputError, match="--executor ray"):
        chosen_executor(Where.LOCAL, "auto", None)
