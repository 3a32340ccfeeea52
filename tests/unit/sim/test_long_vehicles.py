"""The extra width of long vehicles on curves, and which vehicles do not fit."""

import numpy as np
import pytest
from jaxtyping import Float

from plant_bench.sim.long_vehicles import fits, reach_aside
from plant_bench.world.town import Lane, Link, Town


def arc(radius: float, angle: float = np.pi / 2) -> Float[np.ndarray, "points 2"]:
    """A bend to the left between two straights of 30 m."""
    turn = np.linspace(0.0, angle, 60)
    bend = radius * np.stack((np.sin(turn), 1.0 - np.cos(turn)), axis=1)
    out = bend[-1] + 30.0 * np.array([[np.cos(angle), np.sin(angle)]])
    return np.concatenate(([[-30.0, 0.0]], bend, out))


@pytest.mark.parametrize("radius", [8.0, 20.0])
def test_vehicle_on_a_curve_needs_the_sagitta_as_extra_width(radius: float) -> None:
    sagitta = radius * (1.0 - np.cos(4.5 / radius))  # its front and rear are 9 m of lane apart
    assert reach_aside(arc(radius), 9.0, 2.4) == pytest.approx(1.2 + sagitta, abs=0.03)


def test_vehicle_on_a_straight_needs_its_own_width() -> None:
    assert reach_aside(np.array([[0.0, 0.0], [5.0, 5.0]]), 9.0, 2.4) == pytest.approx(1.2)
    assert reach_aside(np.array([[0.0, 0.0], [50.0, 5.0]]), 9.0, 2.4) == pytest.approx(1.2)


def turn(radius: float) -> tuple[Town, Link]:
    line = arc(radius)
    parts = {"in": line[:2], "via": line[1:-1], "out": line[-2:]}
    lanes = {
        name: Lane(
            name, name, 0, np.pad(part, ((0, 0), (0, 1))), 3.5, 13.9,
            "x" if name == "via" else None, (), None, None,
        )
        for name, part in parts.items()
    }  # fmt: skip
    link = Link("in", "out", ("via",), "x", "left", "major")
    return Town("turn", lanes, (link,), {}, {}), link


def test_bus_takes_only_wide_turns_and_car_takes_all() -> None:
    wide, tight = turn(14.0), turn(9.0)
    assert fits(*wide, 9.0, 2.4)
    assert not fits(*tight, 9.0, 2.4)
    assert fits(*tight, 7.5, 2.45)
    assert fits(*turn(4.0), 5.32, 2.01)
