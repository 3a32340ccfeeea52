import pytest

from plant_bench.data_files import networks_dir
from plant_bench.errors import InputError
from plant_bench.towns.town_spec import RoadClass, read_spec

LATTICE = """
name = "tiny"
description = "A lattice for a test"
seed = 1
extent = [200, 200]
[roads.street]
lanes = 1
speed_kmh = 30
[layout]
character = "lattice"
columns = 4
rows = 4
jitter = 5
missing = 0
corner_radius = 20
"""


@pytest.fixture
def spec_file(tmp_path):
    def write(text):
        path = tmp_path / "spec.toml"
        path.write_text(text, encoding="utf-8")
        return path

    return write


def test_complete_spec_is_read(spec_file):
    spec = read_spec(spec_file(LATTICE))
    assert spec.layout.character == "lattice"
    assert spec.signals.yellow == 3
    assert spec.road("street").lanes == 1


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("lanes = 1", "lanes = 0", "roads.street.lanes"),
        ('character = "lattice"', 'character = "maze"', "character"),
        ("corner_radius = 20", "corner_radius = 5", "corner_radius"),
        ("missing = 0", "missing = 0\nforests = 3", "forests"),
        ("seed = 1", "seed = -1", "seed"),
        ("rows = 4", "rows = four", "Invalid"),
    ],
)
def test_invalid_spec_is_refused_with_the_location(spec_file, old, new, told):
    with pytest.raises(InputError, match=told):
        read_spec(spec_file(LATTICE.replace(old, new)))


def test_a_missing_spec_is_refused(tmp_path):
    with pytest.raises(InputError, match=r"spec\.toml"):
        read_spec(tmp_path / "spec.toml")


def test_a_missing_road_class_is_refused(spec_file):
    with pytest.raises(InputError, match="avenue"):
        read_spec(spec_file(LATTICE)).road("avenue")


def test_speed_of_50_km_h_is_below_the_sumo_sidewalk_limit():
    assert RoadClass(lanes=1, speed_kmh=50.0).speed <= 13.89


def test_all_stored_specs_are_sound():
    specs = [read_spec(path) for path in sorted(networks_dir().glob("*/spec.toml"))]
    assert [spec.name for spec in specs] == [f"town0{number}" for number in range(1, 7)]
