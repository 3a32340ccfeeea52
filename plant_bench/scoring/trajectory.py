"""An episode's trajectories as arrays: the ego at each tick, other actors every 0.2 s."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from plant_bench.world.scene import TICK, ActorKind, Actors, EgoState, Scene

SAMPLE_TICKS = 4  # ticks between samples of other actors: fewer to save time; a car moves 3 m
SAMPLE = SAMPLE_TICKS * TICK  # s

VULNERABLE = (ActorKind.PEDESTRIAN, ActorKind.BICYCLE)
VEHICLES = tuple(kind for kind in ActorKind if kind not in (*VULNERABLE, ActorKind.STATIC))


@dataclass(frozen=True, eq=False)
class ActorSamples:
    """All actors of all samples, concatenated; world frame, float64.

    Attributes:
        samples: Index of the sample that each row belongs to, ascending.
        actors: The actors, one per row.
    """

    samples: Int[np.ndarray, " actors"]
    actors: Actors

    def only(self, keep: np.ndarray) -> "ActorSamples":
        """Return the rows that a mask or an index array selects."""
        return ActorSamples(self.samples[keep], self.actors.only(keep))


@dataclass(frozen=True, eq=False)
class Trajectory:
    """An episode as arrays.

    Attributes:
        poses: The ego's pose at each tick.
        speeds: The ego's speed at each tick, m/s.
        accelerations: The ego's acceleration at each tick, m/s2.
        sample_ticks: Rows of the above at which the other actors were sampled.
        others: Samples of the other actors.
        off_lane: Metres driven off all lanes.
        wrong_lane: Metres driven on lanes of the opposite direction.
    """

    poses: Float[np.ndarray, "steps 3"]
    speeds: Float[np.ndarray, " steps"]
    accelerations: Float[np.ndarray, " steps"]
    sample_ticks: Int[np.ndarray, " samples"]
    others: ActorSamples
    off_lane: float = 0.0
    wrong_lane: float = 0.0

    def of_kinds(self, kinds: tuple[ActorKind, ...]) -> ActorSamples:
        """Return the samples of actors of these kinds."""
        return self.others.only(np.isin(self.others.actors.kinds, kinds))

    @property
    def sample_poses(self) -> Float[np.ndarray, "samples 3"]:
        """The ego's pose at each sample."""
        return self.poses[self.sample_ticks]

    @property
    def sample_speeds(self) -> Float[np.ndarray, " samples"]:
        """The ego's speed at each sample."""
        return self.speeds[self.sample_ticks]


class TrajectoryRecorder:
    """Collects the scenes of an episode; mutable. A tick costs two appends."""

    def __init__(self) -> None:
        self._egos: list[EgoState] = []
        self._ticks: list[int] = []
        self._others: list[Actors] = []

    def add(self, scene: Scene) -> None:
        """Keep a scene."""
        if scene.tick % SAMPLE_TICKS == 0:
            self._ticks.append(len(self._egos))
            self._others.append(scene.actors)
        self._egos.append(scene.ego)

    def __len__(self) -> int:
        return len(self._egos)

    def trajectory(self, *, off_lane: float = 0.0, wrong_lane: float = 0.0) -> Trajectory:
        """Return the trajectory of the scenes added so far.

        Args:
            off_lane: Metres driven off all lanes.
            wrong_lane: Metres driven on lanes of the opposite direction.
        """
        rows = [(*ego.pose, ego.speed, ego.acceleration) for ego in self._egos]
        ego = np.array(rows, dtype=float).reshape(-1, 5)
        counts = [len(actors) for actors in self._others]
        return Trajectory(
            poses=ego[:, :3],
            speeds=ego[:, 3],
            accelerations=ego[:, 4],
            sample_ticks=np.array(self._ticks, dtype=np.int64),
            others=ActorSamples(np.repeat(np.arange(len(counts)), counts), _joined(self._others)),
            off_lane=off_lane,
            wrong_lane=wrong_lane,
        )


def _joined(parts: list[Actors]) -> Actors:
    parts = [Actors.none(), *parts]

    def column(name: str, kind: type) -> np.ndarray:
        return np.concatenate([getattr(part, name) for part in parts]).astype(kind)

    return Actors(
        column("ids", np.int64),
        column("poses", float),
        column("speeds", float),
        column("extents", float),
        column("kinds", np.uint8),
    )
