"""Queries the expert at 2 Hz for the actor it would brake for, in another planner's episode."""

import numpy as np

from plant_bench.agent import NO_ACTOR
from plant_bench.agents.loading.registry import load_agent
from plant_bench.data.recording import Recording
from plant_bench.errors import PlantBenchError
from plant_bench.runner.decisions import PlannerSession
from plant_bench.runner.review.expert_braking import EXPERT, ExpertView
from plant_bench.runner.review.resimulation import simulate_again
from plant_bench.scoring.results import EpisodeResult
from plant_bench.world.route import Route
from plant_bench.world.route_progress import RouteProgress
from plant_bench.world.scene import TICK

QUERY_INTERVAL = 10  # ticks between two queries: 2 Hz, as for attention in replays
STATIONARY_SPEED = 0.5  # m/s: below it, every decision is queried, as the expert counts its wait


def ask_expert(recording: Recording, result: EpisodeResult, route: Route) -> ExpertView:
    """Return the actors that the expert would brake for in the scenes of a recording.

    The episode is simulated again with the recorded controls. The expert needs privileged facts
    from the simulator, so its queries end at the first scene that differs from the recording.

    Args:
        recording: Recording of every tick.
        result: The episode's record.
        route: The route it was driven on.
    """
    ticks: list[int] = []
    actors: list[int] = []
    note = ""
    try:
        expert = PlannerSession(load_agent(EXPERT), route, result.seed)
        expert.start()
        position = RouteProgress(route)
        for tick in simulate_again(recording, result, route, until=len(recording) - 2):
            scene = tick.recorded
            position.follow(scene.ego.x, scene.ego.y)
            if tick.difference:
                note = _difference_note(scene.tick, tick.difference)
                break
            stationary = scene.ego.speed < STATIONARY_SPEED
            if tick.row % QUERY_INTERVAL == 0 or (stationary and expert.due(scene.tick)):
                observation = expert.observe(
                    scene, position.progress, position.offset, tick.facts()
                )
                reason = expert.decide(scene, observation).reason
                ticks.append(tick.row)
                actors.append(NO_ACTOR if reason is None else reason.actor)
    except PlantBenchError as error:
        note = str(error)
    return ExpertView(np.array(ticks, int), np.array(actors, int), note)


def _difference_note(tick: int, difference: str) -> str:
    return f"The simulation differs from the recording from {tick * TICK:.1f} s on: {difference}."
