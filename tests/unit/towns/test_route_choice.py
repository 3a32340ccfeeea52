"""Overlap of routes, and shortening plans to a length."""

import numpy as np
import pytest

from plant_bench.errors import InputError
from plant_bench.towns.route_choice import choose, draft_paths, overlap_share, shorten
from plant_bench.towns.route_graph import StreetGraph
from plant_bench.world.town import load_town


def test_common_share_is_relative_to_the_shorter_route():
    one, other = {"a": 100.0, "b": 100.0, "c": 50.0}, {"b": 60.0, "d": 40.0}
    assert overlap_share(one, other) == overlap_share(other, one) == 0.6
    assert overlap_share({"a": 1.0}, {"b": 1.0}) == 0.0


def test_shortened_plans_stay_below_the_maximum_length():
    graph = StreetGraph(load_town("town02"))
    plans = draft_paths(graph, 50, np.random.default_rng(3))
    assert len(plans) > 20
    for plan in plans:
        draft = shorten(graph, plan, 500.0)
        if draft is None:
            continue
        assert draft.length <= 500.0
        assert draft.plan.edges == plan.edges[: len(draft.plan.edges)]
        last = graph.town.lanes[draft.plan.left[-1]]
        assert 15.0 <= draft.end <= last.length - 15.0
        made = draft.make(graph, "x")
        assert made.length == pytest.approx(draft.length, rel=0.02)


def test_too_few_different_routes_are_refused():
    graph = StreetGraph(load_town("town02"))
    plans = draft_paths(graph, 3, np.random.default_rng(3))[:1]
    with pytest.raises(InputError, match="Only 1 different routes were found in town02, 3"):
        choose(graph, plans, [400.0, 400.0, 400.0])
