"""The suite `unseen` shares nothing with the benchmark or with the training towns."""

import numpy as np
import pytest

from plant_bench.errors import InputError
from plant_bench.towns import training_towns
from plant_bench.towns.generate import town_names, town_spec
from plant_bench.towns.routes import SUITES
from plant_bench.towns.unseen_towns import UNSEEN
from plant_bench.world.route import load_suite
from plant_bench.world.town import Town, load_town

MOST_LAYOUTS = 7  # further ones of a character, "-b" to "-h"


def seeds_of_training_towns(monkeypatch, folder):
    """Return all seeds that a training town could use, including future ones."""
    tried: set[int] = set()

    def note(_, seed):
        tried.add(seed)
        raise InputError("not sound")

    monkeypatch.setattr(training_towns, "make_town", note)
    monkeypatch.setattr(training_towns, "LAYOUTS", MOST_LAYOUTS)
    for town in training_towns.training_towns():
        if town.layout:
            with pytest.raises(InputError, match="not sound"):
                training_towns.build_training_town(town, folder)
    return tried


def streets(town: Town) -> set[tuple[float, ...]]:
    """Return where the lanes start and end, to the metre."""
    lanes = (lane for lane in town.lanes.values() if lane.junction is None)
    return {tuple(np.round(lane.points[[0, -1], :2]).ravel().tolist()) for lane in lanes}


def test_unseen_towns_use_seeds_of_their_own(monkeypatch, tmp_path):
    seeds = {town_spec(name).seed for name in UNSEEN}
    training = seeds_of_training_towns(monkeypatch, tmp_path)
    assert len(seeds) == 6
    assert len(training) == MOST_LAYOUTS * training_towns.SEED_TRIES
    assert seeds.isdisjoint(training)
    assert seeds.isdisjoint(town_spec(name).seed for name in town_names())


def test_unseen_towns_are_not_used_for_training():
    towns = {route.town for route in load_suite("unseen")}
    assert towns == set(UNSEEN) == set(SUITES["unseen"].lengths)
    assert towns.isdisjoint(town.name for town in training_towns.training_towns())
    assert towns.isdisjoint(route.town for route in load_suite("longest6"))
    assert SUITES["unseen"].seed != SUITES["longest6"].seed


@pytest.mark.parametrize("name", UNSEEN)
def test_unseen_town_has_the_same_character_and_other_streets(name):
    spec, base = town_spec(name), town_spec(UNSEEN[name].base)
    assert spec.model_copy(update={"name": base.name, "seed": base.seed}) == base
    mine, others = streets(load_town(name)), streets(load_town(base.name))
    assert len(mine & others) < 0.05 * len(mine)
    assert load_town(name).life == load_town(base.name).life
