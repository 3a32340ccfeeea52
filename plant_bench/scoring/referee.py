"""The referee: scores an episode scene by scene, detects infractions and its end.

It uses scenes only, so that a recording can be scored again without a simulator. It runs at every
tick: cheap checks in plain Python come first, and costly tests run only when these find that an
infraction is possible.
"""

import math

from plant_bench.errors import InputError
from plant_bench.scoring.collisions import CollisionDetector
from plant_bench.scoring.episode_measures import Measures, measure
from plant_bench.scoring.infractions import Infraction, InfractionKind, Status
from plant_bench.scoring.lanes import LaneFault, lane_map
from plant_bench.scoring.red_lights import RedLights
from plant_bench.scoring.results import Crash, EpisodeHeader, EpisodeResult, HazardRecord
from plant_bench.scoring.termination import ENDING_INFRACTIONS, Termination
from plant_bench.scoring.trajectory import TrajectoryRecorder
from plant_bench.world.route import Route
from plant_bench.world.route_progress import RouteProgress
from plant_bench.world.scene import EgoState, Scene
from plant_bench.world.town import Town

# A vehicle this near the route line and heading this way is on a lane of the right direction.
ON_ROUTE_OFFSET = 1.0  # m, less than half of any lane's width
ON_ROUTE_COSINE = 0.5  # 60 degrees, half of what is wrong way


class Referee:
    """Scores one episode; mutable.

    Attributes:
        status: How the episode ended, None while it runs.
        completion: Share of the route completed, 0 to 1.
        infractions: Infractions so far, in order of time.
        distance: Metres driven.
        outside_distance: Metres driven outside the lanes or against their direction.
        off_lane_distance: Metres driven off all lanes; a part of `outside_distance`.
        wrong_lane_distance: Metres driven against the lane's direction; the other part of it.
        measures: Metrics besides the score; None until `finish`, and if there was no scene.
        time: Seconds from the start of the episode to the last scene judged.

    Args:
        town: The town driven in.
        route: The route to be driven.
    """

    def __init__(self, town: Town, route: Route) -> None:
        self.status: Status | None = None
        self.completion = 0.0
        self.infractions: list[Infraction] = []
        self.distance = 0.0
        self.outside_distance = 0.0
        self.off_lane_distance = 0.0
        self.wrong_lane_distance = 0.0
        self.measures: Measures | None = None
        self.time = 0.0
        self.route_length = route.length
        self._town = town
        self._elevations = route.elevations.tolist()
        self._place = RouteProgress(route)
        self._collisions = CollisionDetector()
        self._red_lights = RedLights(route)
        self._termination = Termination(route)
        self._trajectory = TrajectoryRecorder()
        self._last: Scene | None = None
        self._finished = False

    @property
    def progress(self) -> float:
        """Metres along the route; never decreases."""
        return self._place.progress

    @property
    def offset(self) -> float:
        """Lateral distance from the route in metres, positive to the left."""
        return self._place.offset

    def judge(self, scene: Scene) -> None:
        """Judge the next scene; scenes after the end of the episode are ignored."""
        if self.status is not None:
            return
        ego, place = scene.ego, self._place
        last = (self._last or scene).ego
        step = math.hypot(ego.x - last.x, ego.y - last.y)
        before = place.progress
        place.follow(ego.x, ego.y)
        self._last = scene
        self._trajectory.add(scene)
        self.time = scene.time
        self.distance += step
        self.completion = min(place.progress / self.route_length, 1.0)
        if step > 0.0:
            self._check_lane(ego, step)
        for hit in self._collisions.new(scene):
            self._note(hit.kind, actor=hit.actor, actor_kind=hit.actor_kind, cause=hit.cause)
        if self._red_lights.run(before, place.progress, place.offset, scene.lights):
            self._note(InfractionKind.RED_LIGHT)
        self.status = self._termination.check(scene.tick, ego, place, step)
        if self.status is Status.COMPLETED:
            self.completion = 1.0
        elif self.status is not None:
            self._note(ENDING_INFRACTIONS[self.status])

    def finish(self) -> None:
        """Close the episode: add the OUTSIDE_LANES infraction and compute the measures."""
        if self._finished:
            return
        self._finished = True
        if self.outside_distance > 0.0:
            share = min(self.outside_distance / self.distance, 1.0)
            self._note(InfractionKind.OUTSIDE_LANES, share=share)
        if len(self._trajectory):
            self.measures = measure(
                self._trajectory.trajectory(
                    off_lane=self.off_lane_distance, wrong_lane=self.wrong_lane_distance
                )
            )

    def _check_lane(self, ego: EgoState, step: float) -> None:
        """Add the step to the distance driven outside the lanes if the ego is outside."""
        place = self._place
        if place.distance < ON_ROUTE_OFFSET and math.cos(ego.yaw - place.heading) > ON_ROUTE_COSINE:
            return
        height = self._elevations[place.index]
        fault = lane_map(self._town).fault(ego.x, ego.y, height, ego.yaw)
        if fault is None:
            return
        self.outside_distance += step
        if fault is LaneFault.OFF_LANE:
            self.off_lane_distance += step
        else:
            self.wrong_lane_distance += step

    def _note(self, kind: InfractionKind, **facts: object) -> None:
        if self._last is None:
            return
        ego = self._last.ego
        self.infractions.append(
            Infraction.model_validate(
                {
                    "kind": kind,
                    "time": round(self._last.time, 3),
                    "x": round(ego.x, 3),
                    "y": round(ego.y, 3),
                    "progress": round(self.progress, 3),
                    **facts,
                }
            )
        )


def result_of(
    referee: Referee,
    header: EpisodeHeader,
    *,
    crash: Crash | None = None,
    hazards: tuple[HazardRecord, ...] = (),
) -> EpisodeResult:
    """Close an episode and return its record.

    Args:
        referee: The referee that scored it.
        header: The part of the record known before the start.
        crash: The crash that ended it, if no rule did.
        hazards: Outcomes of the route's hazards; only the simulator knows them.

    Raises:
        InputError: The episode is not over.
    """
    status = referee.status or (crash and crash.status)
    if status is None:
        message = f"Route {header.route}: the episode has not ended after {referee.time:.2f} s."
        raise InputError(message)
    referee.finish()
    return EpisodeResult(
        **header.model_dump(include=set(EpisodeHeader.model_fields)),
        status=status,
        reason=crash.reason if crash is not None and referee.status is None else "",
        route_length=referee.route_length,
        completion=referee.completion,
        distance=referee.distance,
        duration=round(referee.time, 3),
        infractions=tuple(referee.infractions),
        measures=referee.measures,
        hazards=hazards,
    )
