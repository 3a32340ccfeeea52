"""Ranges of actor ids, by what moves the actor.

The simulation assigns ids; other code uses the properties of `Actors`. The kind tells what an actor
is, the id what moves it: a parked car has the kind of any other car.
"""

EGO = 0
TRAFFIC = range(1, 500_000)  # SUMO vehicles, and actors of hazards, pedestrians too
PEDESTRIANS = range(500_000, 700_000)  # on sidewalks and crossings
SUMO_PROXIES = range(700_000, 1_000_000)  # represent pedestrians in SUMO; in no scene
PARKED = range(1_000_000, 2**63)


def is_parked(number: int) -> bool:
    """Tell whether an id is that of a parked car.

    >>> is_parked(PARKED.start), is_parked(PARKED.start - 1)
    (True, False)
    """
    return number in PARKED
