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
        row: Of the recording.
        recorded: The scene as it was recorded.
        difference: What of the simulated scene is another; empty where both are equal.
        control: What is executed now: the recorded answer, held until the next one; what was driven
            last where SUMO's own driver drives.
        decided: Whether the planner was asked at this tick.
        facts: Tells what only the simulator knows of this scene; true of it if nothing differs, and
            to be asked before the next tick.
        episode: The episode as it is simulated now; judged up to this scene.
    """

    row: int
    recorded: Scene
    difference: str
    control: Control
    decided: bool
    facts: Callable[[], Privileged]
    episode: Episode


def scenario_of(result: EpisodeResult, route: Route) -> Scenario:
    """Return the scenario of an episode that was driven.

    Raises:
        InputError: The route is another one now.
    """
    for hazards in (True, False):
        scenario = Scenario(route, result.seed, result.density, hazards)
        if scenario.key == result.scenario:
            return scenario
    message = (
        f"Route {result.route} is not what it was when this episode was driven "
        f"({result.route_checksum[:12]}, now {route.checksum[:12]}): it cannot be simulated again. "
        "Score the run again."
    )
    raise InputError(message)


def simulate_again(
    recording: Recording, result: EpisodeResult, route: Route, *, until: int | None = None
) -> Iterator[Tick]:
    """Simulate a recorded episode again; the simulation ends with the iteration.

    Args:
        recording: Of every tick.
        result: The episode's record.
        route: The route it was driven on.
        until: The last tick that is wanted; None for the whole episode.

    Raises:
        InputError: The recording is thinned, the route has changed or the town is not there.
        SimulationError: SUMO fails.
    """
    if len(recording.complete_rows) < len(recording):
        message = "A thinned recording does not hold every tick: it cannot be simulated again."
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
            if self_driving:  # what the planner asks for goes unheard
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
    """Return in what two scenes differ, number for number; empty if in nothing."""
    if one.tick != other.tick:
        return f"tick {one.tick}, again {other.tick}"
    if one.ego != other.ego:
        return "the ego"
    if not np.array_equal(one.actors.ids, other.actors.ids):
        who = sorted({*one.actors.ids.tolist()} ^ {*other.actors.ids.tolist()})
        return f"who is in sight ({', '.join(map(str, who[:3]))})"
    for name in ("poses", "speeds", "extents", "kinds"):
        if not np.array_equal(getattr(one.actors, name), getattr(other.actors, name)):
            return f"the actors' {name}"
    return "" if np.array_equal(one.lights, other.lights) else "the lights"
