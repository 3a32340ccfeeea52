"""Brings a route's hazards on, one after the other, and keeps the account of them."""

import random
from collections.abc import Callable

from plant_bench.agent import Control
from plant_bench.sim.hazards.behaviour import HazardBehaviour, HoldsTraffic
from plant_bench.sim.hazards.hazard_world import HazardWorld
from plant_bench.world.hazard import Hazard, HazardKind, HazardOutcome, Phase
from plant_bench.world.hazard_table import HAZARDS, load_part
from plant_bench.world.scene import TICK, EgoState

ENDED = (Phase.DONE, Phase.VOID)
PATIENCE = 60.0  # s, longer than a red light, that vehicles wait for an ego that stands
STANDING = 0.1  # m/s
ARMED_INTERVAL = 2  # ticks between two looks of a script that only prepares


def load_script(
    kind: HazardKind,
) -> Callable[[Hazard, HazardWorld, random.Random], HazardBehaviour]:
    """Return what makes the script of a kind of hazard."""
    return load_part(kind, "script")


class Director:
    """The hazards of one episode; mutable.

    Args:
        stage: The world as hazards handle it.
        hazards: In order of place.
        seed: The scenario's: timing differs from repetition to repetition.

    Raises:
        InputError: A kind of hazard has no script.
    """

    def __init__(self, stage: HazardWorld, hazards: tuple[Hazard, ...], seed: int) -> None:
        self._stage = stage
        self._waiting = sorted(hazards, key=lambda hazard: hazard.arm)
        self._scripts = {hazard.kind: load_script(hazard.kind) for hazard in hazards}
        self._seed = seed
        self._playing: list[tuple[Hazard, HazardBehaviour]] = []
        self._stood = 0.0
        self._outcomes: dict[float, HazardOutcome] = {
            hazard.at: HazardOutcome(hazard.kind, hazard.at, Phase.DORMANT, 0.0)
            for hazard in hazards
        }

    @property
    def outcomes(self) -> tuple[HazardOutcome, ...]:
        """What has become of each hazard, in order of place."""
        return tuple(outcome for _, outcome in sorted(self._outcomes.items()))

    @property
    def idle(self) -> bool:
        """True while there is nothing to do at the ego's place."""
        waiting = self._waiting
        return not self._playing and not (waiting and waiting[0].arm <= self._stage.progress)

    def step(self, ego: EgoState) -> None:
        """Go on by one tick; call after `HazardWorld.refresh`, before SUMO's step."""
        while self._waiting and self._waiting[0].arm <= self._stage.progress:
            hazard = self._waiting.pop(0)
            draw = random.Random(f"{hazard.seed}|{self._seed}")
            self._playing.append((hazard, self._scripts[hazard.kind](hazard, self._stage, draw)))
        self._stood = self._stood + TICK if ego.speed < STANDING else 0.0
        for hazard, script in self._playing:
            waits = self._stood > PATIENCE and script.phase is Phase.ARMED
            if waits and isinstance(script, HoldsTraffic):
                script.end(self._stage, Phase.VOID, "the ego stood still for long")
            if script.phase not in ENDED and self._is_due(hazard, script):
                script.step(ego, self._stage)
            self._note(hazard, script)
        self._playing = [item for item in self._playing if item[1].phase not in ENDED]

    def _is_due(self, hazard: Hazard, script: HazardBehaviour) -> bool:
        """Tell whether a script is asked at this tick; SUMO drives who is not placed at a tick."""
        always = script.phase is Phase.COMMITTED or HAZARDS[hazard.kind].always_asked
        return always or self._stage.tick % ARMED_INTERVAL == 0

    def disturb(self, control: Control) -> Control:
        """Return what becomes of the ego's control under the hazards that play."""
        for _, script in self._playing:
            disturb = getattr(script, "disturb", None)
            if disturb is not None:
                control = disturb(control, self._stage)
        return control

    def _note(self, hazard: Hazard, script: HazardBehaviour) -> None:
        known = self._outcomes[hazard.at]
        if known.phase is not script.phase:
            keeps = script.phase is Phase.DONE and known.phase is Phase.COMMITTED
            time = known.time if keeps else round(self._stage.time, 3)
            self._outcomes[hazard.at] = HazardOutcome(
                hazard.kind, hazard.at, script.phase, time, script.reason
            )
