"""Pictures of routes."""

from plant_bench.towns.route_image import save_suite_pictures
from plant_bench.world.route import load_suite


def test_each_town_gets_one_small_picture(tmp_path):
    routes = [route for route in load_suite("longest6") if route.id in ("town01-0", "town02-0")]
    files = save_suite_pictures(routes, tmp_path)
    assert [path.name for path in files] == ["town01.png", "town02.png"]
    assert all(5_000 < path.stat().st_size < 150_000 for path in files)
