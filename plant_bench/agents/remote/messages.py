"""Encodes and decodes the requests to a planner's process.

docs/reference/protocol-agents.md lists their fields.
"""

from enum import IntEnum
from pathlib import Path
from typing import Any

from plant_bench.agent import Observation
from plant_bench.agents.remote.codec import array_in, array_out, typed_array_out
from plant_bench.sensing.inputs import INPUTS, WireRecord
from plant_bench.world.route import LaneChange, LaneSpan, Passage, Route
from plant_bench.world.scene import EgoState

PROTOCOL_VERSION = 1
_EGO = ("x", "y", "yaw", "speed", "acceleration", "steering")
_ROUTE_ARRAYS = ("points", "elevations", "speed_limits")

Wire = dict[str, Any]


def hello_out(agent: str) -> Wire:
    """Return the request that creates a planner; `agent` names it if a process has several."""
    return {"type": "hello", "protocol": PROTOCOL_VERSION, "agent": agent}


def reset_out(route: Route | None) -> Wire:
    """Return the request that starts an episode."""
    return {"type": "reset", "route": None if route is None else route_out(route)}


def observation_out(kind: str, observation: Observation) -> Wire:
    """Return a request about an observation; `kind` is "act" or "rank"."""
    wire = {
        "type": kind,
        "time": observation.time,
        "speed_limit": observation.speed_limit,
        "ego": {name: getattr(observation.ego, name) for name in _EGO},
    }
    for name, record in _records():
        value = getattr(observation, name)
        wire[name] = None if value is None else _record_out(value, record)
    if observation.sensors:
        sensors = observation.sensors
        wire["sensors"] = {name: typed_array_out(values) for name, values in sensors.items()}
    return wire


def observation_in(wire: Wire) -> Observation:
    """Return the observation in a request."""
    fields = {
        name: None if wire[name] is None else _record_in(wire[name], record)
        for name, record in _records()
    }
    return Observation(
        time=wire["time"],
        ego=EgoState(**wire["ego"]),
        speed_limit=wire["speed_limit"],
        sensors={name: array_in(values) for name, values in wire.get("sensors", {}).items()},
        **fields,
    )


def _records() -> list[tuple[str, WireRecord]]:
    return [(row.field, row.record) for row in INPUTS.values() if row.field and row.record]


def _record_out(value: object, record: WireRecord) -> Wire:
    numbers = {name: getattr(value, name) for name in record.numbers}
    return {
        name: int(number) if isinstance(number, IntEnum) else number
        for name, number in numbers.items()
    } | _arrays_out(value, record.arrays)


def _record_in(wire: Wire, record: WireRecord) -> Any:
    numbers = {name: make(wire[name]) for name, make in record.numbers.items()}
    arrays = {name: array_in(wire[name], kind) for name, kind in record.arrays.items()}
    return record.type(**numbers, **arrays)


def route_out(route: Route) -> Wire:
    """Return a route's wire form; lossless."""
    return {
        "id": route.id,
        "town": route.town,
        "edges": list(route.edges),
        "lanes": [vars(span) for span in route.lanes],
        "passages": [vars(passage) for passage in route.passages],
        "lane_changes": [vars(change) for change in route.lane_changes],
        "manoeuvres": route.manoeuvres,
        "town_folders": list(map(str, route.town_folders)),
        **_arrays_out(route, _ROUTE_ARRAYS),
    }


def route_in(wire: Wire) -> Route:
    """Return a received route."""
    return Route(
        id=wire["id"],
        town=wire["town"],
        edges=tuple(wire["edges"]),
        lanes=tuple(LaneSpan(**span) for span in wire["lanes"]),
        passages=tuple(Passage(**passage) for passage in wire["passages"]),
        lane_changes=tuple(LaneChange(**change) for change in wire["lane_changes"]),
        manoeuvres=wire["manoeuvres"],
        town_folders=tuple(map(Path, wire.get("town_folders", ()))),
        **_arrays_in(wire, _ROUTE_ARRAYS),
    )


def _arrays_out(value: object, names: Any) -> Wire:
    return {name: array_out(getattr(value, name)) for name in names}


def _arrays_in(wire: Wire, names: Any) -> dict[str, Any]:
    return {name: array_in(wire[name]) for name in names}
