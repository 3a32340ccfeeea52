"""The one maker of observations: of a scene, what a planner has declared, and nothing else."""

from collections.abc import Iterable

import numpy as np

from plant_bench.agent import Observation, Privileged
from plant_bench.sensing.inputs import INPUTS, Moment, check_inputs
from plant_bench.world.route import Route
from plant_bench.world.scene import Scene


class Sensors:
    """What a planner sees with through one episode.

    Args:
        route: The route being driven; its town is at hand for whatever is made of it.
        seed: The scenario's; seeds whatever is drawn by chance.
        inputs: What the planner declares.

    Raises:
        AgentError: An input is unknown.
    """

    def __init__(self, route: Route, seed: int, inputs: Iterable[str]) -> None:
        self.inputs = frozenset(inputs)
        check_inputs(self.inputs, "A planner")
        self._route, self._seed = route, seed
        rows = [row for name, row in INPUTS.items() if name in self.inputs]
        self._fields = [(row.field, row.make) for row in rows if row.make and row.field]
        self._arrays = [(row.name, row.make) for row in rows if row.make and not row.field]

    def observe(
        self, scene: Scene, progress: float, offset: float, facts: Privileged | None = None
    ) -> Observation:
        """Return the observation of a scene.

        Args:
            scene: What there is.
            progress: Arc length the ego has driven of the route, metres.
            offset: The ego's lateral distance from it, metres, positive to the left.
            facts: What only the simulator knows of the scene's actors; handed on if declared.
        """
        route = self._route
        index = _point_at(route, progress)
        moment = Moment(scene, route, index, progress, offset, facts, self._seed)
        return Observation(
            time=scene.time,
            ego=scene.ego,
            speed_limit=float(route.speed_limits[index]),
            sensors={name: _locked(name, make(moment)) for name, make in self._arrays},
            **{name: make(moment) for name, make in self._fields},
        )


def _point_at(route: Route, progress: float) -> int:
    """Return the index of the last route point passed; never the very last one."""
    last = len(route.points) - 2
    return min(max(int(np.searchsorted(route.along, progress, side="right")) - 1, 0), last)


def _locked(name: str, values: object) -> np.ndarray:
    """Return an array that cannot be written to, as one that has come from another process.

    Raises:
        TypeError: It is no array of numbers: the row's function is at fault, not the planner.
    """
    if not isinstance(values, np.ndarray) or values.dtype.kind not in "biuf":
        found = getattr(values, "dtype", type(values).__name__)
        message = f"Input '{name}': expected an array of numbers from its function, got {found}."
        raise TypeError(message)
    view = values.view()
    view.flags.writeable = False
    return view
