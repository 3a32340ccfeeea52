"""Converts recordings to training frames at 2 Hz, the same for every learner.

The columns of `rows_of` hold the recorded scenes, the ego's position on its route and the targets
(see `TargetKind`). `frame_of` builds a frame from them on demand, with the same function that
computes a planner's observations in closed loop.
"""

from collections.abc import Mapping
from typing import Literal

import numpy as np
from jaxtyping import Float

from plant_bench.agent import PLAN_INTERVAL, PLAN_STEPS, Control, Input, Observation
from plant_bench.data.recording import Recording
from plant_bench.data.tick_log import Action
from plant_bench.errors import InputError
from plant_bench.features.limits import allowed_speed
from plant_bench.features.rollouts import STEP, ego_poses, rollout
from plant_bench.geometry.pose import to_frame
from plant_bench.learner import Frame
from plant_bench.sensing.observe import Sensors
from plant_bench.world.route import PROTOCOL, Route
from plant_bench.world.route_progress import RouteProgress
from plant_bench.world.scene import TICK, Actors, EgoState, Scene

SAMPLE_TICKS = round(PLAN_INTERVAL / TICK)  # 10: data at 2 Hz (PlanT, section 4)
HORIZON = PLAN_STEPS * SAMPLE_TICKS  # ticks
SKIPPED_FIRST = 5  # samples of each episode (PlanT, dataset.py)
SKIPPED_LAST = 2  # as above; the last four have no complete future anyway
MAX_ACTION_AGE = 4  # ticks: the longest interval between two decisions of the expert
WAYPOINT_STEPS = slice(
    round(PLAN_INTERVAL / STEP),
    round(PLAN_STEPS * PLAN_INTERVAL / STEP) + 1,
    round(PLAN_INTERVAL / STEP),
)  # steps of a rollout at the waypoints' times
_INPUTS = frozenset({Input.ROUTE})

TargetKind = Literal["future", "expert-action"]

Rows = dict[str, np.ndarray]
# One row per frame:
OF_FRAMES = ("at", "progress", "offset", "future", "answered", "answer", "disturbed")
# One row per instant: the frames' at 2 Hz, one before the first and one after the last:
OF_INSTANTS = ("tick", "ego", "actor_count", "light_count")
OF_ACTORS = ("ids", "poses", "speeds", "extents", "kinds")  # one row per actor and instant
OF_LIGHTS = ("lights",)  # one row per light and instant


def rows_of(recording: Recording, route: Route) -> Rows:
    """Return the frames of an episode as columns, see `OF_FRAMES`, `OF_INSTANTS` and so on.

    Ego poses are needed at every tick, actors at every tenth only. `future` holds the driven
    waypoints, `answered` those along the route if the acceleration of the expert's action (column
    `answer`) is held, NaN without an action; both in the frame's ego frame, metres.

    Raises:
        InputError: The recording is of another route or protocol, or a tick is missing.
    """
    check_route(recording, route)
    kept = _frame_rows(len(recording))
    grid = _instant_rows(kept)
    scenes = {row: recording[row] for row in grid}
    for row in kept:
        if scenes[row].tick != row:
            message = (
                f"Expected tick {row} in row {row} of the recording, got tick {scenes[row].tick}."
            )
            raise InputError(message)
    return _instants([scenes[row] for row in grid]) | _frames(recording, route, kept)


def frame_of(
    rows: Mapping[str, np.ndarray],
    place: tuple[int, int, int, int],
    route: Route,
    *,
    targets: TargetKind,
    inputs: frozenset[str],
    seed: int,
) -> Frame:
    """Build a frame from its columns.

    Args:
        rows: Columns of one or more episodes.
        place: The frame's row, the row of its instant, and the first rows of the instant's actors
            and lights. The instants before and after are in the adjacent rows.
        route: The route driven.
        targets: Kind of the waypoints.
        inputs: The inputs in the observation.
        seed: Seed of the episode.
    """
    row, at, actors, lights = place
    counts = rows["actor_count"]
    ends = (actors - int(counts[at - 1]), actors, actors + int(counts[at]))
    before, now, later = (
        _actors(rows, start, int(counts[at + step]))
        for start, step in zip(ends, (-1, 0, 1), strict=True)
    )
    ego = EgoState(*rows["ego"][at].tolist())
    shown = np.array(rows["lights"][lights : lights + int(rows["light_count"][at])])
    scene = Scene(int(rows["tick"][at]), ego, now, shown)
    progress, offset = float(rows["progress"][row]), float(rows["offset"][row])
    acceleration, steering = rows["answer"][row].tolist()
    return Frame(
        observation=Sensors(route, seed, inputs).observe(scene, progress, offset),
        before=before,
        later=later,
        waypoints=np.array(rows["future" if targets == "future" else "answered"][row]),
        answer=None if np.isnan(acceleration) else Control(acceleration, steering),
        disturbed=bool(rows["disturbed"][row]),
        route=route,
        seed=seed,
    )


def check_route(recording: Recording, route: Route) -> None:
    """Check that a recording is of a route, and of the current protocol.

    Raises:
        InputError: It is not.
    """
    known = recording.metadata.get("route_checksum")
    if known != route.checksum:
        message = (
            f"The recording of route {recording.metadata.get('route')} ({str(known)[:12]}) does "
            f"not match route {route.id} ({route.checksum[:12]}): restore the driven routes."
        )
        raise InputError(message)
    protocol = str(recording.metadata.get("protocol"))
    if not protocol.startswith(PROTOCOL):
        message = (
            f"Expected a recording of protocol '{PROTOCOL}', got '{protocol}'. Collect the data "
            "again."
        )
        raise InputError(message)


def no_action_message(row: int) -> str:
    """Return the error message for a frame without an expert action."""
    return (
        f"Row {row} of the recording has no acceleration of an expert, so --targets expert-action "
        "is not possible. Use --targets future to train on the driven path."
    )


def _frame_rows(length: int) -> range:
    """Return the rows of the frames: those with a complete future, without the skipped ends."""
    first = SKIPPED_FIRST * SAMPLE_TICKS
    last_sample = (length - 1) // SAMPLE_TICKS - SKIPPED_LAST
    last = min(last_sample * SAMPLE_TICKS, length - 1 - HORIZON)
    return range(first, last + 1, SAMPLE_TICKS)


def _instant_rows(kept: range) -> range:
    if not kept:
        return range(0)
    return range(kept[0] - SAMPLE_TICKS, kept[-1] + SAMPLE_TICKS + 1, SAMPLE_TICKS)


def _instants(scenes: list[Scene]) -> Rows:
    actors = [scene.actors for scene in scenes]
    egos = [
        (ego.x, ego.y, ego.yaw, ego.speed, ego.acceleration, ego.steering)
        for ego in (scene.ego for scene in scenes)
    ]
    no_actors, no_lights = [Actors.none()], [np.zeros(0, np.uint8)]
    return {
        "tick": np.array([scene.tick for scene in scenes], np.int32),
        "ego": np.array(egos, float).reshape(-1, 6),
        "actor_count": np.array([len(item) for item in actors], np.int32),
        "light_count": np.array([len(scene.lights) for scene in scenes], np.int32),
        "lights": np.concatenate([*no_lights, *(scene.lights for scene in scenes)]),
    } | {
        name: np.concatenate([getattr(item, name) for item in (*no_actors, *actors)])
        for name in OF_ACTORS
    }


def _frames(recording: Recording, route: Route, kept: range) -> Rows:
    count = len(kept)
    rows: Rows = {
        "at": np.arange(1, count + 1, dtype=np.int32),
        "progress": np.zeros(count),
        "offset": np.zeros(count),
        "future": np.zeros((count, PLAN_STEPS, 2), np.float32),
        "answered": np.full((count, PLAN_STEPS, 2), np.nan, np.float32),
        "answer": np.full((count, 2), np.nan),
        "disturbed": np.zeros(count, bool),
    }
    places, actions = recording.egos[:, :2], recording.actions
    driven, followed = RouteProgress(route), 0
    sensors = Sensors(route, 0, _INPUTS)
    for place, row in enumerate(kept):
        for x, y in places[followed : row + 1].tolist():
            driven.follow(x, y)
        followed = row + 1
        scene = recording[row]
        rows["progress"][place], rows["offset"][place] = driven.progress, driven.offset
        rows["disturbed"][place] = recording.disturbed[row : row + HORIZON].any()
        rows["future"][place] = to_frame(places[_future_rows(row)], *scene.ego.pose)
        answer = _latest_action(actions, row)
        if answer is not None:
            seen = sensors.observe(scene, driven.progress, driven.offset)
            rows["answer"][place] = answer.acceleration, answer.steering
            rows["answered"][place] = to_frame(_action_path(answer, seen), *scene.ego.pose)
    return rows


def _future_rows(row: int) -> slice:
    return slice(row + SAMPLE_TICKS, row + HORIZON + 1, SAMPLE_TICKS)


def _latest_action(actions: list[Action], row: int) -> Control | None:
    """Return the latest action if it is a control; None without a recent one, or for a plan."""
    recent = (actions[at] for at in range(row, max(row - MAX_ACTION_AGE, -1), -1))
    last = next((action for action in recent if action is not None), None)
    return last if isinstance(last, Control) else None


def _action_path(answer: Control, observation: Observation) -> Float[np.ndarray, "waypoints 2"]:
    """Return the waypoints if an action's acceleration is held, in the world frame, metres."""
    route = observation.route
    assert route is not None  # noqa: S101  `_INPUTS` includes the route
    top = allowed_speed(route)
    travel = rollout(observation.ego.speed, np.array([answer.acceleration]), top)
    return ego_poses(route, travel)[0, WAYPOINT_STEPS, :2]


def _actors(rows: Mapping[str, np.ndarray], start: int, count: int) -> Actors:
    return Actors(*(np.array(rows[name][start : start + count]) for name in OF_ACTORS))
