"""Traffic lights of the running simulation: their state, and when it changes."""

from plant_bench.sim.sumo_library import libsumo
from plant_bench.world.scene import Light

_LIGHTS = {"r": Light.RED, "R": Light.RED, "u": Light.RED, "y": Light.YELLOW, "Y": Light.YELLOW}


class Signals:
    """The traffic lights of a running simulation, by id; mutable only in its cache."""

    def __init__(self) -> None:
        self._phases: dict[str, tuple] = {}  # of each signal's program

    def light(self, signal: str, index: int) -> Light:
        """Return what a signal shows to one of its links."""
        state = libsumo.trafficlight.getRedYellowGreenState(signal)[index]
        return _LIGHTS.get(state, Light.GREEN)

    def time_to_green(self, signal: str, index: int) -> float:
        """Return the seconds until a link of a fixed-time signal is green; 0 if it is."""
        lights = libsumo.trafficlight
        phases = self._phases.get(signal)
        if phases is None:
            phases = self._phases[signal] = lights.getAllProgramLogics(signal)[0].phases
        now = lights.getPhase(signal)
        if phases[now].state[index] in "Gg":
            return 0.0
        time = lights.getNextSwitch(signal) - libsumo.simulation.getTime()
        for step in range(1, len(phases)):
            phase = phases[(now + step) % len(phases)]
            if phase.state[index] in "Gg":
                break
            time += phase.duration
        return float(time)

    def time_to_switch(self, signal: str) -> float:
        """Return the seconds until a signal may change."""
        return libsumo.trafficlight.getNextSwitch(signal) - libsumo.simulation.getTime()
