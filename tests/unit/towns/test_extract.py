"""Extraction of a SUMO network."""

from plant_bench.towns.extract import extract_town

NET = """<net>
<edge id="in" from="a" to="b"><lane id="in_0" index="0" speed="9" shape="0,0 9,0"/></edge>
<edge id="out" from="b" to="c"><lane id="out_0" index="0" speed="9" shape="9,0 19,0"/></edge>
<junction id="b" type="traffic_light" x="9" y="0"/>
<connection from="in" to="out" fromLane="0" toLane="0" tl="b" linkIndex="{index}"
  dir="s" state="o"/>
</net>"""


def test_signal_with_removed_links_keeps_its_indices():
    town = extract_town(NET.format(index=5), "test")

    assert town.signals == {"b": 6}
    town.check_names()  # so it can be written and read again


def test_signal_with_all_links_has_as_many_indices():
    assert extract_town(NET.format(index=0), "test").signals == {"b": 1}
