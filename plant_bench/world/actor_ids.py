"""Ranges of actor ids: one for the ego, SUMO traffic, pedestrians, their proxies, parked cars.

The simulation assigns ids; other code uses the properties of `Actors`. An actor's
kind does not depend on its range: a parked car has the kind of any other car.
"""

EGO = 0
TRAFFIC = range(1, 500_000)  # SUMO vehicles, and all actors of hazards, also pedestrians
PEDESTRIANS = range(500_000, 700_000)  # on sidewalks and crossings
SUMO_PROXIES = range(700_000, 1_000_000)  # represent pedestrians in SUMO; not part of scenes
PARKED = range(1_000_000, 2**63)


def is_parked(number: int) -> bool:
    """Return whether an id is that of a parked car.

    >>> is_parked(PARKED.start), is_parked(PARKED.start - 1)
    (True, False)
    """
    return number in PARKED
