"""How the ego kept up with the traffic around it."""

import numpy as np

from plant_bench.scoring.endings import BLOCKED_SPEED
from plant_bench.scoring.paths import followers
from plant_bench.scoring.track import VEHICLES, Sightings, Track

AROUND = 50.0  # m: own choice; leaderboard 2.0 takes the whole map


def standing_share(track: Track) -> float:
    """Return the share of time in which the ego stood."""
    return float((track.speeds < BLOCKED_SPEED).mean())


def relative_speed(track: Track) -> float | None:
    """Return the ego's mean speed over that of the vehicles around it, as leaderboard 2.0 does.

    Vehicles in any direction within `AROUND` count, waiting ones too. Those that never moved in
    sight are parked, and those that follow the ego go as fast as it lets them: neither counts.
    Moments without any vehicle count for neither speed. None if there was none ever.
    """
    others = track.of_kinds(VEHICLES)
    others = others.only(_count(track, others))
    size = len(track.sample_ticks)
    number = np.bincount(others.samples, minlength=size)
    total = np.bincount(others.samples, others.actors.speeds, minlength=size)
    met = number > 0
    traffic = float((total[met] / number[met]).sum())
    return float(track.sample_speeds[met].sum()) / traffic if traffic > 0.0 else None


def _count(track: Track, others: Sightings) -> np.ndarray:
    """Tell which sightings are of the traffic around the ego."""
    actors, ego = others.actors, track.sample_poses[others.samples]
    apart = actors.poses[:, :2] - ego[:, :2]
    around = np.hypot(apart[:, 0], apart[:, 1]) <= AROUND
    _, who = np.unique(actors.ids, return_inverse=True)
    fastest = np.zeros(who.max(initial=-1) + 1)
    np.maximum.at(fastest, who, actors.speeds)
    return around & ~followers(track, others) & (fastest[who] >= BLOCKED_SPEED)
