"""Builds a planner's observation from a scene: the inputs that it declares, and nothing else."""

from collections.abc import Iterable

import numpy as np

from plant_bench.agent import Observation, Privileged
from plant_bench.sensing.inputs import INPUTS, SensingContext, check_inputs
from plant_bench.world.route import Route
from plant_bench.world.scene import Scene


class Sensors:
    """Builds the observations of one episode.

    Args:
        route: The route being driven; it gives access to the town.
        seed: The scenario's seed; seeds sensor noise.
        inputs: The inputs that the planner declares.

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
            scene: The scene.
            progress: Arc length of the route that the ego has driven, metres.
            offset: The ego's lateral distance from the route, metres, positive to the left.
            facts: Simulator-only facts about the scene's actors; included if declared.
        """
        route = self._route
        index = _point_at(route, progress)
        context = SensingContext(scene, route, index, progress, offset, facts, self._seed)
        return Observation(
            time=scene.time,
            ego=scene.ego,
            speed_limit=float(route.speed_limits[index]),
            sensors={name: _locked(name, make(context)) for name, make in self._arrays},
            **{name: make(context) for name, make in self._fields},
        )


def _point_at(route: Route, progress: float) -> int:
    """Return the index of the last route point passed, at most that of the last but one."""
    last = len(route.points) - 2
    return min(max(int(np.searchsorted(route.along, progress, side="right")) - 1, 0), last)


def _locked(name: str, values: object) -> np.ndarray:
    """Return a read-only view, since arrays sent to another process are read-only, too.

    Raises:
        TypeError: The values are not an array of numbers: the input's function is at fault, not
            the planner.
    """
    if not isinstance(values, np.ndarray) or values.dtype.kind not in "biuf":
        found = getattr(values, "dtype", type(values).__name__)
        message = f"Input '{name}': expected an array of numbers from its function, got {found}."
        raise TypeError(message)
    view = values.view()
    view.flags.writeable = False
    return view
