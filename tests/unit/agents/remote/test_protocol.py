"""Messages survive the round trip, and nothing that a planner sends is trusted."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from plant_bench.agent import NextLight, Observation, Privileged, RouteAhead
from plant_bench.agent_check import _equal
from plant_bench.agents.remote.codec import array_in, pack, unpack
from plant_bench.agents.remote.messages import (
    observation_in,
    observation_out,
    reset_out,
    route_in,
)
from plant_bench.agents.remote.remote_errors import ProtocolError, RemoteError
from plant_bench.agents.remote.responses import (
    ControlResponse,
    Hello,
    PlanResponse,
    Ranks,
    Ready,
    response_in,
)
from plant_bench.world.route import load_suite
from plant_bench.world.scene import Actors, EgoState, Light

ALL = (Hello, Ready, ControlResponse, PlanResponse, Ranks)
RANDOM = np.random.default_rng(1)
ACTORS = Actors(
    np.array([3, 1_000_007]),
    RANDOM.normal(size=(2, 3)).astype(np.float32),
    RANDOM.normal(size=2).astype(np.float32),
    RANDOM.normal(size=(2, 2)).astype(np.float32),
    np.array([0, 7], np.uint8),
)
AHEAD = RouteAhead(1.0 / 3.0, 0.1, -0.2, RANDOM.normal(size=(5, 2)), np.ones(5), np.zeros(5))
FACTS = Privileged(RANDOM.normal(size=(2, 4, 3)), *RANDOM.normal(size=(4, 2)))
EGO = EgoState(0.1, -2.0 / 3.0, 3.0, 4.0, 5.0, 6.0)
PARTS = {"actors": ACTORS, "route": AHEAD, "light": NextLight(Light.RED, -1.5), "privileged": FACTS}


@pytest.mark.parametrize("parts", [{}, PARTS], ids=["least", "most"])
def test_observation_round_trip_is_exact(parts):
    seen = Observation(0.15, EGO, 8.33, **parts)

    told = observation_in(unpack(pack(observation_out("act", seen))))

    assert _equal(seen, told)
    if told.actors is not None:
        assert told.actors.poses.dtype == np.float32
        assert told.actors.kinds.dtype == np.uint8


@pytest.mark.parametrize("place", [0, 20])
def test_route_round_trip_is_exact(place):
    route = load_suite("longest6")[place].plan

    assert _equal(route, route_in(unpack(pack(reset_out(route)))["route"]))


@given(st.binary(max_size=300))
def test_arbitrary_bytes_raise_remote_error(data):
    with pytest.raises(RemoteError):
        response_in(data, *ALL)


NAMES = st.sampled_from(
    ["type", "protocol", "inputs", "interval", "acceleration", "steering", "waypoints", "values",
     "shape", "data", "error", "message", "reason", "passes", "files"]
)  # fmt: skip
LEAVES = (
    st.none() | st.booleans() | st.integers(-(2**63), 2**64 - 1) | st.floats() | st.binary()
    | st.sampled_from(["hello", "ready", "control", "plan", "ranks", "failed", "route", "\x1b[0m"])
)  # fmt: skip
VALUES = st.recursive(
    LEAVES, lambda part: st.lists(part, max_size=4) | st.dictionaries(NAMES, part, max_size=6)
)


@given(st.dictionaries(NAMES, VALUES, max_size=8))
def test_arbitrary_messages_are_read_or_raise_a_printable_error(message):
    wrong = ""
    try:
        response = response_in(pack(message), *ALL)
        if isinstance(response, PlanResponse):
            array_in(response.waypoints)
    except RemoteError as error:
        wrong = str(error)
    assert not wrong or wrong.isprintable()


@pytest.mark.parametrize(
    ("message", "words"),
    [
        ({"type": "control", "acceleration": "fast", "steering": 0.0}, "acceleration"),
        ({"type": "control", "acceleration": 1.0}, "steering"),
        ({"type": "control", "acceleration": 1.0, "steering": 0.0, "x": 1}, "wrong x"),
        ({"type": "ready", "interval": 2.5}, "interval"),
        ({"type": "shrug"}, "unknown type"),
        ({"type": ["control"]}, "unknown type"),
        ({"type": "hello", "protocol": 2, "inputs": []}, "version 1"),
        ({"type": "hello", "protocol": 1, "inputs": ["route"] * 101}, "inputs"),
    ],
)
def test_wrong_response_is_refused_with_the_reason(message, words):
    with pytest.raises(ProtocolError, match=words):
        response_in(pack(message), *ALL)


@pytest.mark.parametrize(
    "array",
    [
        None,
        {"shape": [4, 2]},
        {"shape": [4, 2], "data": b"1234"},
        {"shape": [-1, 2], "data": b""},
        {"shape": [True], "data": b"12345678"},
        {"shape": [0] * 40, "data": b""},
        {"shape": [2**40], "data": b""},
        {"shape": "2", "data": b""},
    ],
)
def test_arrays_whose_bytes_and_shape_differ_are_refused(array):
    with pytest.raises(ProtocolError):
        array_in(array)


def test_deep_and_wide_messages_are_refused():
    for data in (b"\x91" * 100_000, b"\xdd\xff\xff\xff\xff", bytes([0x91, 0x80])):
        with pytest.raises(ProtocolError):
            unpack(data)
