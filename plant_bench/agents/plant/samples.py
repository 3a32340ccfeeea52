"""Encodes one instant of a recording as a training sample of PlanT: network inputs and targets."""

import numpy as np
from jaxtyping import Float

from plant_bench.agent import PLAN_INTERVAL
from plant_bench.errors import InputError
from plant_bench.features.motion import rates_between, rows_of
from plant_bench.features.network_inputs import scene_input
from plant_bench.features.tokens import ATTRIBUTES, NO_ROW, Tokens, TokenSpec, actor_attributes
from plant_bench.learner import Encoded, Frame

PADDING = {"attributes": 0.0, "kinds": 0.0, "futures": np.nan}  # kind 0 is `TokenKind.PADDING`


def encode(frame: Frame, spec: TokenSpec) -> Encoded:
    """Return a frame's network inputs and targets.

    Args:
        frame: The frame.
        spec: Which objects become tokens.

    Returns:
        `attributes` and `kinds` of the tokens; `futures`, attributes of the same actors 0.5 s
        later, NaN if the actor is gone or it is no actor's token; `red`, 1 if the next light is red
        or yellow; `target`, a route point ahead, metres; `speed` and `limit`, m/s; and `waypoints`,
        metres.

    Raises:
        InputError: The frame has no objects.
    """
    now = frame.observation.actors
    if now is None:
        message = "PlanT learns from objects: expected a frame with the input 'objects'."
        raise InputError(message)
    rates = rates_between(frame.before, now, PLAN_INTERVAL) if spec.motion else None
    scene = scene_input(frame.observation, spec, rates)
    return {
        "attributes": scene.tokens.attributes,
        "kinds": scene.tokens.kinds,
        "futures": _futures(frame, scene.tokens, now.ids).astype(np.float32),
        "red": np.array(scene.red, np.float32),
        "target": np.array(scene.target, np.float32),
        "speed": np.array(scene.speed, np.float32),
        "limit": np.array(scene.limit, np.float32),
        "waypoints": frame.waypoints.astype(np.float32),
    }


def _futures(frame: Frame, tokens: Tokens, ids: np.ndarray) -> Float[np.ndarray, "tokens 6"]:
    """Return the later attributes of the tokens' actors, in the present ego frame."""
    futures = np.full((len(tokens), ATTRIBUTES), np.nan)
    actors = (tokens.places != NO_ROW).nonzero()[0]
    present, found = rows_of(ids[tokens.places[actors]], frame.later.ids)
    futures[actors[present]] = actor_attributes(frame.observation.ego, frame.later, found)
    return futures
