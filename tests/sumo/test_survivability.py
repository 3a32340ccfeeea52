"""Every kind of hazard can be survived by an oracle at the posted speed."""

import random

import pytest

from plant_bench.world.hazard import Hazard, HazardKind
from plant_bench.world.hazard_table import HAZARDS
from plant_bench.world.route import Route, load_suite
from tests.sumo import oracle

pytestmark = pytest.mark.sumo

FEW, MANY = 2, 100  # drives of a kind
LEAST_HIT = 0.6  # share of committed hazards that hit a blind driver
NO_ACTORS = (HazardKind.CONTROL_LOSS,)
MOST_ASIDE = 1.2  # m from the route, the most that a control loss may displace a steering driver
ROUTES = load_suite("longest6")

every_kind = pytest.mark.parametrize("kind", list(HAZARDS), ids=[kind.value for kind in HAZARDS])


def places(kind: HazardKind) -> list[tuple[Route, Hazard]]:
    found = [(r, hazard) for r in ROUTES for hazard in r.hazards if hazard.kind is kind]
    random.Random(1).shuffle(found)
    return found


def drives(kind: HazardKind, count: int, *, blind: bool = False) -> list[oracle.Drive]:
    found = places(kind)
    return [
        oracle.drive(*found[seed % len(found)], 1000 + seed, blind=blind) for seed in range(count)
    ]


def faults(done: list[oracle.Drive]) -> list[str]:
    """Return what went wrong: collisions, drives that did not arrive, a route that was left."""
    found = []
    for number, drive in enumerate(done):
        told = f"drive {number} ({drive.phase} {drive.reason}): "
        if drive.hit:
            found.append(told + "hit")
        if not drive.arrived and not drive.reason:
            found.append(told + "did not arrive")
        if drive.aside >= MOST_ASIDE:
            found.append(f"{told}{drive.aside:.2f} m from the route")
    return found


@every_kind
def test_oracle_survives_every_hazard(kind):
    done = drives(kind, FEW)
    assert len(done) == FEW
    assert faults(done) == []


@pytest.mark.slow
@pytest.mark.timeout(1800)
@every_kind
def test_oracle_survives_many_drives_of_every_hazard(kind):
    done = drives(kind, MANY)
    assert faults(done) == []
    assert sum(drive.committed for drive in done) > 0.2 * MANY


@pytest.mark.slow
@pytest.mark.timeout(1800)
@every_kind
def test_blind_driver_is_hit_by_most_hazards(kind):
    if kind in NO_ACTORS:
        pytest.skip("nobody takes part")
    committed = [drive for drive in drives(kind, MANY // 4, blind=True) if drive.committed]
    assert sum(drive.hit for drive in committed) >= LEAST_HIT * len(committed)
