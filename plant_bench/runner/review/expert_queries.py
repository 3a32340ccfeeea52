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

SPACING = 10  # ticks between two questions: 2 Hz, as replays ask for attention
STANDING = (
    0.5  # m/s, below which it is asked as often as it wants: then it counts how long it waits
)


def ask_expert(recording: Recording, result: EpisodeResult, route: Route) -> ExpertView:
    """Return whom the expert would brake for in the scenes of a recording.

    The episode is simulated again with the recorded controls. The expert needs what only the
    simulator knows, so it is asked no more from the first scene on that differs.

    Args:
        recording: Of every tick.
        result: The episode's record.
        route: The route it was driven on.
    """
    ticks: list[int] = []
    actors: list[int] = []
    note = ""
    try:
        expert = PlannerSession(load_agent(EXPERT), route, result.seed)
        expert.start()
        place = RouteProgress(route)
        for tick in simulate_again(recording, result, route, until=len(recording) - 2):
            scene = tick.recorded
            place.follow(scene.ego.x, scene.ego.y)
            if tick.difference:
                note = _differs(scene.tick, tick.difference)
                break
            standing = scene.ego.speed < STANDING
            if tick.row % SPACING == 0 or (standing and expert.due(scene.tick)):
                seen = expert.observe(scene, place.progress, place.offset, tick.facts())
                reason = expert.decide(scene, seen).reason
                ticks.append(tick.row)
                actors.append(NO_ACTOR if reason is None else reason.actor)
    except PlantBenchError as error:
        note = str(error)
    return ExpertView(np.array(ticks, int), np.array(actors, int), note)


def _differs(tick: int, what: str) -> str:
    return f"Simulated again, from {tick * TICK:.1f} s on it is another episode: {what} differs."
