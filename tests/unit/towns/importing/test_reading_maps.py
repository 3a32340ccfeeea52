"""Untrusted map files: what is read, and what is refused with one line."""

import gzip

import pytest

from plant_bench.errors import InputError
from plant_bench.towns.importing import map_source as source
from plant_bench.towns.importing.map_source import MapKind, read_source
from plant_bench.towns.importing.town_making import check_name

BOMB = """<?xml version="1.0"?><!DOCTYPE net [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;">]>
<net><edge id="&b;"/></net>"""
NET = """<net><edge id=":j" function="internal"><lane id=":j_0"/></edge>
<edge id="road"><lane id="road_0"/></edge>
<edge id="path"><lane id="path_0" allow="pedestrian"/></edge>
<connection/></net>"""


def write(folder, content):
    path = folder / "map.xml"
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return path


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ("", "not a complete XML"),
        ("<net><edge", "not a complete XML"),
        ("no xml at all", "not a complete XML"),
        ("<routes/>", "begins with <routes>"),
        (BOMB, "document type"),
        ("<!DOCTYPE osm SYSTEM 'file:///etc/passwd'><osm/>", "document type"),
        ("<net><include href='/etc/passwd'/></net>", "<include>"),
        ("<net>" + "<a>" * 100 + "</a>" * 100 + "</net>", "nested elements"),
        ("<?xml version='1.0' encoding='utf-7'?><net/>", "UTF-8"),
        ("<net/>".encode("utf-16"), "UTF-8"),
        (b"PK\x03\x04....", "archive"),
        (gzip.compress(b"<net/>", mtime=0)[:-9], "damaged gzip"),
        ("<net lefthand='true'/>", "left-hand"),
        ("<OpenDRIVE><road rule='LHT'/></OpenDRIVE>", "left-hand"),
        ("<osm><way><tag k='driving_side' v='left'/></way></osm>", "left-hand"),
        ("<osm><way><tag k='lanes:forward' v='100000'/></way></osm>", "a road of 100000 lanes"),
    ],
)
def test_invalid_map_files_are_refused(content, words, tmp_path):
    with pytest.raises(InputError, match=words) as error:
        read_source(write(tmp_path, content))

    assert "\n" not in str(error.value)


def test_oversized_compressed_map_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(source, "MAX_BYTES", 2**20)

    with pytest.raises(InputError, match="more than 1 MB"):
        read_source(write(tmp_path, gzip.compress(b" " * 2**23)))


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(InputError, match=r"no map file .*nothing\.osm"):
        read_source(tmp_path / "nothing.osm")


def test_compressed_network_is_read(tmp_path):
    found = read_source(write(tmp_path, gzip.compress(NET.encode())))

    assert found.kind is MapKind.SUMO
    assert found.internal_lanes
    assert found.non_car_ways == 1
    assert found.counts["connection"] == 1


@pytest.mark.parametrize(
    "name", ["", "../x", "/abs", "a/b", "a.b", "a b", "1a", "a" * 41, "😀", "..", "é", "town01\n"]
)
def test_town_name_with_path_traversal_is_refused(name):
    with pytest.raises(InputError, match="--name"):
        check_name(name)


@pytest.mark.parametrize("name", ["town01", "TOWN06", "unseen03"])
def test_benchmark_town_names_are_refused(name):
    with pytest.raises(InputError, match="has a town of that name"):
        check_name(name)


def test_an_ordinary_name_is_accepted():
    check_name("my-Town_2")
