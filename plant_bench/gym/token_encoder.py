"""Encodes an observation as PlanT's object tokens (`features.tokens`), in fixed-size arrays."""

import numpy as np
from gymnasium import spaces
from jaxtyping import Float, UInt8

from plant_bench.agent import Observation
from plant_bench.errors import InputError
from plant_bench.features.motion import MotionTracker
from plant_bench.features.network_inputs import scene_input
from plant_bench.features.tokens import TokenKind, Tokens, TokenSpec
from plant_bench.gym.observation_bounds import FASTEST, ROUTE_REACH, box, in_bounds
from plant_bench.world.town import Town

# Includes pedestrians and stop lines; excludes conflicts and motion, which follow from the boxes.
PLAIN_TOKENS = TokenSpec(vulnerable=True, stop_line=True)


class TokenEncoder:
    """PlanT's inputs: object tokens, padded with zeros, and the scalar inputs.

    Args:
        spec: Which objects become tokens.
        most: Number of rows. Actors are ordered by distance; surplus distant ones are left out.

    Raises:
        InputError: There are too few rows for the route segments and a stop line.
    """

    def __init__(self, spec: TokenSpec = PLAIN_TOKENS, most: int = 40) -> None:
        if most <= spec.segments + 1:
            message = f"most: expected more than {spec.segments + 1} tokens, got {most}."
            raise InputError(message)
        self._spec, self._most = spec, most
        self._tracker = MotionTracker()
        reach = ROUTE_REACH + FASTEST * spec.horizon
        self.space = spaces.Dict(
            {
                "tokens": spaces.Box(-reach, reach, (most, spec.attributes), np.float32),
                "kinds": spaces.Box(0, max(TokenKind), (most,), np.uint8),
                "mask": spaces.MultiBinary(most),
                "red": box(0.0, 1.0, 1),
                "target": box(-ROUTE_REACH, ROUTE_REACH, 2),
                "speed": box(0.0, FASTEST, 1),
                "limit": box(0.0, FASTEST, 1),
            }
        )

    def reset(self, town: Town) -> None:
        """Start a new episode."""
        del town
        self._tracker.reset()

    def encode(self, observation: Observation) -> dict[str, np.ndarray]:
        """Return `SceneInput` as arrays."""
        rates = None
        if self._spec.motion and observation.actors is not None:
            rates = self._tracker.rates(observation.time, observation.actors)
        scene = scene_input(observation, self._spec, rates)
        attributes, kinds = self._fitting(scene.tokens)
        count = len(kinds)
        tokens = np.zeros((self._most, self._spec.attributes), np.float32)
        tokens[:count] = attributes
        all_kinds = np.full(self._most, TokenKind.PADDING, np.uint8)
        all_kinds[:count] = kinds
        mask = np.zeros(self._most, np.int8)
        mask[:count] = 1
        return in_bounds(
            self.space.spaces,
            {
                "tokens": tokens,
                "kinds": all_kinds,
                "mask": mask,
                "red": np.array([scene.red], np.float32),
                "target": np.array(scene.target, np.float32),
                "speed": np.array([scene.speed], np.float32),
                "limit": np.array([scene.limit], np.float32),
            },
        )

    def _fitting(
        self, tokens: Tokens
    ) -> tuple[Float[np.ndarray, "tokens attributes"], UInt8[np.ndarray, " tokens"]]:
        """Return the tokens without the most distant actors that exceed the number of rows."""
        surplus = max(len(tokens) - self._most, 0)
        actors = int(np.count_nonzero(tokens.places >= 0))
        keep = np.ones(len(tokens), bool)
        keep[actors - surplus : actors] = False
        return tokens.attributes[keep], tokens.kinds[keep]
