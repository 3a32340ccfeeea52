"""Who is given which numbers. The simulation hands them out; all others ask `Actors`.

Kinds tell what an actor is, numbers who moves it: a parked car is of the kind of any other car.
"""

EGO = 0
TRAFFIC = range(1, 500_000)  # vehicles that SUMO knows, and whom hazards put out, on foot as well
PEDESTRIANS = range(500_000, 700_000)  # of the sidewalks
SUMO_PROXIES = range(
    700_000, 1_000_000
)  # small vehicles that show pedestrians to SUMO; in no scene
PARKED = range(1_000_000, 2**63)


def is_parked(number: int) -> bool:
    """Tell whether a number is that of a parked car.

    >>> is_parked(PARKED.start), is_parked(PARKED.start - 1)
    (True, False)
    """
    return number in PARKED
