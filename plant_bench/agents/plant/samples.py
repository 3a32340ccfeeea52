"""A frame as PlanT learns from it: tokens and what becomes of them; everything in its ego frame."""

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
    """Return what PlanT learns from a frame.

    Args:
        frame: To be encoded.
        spec: What becomes a token.

    Returns:
        `attributes` and `kinds` of the tokens; `futures`, attributes of the same actors 0.5 s
        later, NaN for those gone and for the route; `red`, 1 where the next light is red or yellow;
        `target`, a route point ahead, metres; `speed` and `limit`, m/s; and `waypoints`, metres.

    Raises:
        InputError: The frame lacks objects.
    """
    now = frame.observation.actors
    if now is None:
        message = "PlanT learns from objects: a frame with the input 'objects' is expected."
        raise InputError(message)
    rates = rates_between(frame.before, now, PLAN_INTERVAL) if spec.motion else None
    given = scene_input(frame.observation, spec, rates)
    return {
        "attributes": given.tokens.attributes,
        "kinds": given.tokens.kinds,
        "futures": _futures(frame, given.tokens, now.ids).astype(np.float32),
        "red": np.array(given.red, np.float32),
        "target": np.array(given.target, np.float32),
        "speed": np.array(given.speed, np.float32),
        "limit": np.array(given.limit, np.float32),
        "waypoints": frame.waypoints.astype(np.float32),
    }


def _futures(frame: Frame, tokens: Tokens, ids: np.ndarray) -> Float[np.ndarray, "tokens 6"]:
    """Return the later attributes of the tokens' actors in the frame of the ego now."""
    futures = np.full((len(tokens), ATTRIBUTES), np.nan)
    mine = (tokens.places != NO_ROW).nonzero()[0]
    there, found = rows_of(ids[tokens.places[mine]], frame.later.ids)
    futures[mine[there]] = actor_attributes(frame.observation.ego, frame.later, found)
    return futures
