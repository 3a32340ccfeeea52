import numpy as np

from plant_bench.reports.replay.town_shapes import town_pieces, town_script
from plant_bench.world.town import load_town
from tests.unit.reports.replay.unpacking import facts_of, unpack


def test_town_script_is_small_and_exact_to_the_centimetre():
    town = load_town("town04")
    script = town_script(town, "abc")
    assert len(script) < 60_000
    facts = facts_of(script)
    columns = unpack(facts["columns"], facts["data"])
    pieces = town_pieces(town)
    points = np.concatenate([piece.points for piece in pieces])
    assert np.abs(columns["x"] / 100.0 - points[:, 0]).max() < 0.0051
    assert columns["count"].tolist() == [len(piece.points) for piece in pieces]
    assert {facts["kinds"][kind] for kind in columns["kind"]} >= {"road", "middle", "zebra", "stop"}


def test_bridges_are_on_a_level_of_their_own():
    pieces = town_pieces(load_town("town04"))
    kinds = {piece.kind for piece in pieces if piece.upper}
    assert kinds >= {"road", "bridge"}
    assert "bridge" not in {piece.kind for piece in pieces if not piece.upper}
