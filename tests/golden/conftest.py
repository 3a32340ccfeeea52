"""A stage for hand-made episodes: a straight road of 300 m, and scenes put together by code.

    y = 3.5   <---- west ----            oncoming lane, 3.5 m wide
    y = 0     ---- east ---->[junction]----> east again; the route, from x = 0 to x = 300
                             ^ x = 150: stop line and signal; the lanes through the
                                       junction end at x = 170, its outline at x = 172

From x = 200 to x = 230 a bridge crosses the road 6 m above it (`over`, heading north).
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np
import pytest

from plant_bench.scoring.referee import Referee
from plant_bench.world.route import LaneSpan, Passage, Route
from plant_bench.world.scene import TICK, ActorKind, EgoState, Light, Scene
from plant_bench.world.town import Junction, Town
from tests.builders import make_actors, make_lane, make_scene

LENGTH = 300.0
STOP_LINE = 150.0


@dataclass(frozen=True)
class Other:
    """An actor of a scene."""

    x: float
    y: float = 0.0
    yaw: float = 0.0
    speed: float = 0.0
    id: int = 1
    kind: ActorKind = ActorKind.CAR
    extent: tuple[float, float] = (4.0, 2.0)


Others = Sequence[Other] | Callable[[int], Sequence[Other]]


@dataclass
class EpisodeBuilder:
    """Builds an episode step by step; mutable."""

    town: Town
    route: Route
    scenes: list[Scene] = field(default_factory=list)
    x: float = 0.0
    other: ClassVar[type[Other]] = Other

    def drive(
        self,
        to: float,
        *,
        y: float = 0.0,
        speed: float = 10.0,
        yaw: float | None = None,
        others: Others = (),
        light: Light = Light.GREEN,
    ) -> "EpisodeBuilder":
        """Drive along x at a constant y; the last step may be shorter."""
        heading = (0.0 if to >= self.x else math.pi) if yaw is None else yaw
        while abs(to - self.x) > 1e-9:
            step = min(speed * TICK, abs(to - self.x))
            self.x += math.copysign(step, to - self.x)
            self._add(EgoState(self.x, y, heading, speed), others, light)
        return self

    def stand(
        self,
        ticks: int,
        *,
        y: float = 0.0,
        speed: float = 0.0,
        others: Others = (),
        light: Light = Light.GREEN,
    ) -> "EpisodeBuilder":
        """Stay in place; `speed` is the speed that the scene states."""
        for _ in range(ticks):
            self._add(EgoState(self.x, y, 0.0, speed), others, light)
        return self

    def verdict(self) -> Referee:
        """Judge the episode up to the current scene."""
        referee = Referee(self.town, self.route)
        for scene in self.scenes:
            referee.judge(scene)
        referee.finish()
        return referee

    def kinds(self) -> list[str]:
        """Return the kinds of the infractions up to the current scene."""
        return [str(infraction.kind) for infraction in self.verdict().infractions]

    def _add(self, ego: EgoState, others: Others, light: Light) -> None:
        tick = len(self.scenes)
        seen = list(others(tick) if callable(others) else others)
        actors = make_actors(
            [(item.x, item.y, item.yaw) for item in seen],
            speeds=[item.speed for item in seen],
            extents=[item.extent for item in seen],
            kinds=[item.kind for item in seen],
            ids=[item.id for item in seen],
        )
        self.scenes.append(make_scene(tick, ego=ego, actors=actors, lights=[light]))


def straight_road() -> Town:
    """Build the town of this module's docstring."""
    lanes = [
        make_lane("east_0", [(-50, 0), (150, 0)]),
        make_lane(":junction_0", [(150, 0), (170, 0)], junction="junction"),
        make_lane("onward_0", [(170, 0), (350, 0)]),
        make_lane("home_0", [(350, 3.5), (170, 3.5)]),
        make_lane(":junction_1", [(170, 3.5), (150, 3.5)], junction="junction"),
        make_lane("west_0", [(150, 3.5), (-50, 3.5)]),
        make_lane("over_0", [(215, -100, 6), (215, 100, 6)]),
    ]
    outline = ((150.0, -2.0), (172.0, -2.0), (172.0, 5.5), (150.0, 5.5))
    junction = Junction("junction", "signal", 160.0, 1.75, 2, outline)
    return Town(
        "stage", {lane.id: lane for lane in lanes}, (), {"junction": junction}, {"light": 1}
    )


def eastward() -> Route:
    """Build the route of this module's docstring."""
    x = np.arange(LENGTH + 1.0)
    return Route(
        id="stage-0",
        town="stage",
        points=np.stack((x, np.zeros_like(x)), axis=1),
        elevations=np.zeros_like(x),
        speed_limits=np.full_like(x, 13.9),
        edges=("east", "onward"),
        lanes=(LaneSpan("east_0", 0.0, 150.0), LaneSpan("onward_0", 170.0, 300.0)),
        passages=(Passage("junction", STOP_LINE, 170.0, "straight", "signal", "light", 0),),
        lane_changes=(),
        manoeuvres={"straight": 1},
    )


@pytest.fixture
def stage() -> EpisodeBuilder:
    """An empty stage, the ego about to start."""
    return EpisodeBuilder(straight_road(), eastward())
