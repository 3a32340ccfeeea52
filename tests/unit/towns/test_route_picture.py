"""Pictures of routes."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from PIL import Image
from typer.testing import CliRunner

from plant_bench.cli import app
from plant_bench.towns import route_image
from plant_bench.towns.route_image import (
    CHANGE,
    END,
    HAZARD,
    LINE,
    SIGNAL,
    START,
    save_suite_pictures,
)
from plant_bench.towns.routes import suite_text
from plant_bench.world.route import Route, load_suite
from plant_bench.world.town import Town, load_town
from tests.builders import suite_route

NEAR = 50.0  # distance in RGB (0 to 255 each) up to which colours are equal; palettes shift them


class Picture:
    """A saved picture, and where its panels lie in it."""

    def __init__(self, route: Route, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        panels: list[Axes] = []
        draw = route_image.draw_route

        def keep(town: Town, route: Route, ax: Axes) -> None:
            panels.append(ax)
            draw(town, route, ax)

        monkeypatch.setattr(route_image, "draw_route", keep)
        (file,) = save_suite_pictures([route], folder)
        (self._panel,) = panels
        with Image.open(file) as image:
            self._pixels = np.asarray(image.convert("RGB"), float)

    def where(self, points: np.ndarray) -> np.ndarray:
        """Return the rows and columns of the pixels that show these points of the world."""
        columns, from_below = self._panel.transData.transform(points).T
        return np.stack((len(self._pixels) - from_below, columns), axis=1).astype(int)

    def pixels_of(self, colour: str) -> np.ndarray:
        """Return whether each pixel has a colour."""
        wanted = 255.0 * np.array(to_rgb(colour))
        return np.linalg.norm(self._pixels - wanted, axis=2) < NEAR

    def shows(self, colour: str, points: np.ndarray, within: int) -> list[bool]:
        """Return for each point whether a pixel so near to it has a colour."""
        found = self.pixels_of(colour)
        return [
            bool(
                found[row - within : row + within + 1, column - within : column + within + 1].any()
            )
            for row, column in self.where(points)
        ]


def at(route: Route, along: list[float]) -> np.ndarray:
    """Return the points of a route at some arc lengths."""
    return np.stack([np.interp(along, route.along, column) for column in route.points.T], axis=1)


@pytest.fixture
def route() -> Route:
    """A route with lane changes, traffic lights and hazards."""
    found = suite_route("town03-1")
    assert found.lane_changes
    assert found.signal_passages
    assert found.hazards
    return found


@pytest.fixture
def picture(route: Route, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Picture:
    return Picture(route, tmp_path, monkeypatch)


def test_each_town_gets_one_small_picture(tmp_path):
    routes = [route for route in load_suite("longest6") if route.id in ("town01-0", "town02-0")]
    files = save_suite_pictures(routes, tmp_path)
    assert [path.name for path in files] == ["town01.png", "town02.png"]
    assert all(5_000 < path.stat().st_size < 150_000 for path in files)


def test_the_line_is_where_the_route_is_and_nowhere_else(route: Route, picture: Picture) -> None:
    shown = picture.shows(LINE, route.points[::10], within=1)
    assert np.mean(shown) > 0.6  # markers and letters cover some of it

    line = np.argwhere(picture.pixels_of(LINE))
    distances = np.linalg.norm(line[:, None] - picture.where(route.points)[None, ::3], axis=2)
    assert distances.min(axis=1).max() < 10.0  # arrows are wider than the line


def test_start_and_end_are_marked_each_in_its_colour(route: Route, picture: Picture) -> None:
    assert picture.shows(START, route.points[:1], within=1) == [True]
    assert picture.shows(END, route.points[-1:], within=1) == [True]
    assert picture.shows(END, route.points[:1], within=1) == [False]
    assert picture.shows(START, route.points[-1:], within=1) == [False]


def test_lane_changes_lights_and_hazards_are_marked_where_they_are(
    route: Route, picture: Picture
) -> None:
    changes = at(route, [0.5 * (change.start + change.end) for change in route.lane_changes])
    stop_lines = at(route, list(route.signal_entries))
    hazards = at(route, [hazard.at for hazard in route.hazards])

    assert all(picture.shows(HAZARD, hazards, within=6))
    assert np.mean(picture.shows(SIGNAL, stop_lines, within=2)) > 0.5  # a hazard may cover one
    assert np.mean(picture.shows(CHANGE, changes, within=2)) > 0.5


def test_towns_beside_a_suite_are_listed_and_drawn(tmp_path):
    route = next(route for route in load_suite("longest6") if route.town == "town02")
    own = replace(route, id="mytown-0", town="mytown", hazards=())
    town = replace(load_town("town02"), name="mytown")
    folder = tmp_path / "towns" / "mytown"
    folder.mkdir(parents=True)
    (folder / "town.json").write_text(town.to_json())
    (tmp_path / "routes").mkdir()
    (tmp_path / "routes" / "mytown.json").write_text(suite_text({"suite": "mytown"}, [own]))
    for command in ("routes", "towns"):
        options = ["--suite", str(tmp_path / "routes"), "--pictures", str(tmp_path / command)]
        done = CliRunner().invoke(app, [command, "list", *options])
        assert done.exit_code == 0, done.output
        assert (tmp_path / command / "mytown.png").stat().st_size > 10_000
