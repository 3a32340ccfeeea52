"""The Gymnasium environment PlantBench-v0: the benchmark's episodes, one decision per step."""

from typing import Any

import gymnasium
import numpy as np
from gymnasium import logger
from gymnasium.utils import EzPickle

from plant_bench.agent import MOST_INTERVAL, Observation
from plant_bench.errors import InputError
from plant_bench.gym.actions import action_kind, inside
from plant_bench.gym.bev_image import picture
from plant_bench.gym.encoders import Encoder, encoder_inputs, encoder_of
from plant_bench.gym.gym_episode import DrivenEpisode
from plant_bench.gym.rewards import reward_of
from plant_bench.gym.simulation_lock import ADVICE, acquire_simulation
from plant_bench.gym.transition import Reward
from plant_bench.runner.episode.jobs import Job, repetition_seed, select_routes
from plant_bench.scoring.infractions import InfractionKind, Status
from plant_bench.scoring.results import EpisodeResult
from plant_bench.sim.densities import density_of
from plant_bench.world.route import Route, load_suite
from plant_bench.world.scene import TICK

AGENT = "gymnasium"  # the planner's name in records
OPTIONS = ("route", "repetition")
RENDER_MODES = ["rgb_array"]


class PlantBenchEnv(gymnasium.Env[Any, np.ndarray], EzPickle):
    """Drives routes of a suite; only one environment per process can run an episode at a time.

    Args:
        suite: A suite's name, or a folder or file of routes.
        town: Only routes in this town.
        routes: Only these routes: numbers, ranges and ids, as in `plant-bench score --routes`.
        observation: "tokens", "objects", "raster", or an `Encoder`.
        action: "control" or "plan".
        density: Traffic density.
        hazards: Whether the routes' hazards occur.
        reward: "roach", "progress", or a `Reward`.
        frame_skip: Ticks of 0.05 s between two decisions, 1 to 20.
        render_mode: None or "rgb_array".

    Raises:
        InputError: An argument has another value.
    """

    metadata: dict[str, Any] = {"render_modes": RENDER_MODES, "render_fps": 10}  # noqa: RUF012

    def __init__(
        self,
        *,
        suite: str = "longest6",
        town: str | None = None,
        routes: str | None = None,
        observation: str | Encoder = "tokens",
        action: str = "control",
        density: str = "dense",
        hazards: bool = True,
        reward: str | Reward = "roach",
        frame_skip: int = 2,
        render_mode: str | None = None,
    ) -> None:
        EzPickle.__init__(
            self, suite=suite, town=town, routes=routes, observation=observation, action=action,
            density=density, hazards=hazards, reward=reward, frame_skip=frame_skip,
            render_mode=render_mode,
        )  # fmt: skip
        density_of(density)
        self.routes = {route.id: route for route in _routes(suite, town, routes)}
        self._density, self._hazards = density, hazards
        self._encoder, self._action = encoder_of(observation), action_kind(action)
        self._reward = reward_of(reward)
        self._frame_skip = _checked_skip(frame_skip)
        if render_mode is not None and render_mode not in RENDER_MODES:
            message = f"There is no render mode {render_mode!r}. Modes: {', '.join(RENDER_MODES)}."
            raise InputError(message)
        self.render_mode = render_mode
        self.metadata = {**self.metadata, "render_fps": round(1.0 / (TICK * frame_skip))}
        self.observation_space = self._encoder.space
        self.action_space = self._action.space
        self._episode: DrivenEpisode | None = None

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """Start an episode.

        Args:
            seed: Seed of the random choice of routes and scenarios from now on.
            options: "route": id of the route. Default: a random one. "repetition": drive the
                scenario that `plant-bench score --seed 0` drives in this repetition.

        Raises:
            InputError: An option is unknown, or another environment's episode is running in this
                process.
            SimulationError: SUMO fails.
        """
        super().reset(seed=seed)
        job = self._job(options or {})
        acquire_simulation(self)
        self.leave()
        self._episode = DrivenEpisode(job, encoder_inputs(self._encoder))
        self._encoder.reset(self._episode.town)
        info = {"route": job.route.id, "seed": job.seed, **self._facts(self._episode)}
        return self._encoder.encode(self._episode.observation), info

    def step(self, action: np.ndarray) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """Execute an action for `frame_skip` ticks.

        Raises:
            InputError: The action has the wrong shape or is not finite, or there is no episode.
            SimulationError: SUMO has lost the ego.
        """
        episode = self._episode
        if episode is None or not episode.open:
            message = "There is no running episode: call reset() first."
            if episode is not None and episode.referee.status is None:
                message = f"Another environment of this process has started an episode. {ADVICE}"
            raise InputError(message)
        planned = self._action.decode(inside(action, self._action.space))
        transition = episode.drive(planned, self._frame_skip)
        terms = {name: float(value) for name, value in self._reward(transition).items()}
        info = {"reward_terms": terms, **self._facts(episode)}
        if episode.result is not None:
            info |= _score(episode.result)
        truncated = transition.status is Status.TIMED_OUT
        terminated = transition.status is not None and not truncated
        encoded = self._encoder.encode(episode.observation)
        return encoded, sum(terms.values()), terminated, truncated, info

    def render(self) -> Any:
        """Return a top view as an array (height, width, 3); None without a render mode.

        Raises:
            InputError: `reset` has not been called.
        """
        if self.render_mode is None:
            logger.warn("render() returns None: the environment has no render_mode='rgb_array'.")
            return None
        if self._episode is None:
            message = "There is nothing to draw: call reset() first."
            raise InputError(message)
        return picture(self._episode.town, self._episode.observation)

    def close(self) -> None:
        """End the simulation, so that another environment of this process can drive."""
        self.leave()
        self._episode = None

    def leave(self) -> None:
        """End the simulation, if there is one; also called when another environment starts."""
        if self._episode is not None:
            self._episode.close()

    @property
    def under_way(self) -> bool:
        """Whether an episode is running and has made at least one step."""
        return self._episode is not None and self._episode.under_way

    @property
    def observation(self) -> Observation:
        """The current observation, unencoded: the input of a planner of `plant_bench.agent`.

        Raises:
            InputError: `reset` has not been called.
        """
        if self._episode is None:
            message = "There is no observation: call reset() first."
            raise InputError(message)
        return self._episode.observation

    @property
    def result(self) -> EpisodeResult | None:
        """The record of the episode; None before its end."""
        return None if self._episode is None else self._episode.result

    def _job(self, options: dict[str, Any]) -> Job:
        unknown = sorted(set(options) - set(OPTIONS))
        if unknown:
            message = f"Unknown reset options: {', '.join(unknown)}. Options: {', '.join(OPTIONS)}."
            raise InputError(message)
        names = list(self.routes)
        name = options.get("route") or names[int(self.np_random.integers(len(names)))]
        if name not in self.routes:
            message = f"There is no route {name!r} in this environment. Routes: {', '.join(names)}."
            raise InputError(message)
        repetition = options.get("repetition")
        if repetition is None:
            seed = int(self.np_random.integers(2**31))
        else:
            seed = repetition_seed(0, name, int(repetition))
        route = self.routes[name]
        return Job(AGENT, "", route, int(repetition or 0), seed, self._density, self._hazards)

    def _facts(self, episode: DrivenEpisode) -> dict[str, Any]:
        referee = episode.referee
        kinds = [item.kind for item in referee.infractions]
        return {
            "time": referee.time,
            "progress": referee.progress,
            "completion": referee.completion,
            "infractions": {kind.value: kinds.count(kind) for kind in InfractionKind},
        }


def _score(result: EpisodeResult) -> dict[str, Any]:
    return {
        "status": result.status.value,
        "score": {
            "DS": result.driving_score,
            "RC": result.route_completion,
            "IS": result.infraction_score,
        },
    }


def _routes(suite: str, town: str | None, selection: str | None) -> list[Route]:
    routes = load_suite(suite)
    towns = list(dict.fromkeys(route.town for route in routes))
    if town is not None and town not in towns:
        message = f"Suite {suite} has no routes in {town!r}. Towns: {', '.join(towns)}."
        raise InputError(message)
    return select_routes([route for route in routes if town in (None, route.town)], selection)


def _checked_skip(frame_skip: int) -> int:
    if not isinstance(frame_skip, int) or not 1 <= frame_skip <= MOST_INTERVAL:
        message = f"frame_skip: expected an integer from 1 to {MOST_INTERVAL}, got {frame_skip!r}."
        raise InputError(message)
    return frame_skip
