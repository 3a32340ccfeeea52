"""Builds, checks and describes the benchmark's route suites, modelled on CARLA's Longest6."""

import json
import tempfile
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pandas as pd

from plant_bench.atomic_files import write_whole_text
from plant_bench.data_files import routes_dir
from plant_bench.errors import InputError
from plant_bench.towns import unseen_towns as unseen
from plant_bench.towns.route_choice import choose, distance_by_edge, draft_paths, overlap_share
from plant_bench.towns.route_graph import StreetGraph
from plant_bench.towns.route_hazards import place_hazards
from plant_bench.towns.route_making import MANOEUVRES
from plant_bench.world.route import ROUTE_FORMAT, Route
from plant_bench.world.town import Town, load_town

DRAWS = 4000  # random edge paths per town


@dataclass(frozen=True)
class SuiteSpec:
    """Specification of a suite.

    Attributes:
        seed: Seed of routes and hazards.
        lengths: Maximum lengths of the routes of each town, metres.
    """

    seed: int
    lengths: Mapping[str, Sequence[float]]


# Lengths of CARLA's routes (TransFuser, leaderboard/data/longest6/longest6.xml), sorted by town.
_LENGTHS = {
    "town01": (1130.0, 1015.0, 937.0, 894.0, 731.0, 686.0),
    "town02": (1010.0, 974.0, 973.0, 872.0, 821.0, 821.0),
    "town03": (2302.0, 1871.0, 1870.0, 1747.0, 1556.0, 1434.0),
    "town04": (2440.0, 2320.0, 2069.0, 2059.0, 1863.0, 1862.0),
    "town05": (2101.0, 1650.0, 1555.0, 1272.0, 1071.0, 1018.0),
    "town06": (2842.0, 2525.0, 2271.0, 1859.0, 1760.0, 1442.0),
}
SUITES = {
    "longest6": SuiteSpec(seed=6, lengths=_LENGTHS),
    unseen.SUITE: SuiteSpec(
        seed=unseen.SUITE_SEED,
        lengths={name: _LENGTHS[town.base] for name, town in unseen.UNSEEN.items()},
    ),
}


def build_suite(
    name: str = "longest6",
    *,
    towns: list[str] | None = None,
    seed: int | None = None,
    out: Path | None = None,
) -> Path:
    """Build a suite; its files are written only if all routes can be built.

    Args:
        name: The suite.
        towns: Towns to build; the files of others stay as they are. All by default.
        seed: Seed of routes and hazards; the suite's own by default.
        out: Output folder; the suite's folder in `routes/` by default.

    Returns:
        The output folder.

    Raises:
        InputError: There is no such suite or town, or a town is too small for it.
    """
    spec = _suite_spec(name)
    seed = spec.seed if seed is None else seed
    texts = {
        town: _suite_text(name, seed, suite_routes(load_town(town), spec.lengths[town], seed))
        for town in _suite_towns(name, towns)
    }
    folder = routes_dir() / name if out is None else out
    for town, text in texts.items():
        write_whole_text(folder / f"{town}.json", text)
    return folder


def check_suite(name: str) -> list[str]:
    """Build a suite again and compare it with its files, byte for byte.

    Returns:
        One line per file that differs.

    Raises:
        InputError: There is no such suite, or it cannot be built.
    """
    spec = _suite_spec(name)
    differences = []
    with tempfile.TemporaryDirectory() as scratch:
        rebuilt = build_suite(name, out=Path(scratch) / name)
        for town in spec.lengths:
            stored = routes_dir() / name / f"{town}.json"
            if not stored.is_file():
                differences.append(f"{name}/{town}.json is missing.")
            elif stored.read_bytes() != (rebuilt / stored.name).read_bytes():
                differences.append(f"{name}/{town}.json differs from the rebuilt file.")
    return differences


def suite_routes(town: Town, limits: Sequence[float], seed: int) -> list[Route]:
    """Return one route per maximum length, as long as possible, with hazards.

    Args:
        town: The town.
        limits: Maximum lengths, metres.
        seed: Seed of routes and hazards.

    Raises:
        InputError: The town does not have enough different routes.
    """
    rng = np.random.default_rng([seed, zlib.crc32(town.name.encode())])
    graph = StreetGraph(town)
    drafts = choose(graph, draft_paths(graph, DRAWS, rng), limits)
    routes = [draft.make(graph, f"{town.name}-{i}") for i, draft in enumerate(drafts)]
    return [replace(route, hazards=place_hazards(town, route, seed)) for route in routes]


def describe_suite(routes: list[Route]) -> pd.DataFrame:
    """Return one row per route: length, manoeuvres, signals, hazards and largest overlap."""
    rows = []
    for route in routes:
        others = [other for other in routes if other.town == route.town and other is not route]
        shares = [
            overlap_share(distance_by_edge(route), distance_by_edge(other)) for other in others
        ]
        row = {"id": route.id, "town": route.town, "length_m": round(route.length, 1)}
        row |= {kind: route.manoeuvres.get(kind, 0) for kind in MANOEUVRES}
        row |= {"signals": len(route.signal_passages), "hazards": len(route.hazards)}
        rows.append(row | {"max_share": round(max(shares, default=0.0), 3)})
    return pd.DataFrame(rows)


def _suite_spec(name: str) -> SuiteSpec:
    if name not in SUITES:
        message = f"There is no suite '{name}' to build. Known: {', '.join(SUITES)}."
        raise InputError(message)
    return SUITES[name]


def _suite_towns(name: str, towns: list[str] | None) -> list[str]:
    known = list(SUITES[name].lengths)
    for town in towns or []:
        if town not in known:
            message = f"The suite '{name}' has no town '{town}'. Its towns: {', '.join(known)}."
            raise InputError(message)
    return known if towns is None else towns


def _suite_text(name: str, seed: int, routes: list[Route]) -> str:
    return suite_text({"suite": name, "seed": seed}, routes)


def suite_text(header: Mapping[str, object], routes: Sequence[Route]) -> str:
    """Return the text of a suite file, with one route per line.

    Args:
        header: Metadata of the suite.
        routes: The routes.
    """
    head = json.dumps({"format": ROUTE_FORMAT} | dict(header), separators=(",", ":"))
    payloads = [route.to_payload() for route in routes]
    for payload in payloads:
        payload["hazards"] = payload.pop("hazards")  # at the end of the line, for readability
    lines = [json.dumps(payload, separators=(",", ":")) for payload in payloads]
    return head[:-1] + ',"routes":[\n' + ",\n".join(lines) + "\n]}\n"
