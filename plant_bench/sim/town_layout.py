"""Entry points, parking places and footways of a town, computed once per process."""

from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

from plant_bench.data_files import town_dir
from plant_bench.sim.roadside.footways import Footways, read_footways
from plant_bench.sim.roadside.lane_distance import Roadway
from plant_bench.sim.roadside.parked_cars import Places, parking_places
from plant_bench.sim.traffic import StreetGrid
from plant_bench.world.town import Town, load_town


@dataclass(frozen=True, eq=False)
class TownPlaces:
    """A town with its entry points, footways and parking places; immutable."""

    town: Town
    streets: StreetGrid
    parking: Places
    footways: Footways


@lru_cache(maxsize=8)
def places_of(name: str, also_in: tuple[Path, ...] = ()) -> TownPlaces:
    """Return a town and its places; the town is searched for as in `data_files.town_dir`.

    Raises:
        InputError: There is no such town.
    """
    town = load_town(name, also_in)
    roadway = Roadway(town)
    parking = parking_places(town, roadway)
    footways = read_footways(town_dir(name, also_in) / "town.net.xml", roadway, parking.edges)
    return TownPlaces(town, StreetGrid(town), parking, footways)
