"""Layout generators, one per character of town: each makes a street plan of a spec and a seed."""

from collections.abc import Callable

import numpy as np

from plant_bench.towns.characters.figure_eight import lay_out_figure_eight
from plant_bench.towns.characters.large_town import lay_out_large_town
from plant_bench.towns.characters.lattice import lay_out_lattice
from plant_bench.towns.characters.long_highway import lay_out_long_highway
from plant_bench.towns.characters.small_town import lay_out_small_town
from plant_bench.towns.street_plan import StreetPlan
from plant_bench.towns.town_spec import TownSpec

LayOut = Callable[[TownSpec, np.random.Generator], StreetPlan]

CHARACTERS: dict[str, LayOut] = {
    "small_town": lay_out_small_town,
    "figure_eight": lay_out_figure_eight,
    "large_town": lay_out_large_town,
    "lattice": lay_out_lattice,
    "long_highway": lay_out_long_highway,
}
