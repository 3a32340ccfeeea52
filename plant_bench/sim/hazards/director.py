"""Starts and steps a route's hazards in one episode, and records their outcomes."""

import random
from collections.abc import Callable

from plant_bench.agent import Control
from plant_bench.sim.hazards.behaviour import HazardBehaviour, HoldsTraffic
from plant_bench.sim.hazards.hazard_world import HazardWorld
from plant_bench.sim.sumo_library import SumoError
from plant_bench.world.hazard import Hazard, HazardKind, HazardOutcome, Phase
from plant_bench.world.hazard_table import HAZARDS, load_part
from plant_bench.world.scene import TICK, EgoState

ENDED = (Phase.DONE, Phase.VOID)
MAX_WAIT = 60.0  # s, longer than a red light, that vehicles wait for a stationary ego
STANDING = 0.1  # m/s
ARMED_INTERVAL = 2  # ticks between two steps of an armed hazard
LOST = "SUMO removed its vehicle"  # why a hazard is void


def load_behaviour(
    kind: HazardKind,
) -> Callable[[Hazard, HazardWorld, random.Random], HazardBehaviour]:
    """Return the behaviour class of a kind of hazard."""
    return load_part(kind, "behaviour")


class Director:
    """The hazards of one episode; mutable.

    Args:
        world: The world that hazards act on.
        hazards: The route's hazards in order of place.
        seed: The scenario's seed, so that timing differs between repetitions.

    Raises:
        InputError: A kind of hazard has no behaviour.
    """

    def __init__(self, world: HazardWorld, hazards: tuple[Hazard, ...], seed: int) -> None:
        self._world = world
        self._waiting = sorted(hazards, key=lambda hazard: hazard.arm)
        self._behaviours = {hazard.kind: load_behaviour(hazard.kind) for hazard in hazards}
        self._seed = seed
        self._active: list[tuple[Hazard, HazardBehaviour]] = []
        self._stood = 0.0
        self._outcomes: dict[float, HazardOutcome] = {
            hazard.at: HazardOutcome(hazard.kind, hazard.at, Phase.DORMANT, 0.0)
            for hazard in hazards
        }

    @property
    def outcomes(self) -> tuple[HazardOutcome, ...]:
        """The outcome of each hazard, in order of place."""
        return tuple(outcome for _, outcome in sorted(self._outcomes.items()))

    @property
    def idle(self) -> bool:
        """True while no hazard is active or due at the ego's place."""
        waiting = self._waiting
        return not self._active and not (waiting and waiting[0].arm <= self._world.progress)

    def step(self, ego: EgoState) -> None:
        """Advance by one tick; call after `HazardWorld.refresh`, before SUMO's step."""
        while self._waiting and self._waiting[0].arm <= self._world.progress:
            hazard = self._waiting.pop(0)
            draw = random.Random(f"{hazard.seed}|{self._seed}")
            self._active.append((hazard, self._behaviours[hazard.kind](hazard, self._world, draw)))
        self._stood = self._stood + TICK if ego.speed < STANDING else 0.0
        lost: list[Hazard] = []
        for hazard, behaviour in self._active:
            waits = self._stood > MAX_WAIT and behaviour.phase is Phase.ARMED
            if waits and isinstance(behaviour, HoldsTraffic):
                behaviour.end(self._world, Phase.VOID, "the ego was stationary for long")
            if behaviour.phase not in ENDED and self._is_due(hazard, behaviour):
                self._world.owner = hazard.at
                try:
                    behaviour.step(ego, self._world)
                except SumoError as error:  # SUMO has removed one of its vehicles
                    self._abandon(hazard, error)
                    lost.append(hazard)
                    continue
            self._record(hazard, behaviour)
        self._active = [
            (hazard, behaviour)
            for hazard, behaviour in self._active
            if behaviour.phase not in ENDED and hazard not in lost
        ]

    def _abandon(self, hazard: Hazard, error: SumoError) -> None:
        """End a hazard whose vehicle is gone, and take its other actors off the road."""
        self._world.abandon(hazard.at)
        time = round(self._world.time, 3)
        self._outcomes[hazard.at] = HazardOutcome(
            hazard.kind, hazard.at, Phase.VOID, time, f"{LOST} ({error})"
        )

    def _is_due(self, hazard: Hazard, behaviour: HazardBehaviour) -> bool:
        """Tell whether to step a hazard now; SUMO moves actors that are not placed at a tick."""
        always = behaviour.phase is Phase.COMMITTED or HAZARDS[hazard.kind].every_tick
        return always or self._world.tick % ARMED_INTERVAL == 0

    def disturb(self, control: Control) -> Control:
        """Return the ego's control as perturbed by the active hazards."""
        for _, behaviour in self._active:
            disturb = getattr(behaviour, "disturb", None)
            if disturb is not None:
                control = disturb(control, self._world)
        return control

    def _record(self, hazard: Hazard, behaviour: HazardBehaviour) -> None:
        known = self._outcomes[hazard.at]
        if known.phase is not behaviour.phase:
            keeps = behaviour.phase is Phase.DONE and known.phase is Phase.COMMITTED
            time = known.time if keeps else round(self._world.time, 3)
            self._outcomes[hazard.at] = HazardOutcome(
                hazard.kind, hazard.at, behaviour.phase, time, behaviour.reason
            )
