"""What an episode leaves behind for its measures: the ego at each tick, the others now and then."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from plant_bench.world.scene import TICK, ActorKind, Actors, EgoState, Scene

SAMPLE_TICKS = 4  # ticks between two looks at the others: the cost, and a car moves 3 m in it
SAMPLE = SAMPLE_TICKS * TICK  # s

VULNERABLE = (ActorKind.PEDESTRIAN, ActorKind.BICYCLE)
VEHICLES = tuple(kind for kind in ActorKind if kind not in (*VULNERABLE, ActorKind.STATIC))


@dataclass(frozen=True, eq=False)
class ActorSamples:
    """Every actor of every sample, one after the other; world frame, float64.

    Attributes:
        samples: The sample that each sighting is of, ascending.
        actors: Who was seen.
    """

    samples: Int[np.ndarray, " actors"]
    actors: Actors

    def only(self, keep: np.ndarray) -> "ActorSamples":
        """Return the actor_samples that a mask or an index array selects."""
        return ActorSamples(self.samples[keep], self.actors.only(keep))


@dataclass(frozen=True, eq=False)
class Trajectory:
    """An episode as arrays.

    Attributes:
        poses: The ego at each tick.
        speeds: As above.
        accelerations: As above.
        sample_ticks: At which of these rows the others were looked at.
        seen: The others.
        off_lane: Metres driven off all lanes.
        wrong_lane: Metres driven on lanes of the other direction.
    """

    poses: Float[np.ndarray, "steps 3"]
    speeds: Float[np.ndarray, " steps"]
    accelerations: Float[np.ndarray, " steps"]
    sample_ticks: Int[np.ndarray, " samples"]
    seen: ActorSamples
    off_lane: float = 0.0
    wrong_lane: float = 0.0

    def of_kinds(self, kinds: tuple[ActorKind, ...]) -> ActorSamples:
        """Return the actor_samples of actors of these kinds."""
        return self.seen.only(np.isin(self.seen.actors.kinds, kinds))

    @property
    def sample_poses(self) -> Float[np.ndarray, "samples 3"]:
        """The ego's pose at each sample."""
        return self.poses[self.sample_ticks]

    @property
    def sample_speeds(self) -> Float[np.ndarray, " samples"]:
        """The ego's speed at each sample."""
        return self.speeds[self.sample_ticks]


class TrajectoryRecorder:
    """Keeps scenes until the episode is over; mutable. A tick costs two appends."""

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
        """Return what was kept.

        Args:
            off_lane: Metres driven off all lanes.
            wrong_lane: Metres driven on lanes of the other direction.
        """
        rows = [(*ego.pose, ego.speed, ego.acceleration) for ego in self._egos]
        ego = np.array(rows, dtype=float).reshape(-1, 5)
        counts = [len(actors) for actors in self._others]
        return Trajectory(
            poses=ego[:, :3],
            speeds=ego[:, 3],
            accelerations=ego[:, 4],
            sample_ticks=np.array(self._ticks, dtype=np.int64),
            seen=ActorSamples(np.repeat(np.arange(len(counts)), counts), _joined(self._others)),
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
