"""Simulates an episode again by executing its recorded controls, tick by tick.

Episodes are deterministic, so the simulator reproduces the recorded scenes and can supply the
privileged facts, which are not recorded. Equality of the scenes is checked at every tick.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from plant_bench.agent import Control, Input, Privileged
from plant_bench.controller import control_of
from plant_bench.data.recording import Recording
from plant_bench.errors import InputError
from plant_bench.runner.episode.loop import Episode
from plant_bench.scoring.results import EpisodeResult
from plant_bench.world.route import Route, Scenario
from plant_bench.world.scene import Scene


@dataclass(frozen=True, eq=False, slots=True)
class Tick:
    """One tick of a recording, simulated again.

    Attributes:
        row: Row of the recording.
        recorded: The recorded scene.
        difference: How the simulated scene differs; empty if both are equal.
        control: The control executed at this tick: that of the latest recorded action or, if SUMO's
            driver model drives, the recorded acceleration and steering.
        decided: Whether the recording has a decision of the planner at this tick.
        facts: Returns the privileged facts of the simulated scene; to be called before the next
            tick. They belong to the recorded scene if there is no difference.
        episode: The simulated episode; its referee has judged this scene.
    """

    row: int
    recorded: Scene
    difference: str
    control: Control
    decided: bool
    facts: Callable[[], Privileged]
    episode: Episode


def scenario_of(result: EpisodeResult, route: Route) -> Scenario:
    """Return the scenario of a recorded episode.

    Raises:
        InputError: The route has changed since.
    """
    for hazards in (True, False):
        scenario = Scenario(route, result.seed, result.density, hazards)
        if scenario.key == result.scenario:
            return scenario
    message = (
        f"Route {result.route} has changed since this episode was driven (checksum "
        f"{result.route_checksum[:12]}, now {route.checksum[:12]}), so the episode cannot be "
        "simulated again. Score the run again."
    )
    raise InputError(message)


def simulate_again(
    recording: Recording, result: EpisodeResult, route: Route, *, until: int | None = None
) -> Iterator[Tick]:
    """Simulate a recorded episode again; the simulation ends with the iteration.

    Args:
        recording: Recording of every tick.
        result: The episode's record.
        route: The route it was driven on.
        until: Last tick to simulate; None for the whole episode.

    Raises:
        InputError: The recording is thinned, the route has changed or the town is missing.
        SimulationError: SUMO fails.
    """
    if len(recording.complete_rows) < len(recording):
        message = "A thinned recording does not contain every tick and cannot be simulated again."
        raise InputError(message)
    scenario = scenario_of(result, route)
    last = len(recording) - 1 if until is None else min(until, len(recording) - 1)
    actions = recording.actions
    control = Control(0.0, 0.0)
    self_driving = Input.SIMULATOR.value in result.inputs
    with Episode(scenario, self_driving=self_driving) as episode:
        simulation = episode.simulation
        for row in range(last + 1):
            scene, action = recording[row], actions[row]
            if self_driving:  # the planner's controls have no effect
                control = Control(scene.ego.acceleration, scene.ego.steering)
            elif action is not None:
                control = control_of(action, scene.ego)
            difference = scene_difference(scene, episode.scene)
            yield Tick(
                row,
                scene,
                difference,
                control,
                action is not None,
                simulation.privileged,
                episode,
            )
            if row < last:
                episode.advance(control)


def scene_difference(one: Scene, other: Scene) -> str:
    """Return how two scenes differ, compared exactly; empty if they are equal."""
    if one.tick != other.tick:
        return f"tick {one.tick}, simulated {other.tick}"
    if one.ego != other.ego:
        return "the ego"
    if not np.array_equal(one.actors.ids, other.actors.ids):
        ids = sorted({*one.actors.ids.tolist()} ^ {*other.actors.ids.tolist()})
        return f"the set of actors ({', '.join(map(str, ids[:3]))})"
    for name in ("poses", "speeds", "extents", "kinds"):
        if not np.array_equal(getattr(one.actors, name), getattr(other.actors, name)):
            return f"the actors' {name}"
    return "" if np.array_equal(one.lights, other.lights) else "the traffic lights"
