"""Small maps in OpenDRIVE, OpenStreetMap and SUMO format."""

import math
import os
import subprocess
from pathlib import Path

import sumo

GEO = "+proj=tmerc +lat_0=0 +lon_0=0 +k=1 +x_0=0 +y_0=0 +datum=WGS84 +units=m +no_defs"


def ring(radius: float = 120.0, width: float = 3.5, header: str = "", junctions: str = "") -> str:
    """Return an OpenDRIVE map: a circle of four arcs, with one lane in each direction."""
    length = math.pi * radius / 2

    def lane(number: int) -> str:
        return (
            f'<lane id="{number}" type="driving" level="false"><link><predecessor id="{number}"/>'
            f'<successor id="{number}"/></link><width sOffset="0" a="{width}" b="0" c="0" d="0"/>'
            "</lane>"
        )

    def road(number: int, x: float, y: float, heading: float, before: int, after: int) -> str:
        return (
            f'<road name="" length="{length:.6f}" id="{number}" junction="-1"><link>'
            f'<predecessor elementType="road" elementId="{before}" contactPoint="end"/>'
            f'<successor elementType="road" elementId="{after}" contactPoint="start"/></link>'
            f'<planView><geometry s="0" x="{x}" y="{y}" hdg="{heading}" length="{length:.6f}">'
            f'<arc curvature="{1 / radius:.9f}"/></geometry></planView><lanes><laneSection s="0">'
            f'<left>{lane(1)}</left><center><lane id="0" type="none" level="false"/></center>'
            f"<right>{lane(-1)}</right></laneSection></lanes></road>"
        )

    quarter = math.pi / 2
    roads = (
        road(1, 0, -radius, 0, 4, 2)
        + road(2, radius, 0, quarter, 1, 3)
        + road(3, 0, radius, math.pi, 2, 4)
        + road(4, -radius, 0, -quarter, 3, 1)
    )
    return (
        '<?xml version="1.0"?><OpenDRIVE><header revMajor="1" revMinor="6" name=""><geoReference>'
        f"<![CDATA[{GEO}]]></geoReference>{header}</header>{roads}{junctions}</OpenDRIVE>"
    )


def touching_junctions() -> str:
    """Return an OpenDRIVE map whose internal shapes crash netconvert 1.28."""

    def road(number: int, length: float, x: float, junction: int, before: str, after: str) -> str:
        return (
            f'<road name="" length="{length}" id="{number}" junction="{junction}">'
            f"<link>{before}{after}</link><planView>"
            f'<geometry s="0" x="{x}" y="0" hdg="0" length="{length}"><line/></geometry></planView>'
            '<lanes><laneSection s="0"><center><lane id="0" type="none" level="false"/></center>'
            '<right><lane id="-1" type="driving" level="false"><link><predecessor id="-1"/>'
            '<successor id="-1"/></link><width sOffset="0" a="3.5" b="0" c="0" d="0"/></lane>'
            "</right></laneSection></lanes></road>"
        )

    def link(kind: str, element: str, number: int, contact: str = "") -> str:
        point = f' contactPoint="{contact}"' if contact else ""
        return f'<{kind} elementType="{element}" elementId="{number}"{point}/>'

    def junction(number: int, incoming: int, connecting: int) -> str:
        return (
            f'<junction id="{number}" name=""><connection id="0" incomingRoad="{incoming}" '
            f'connectingRoad="{connecting}" contactPoint="start"><laneLink from="-1" to="-1"/>'
            "</connection></junction>"
        )

    first, second = link("successor", "junction", 5), link("predecessor", "junction", 8)
    before = link("predecessor", "road", 1, "end"), link("successor", "road", 11, "start")
    after = link("predecessor", "road", 10, "end"), link("successor", "road", 2, "start")
    roads = road(1, 100, 0, -1, "", first) + road(10, 10, 100, 5, *before)
    roads += road(11, 10, 110, 8, *after) + road(2, 100, 120, -1, second, "")
    return (
        '<?xml version="1.0"?><OpenDRIVE><header revMajor="1" revMinor="4" name="">'
        "<geoReference>\n<TODO/>\n</geoReference></header>"
        f"{roads}{junction(5, 1, 10)}{junction(8, 10, 11)}</OpenDRIVE>"
    )


def osm_grid(size: int, *, stubs: bool) -> str:
    """Return an OpenStreetMap file: a grid of two-way streets 120 m apart."""
    degree = 120 / 111320
    nodes: dict[tuple[float, float], int] = {}

    def node(i: float, j: float) -> int:
        return nodes.setdefault((i, j), len(nodes) + 1)

    ends = [-0.5, *range(size), size - 0.5] if stubs else list(range(size))
    ways = []
    for k in range(size):
        ways += [[node(i, k) for i in ends], [node(k, j) for j in ends]]
    texts = [
        f'<node id="{number}" lat="{48 + j * degree:.7f}" lon="{11 + i * degree / 0.669:.7f}"/>'
        for (i, j), number in nodes.items()
    ]
    texts += [
        f'<way id="{number}">'
        + "".join(f'<nd ref="{ref}"/>' for ref in way)
        + '<tag k="highway" v="primary"/></way>'
        for number, way in enumerate(ways, 1)
    ]
    return '<?xml version="1.0" encoding="UTF-8"?><osm version="0.6">' + "".join(texts) + "</osm>"


def sumo_grid(folder: Path, size: int, step: float) -> str:
    """Return a SUMO network: a grid of two-way streets with a lane each way, without dead ends."""
    places = [(i, j) for i in range(size) for j in range(size)]
    nodes = "".join(f'<node id="{i}{j}" x="{i * step}" y="{j * step}"/>' for i, j in places)
    pairs = [
        (f"{i}{j}", f"{k}{m}")
        for i, j in places
        for k, m in ((i + 1, j), (i, j + 1))
        if (k, m) in places
    ]
    edges = "".join(
        f'<edge id="{a}-{b}" from="{a}" to="{b}" numLanes="1" speed="13.9"/>'
        for one, other in pairs
        for a, b in ((one, other), (other, one))
    )
    (folder / "n.xml").write_text(f"<nodes>{nodes}</nodes>")
    (folder / "e.xml").write_text(f"<edges>{edges}</edges>")
    program = Path(sumo.SUMO_HOME) / "bin" / "netconvert"
    files = ["-n", "n.xml", "-e", "e.xml", "-o", "made.xml"]
    subprocess.run(
        [program, *files, "--no-turnarounds"],
        cwd=folder,
        env={**os.environ, "SUMO_HOME": sumo.SUMO_HOME},
        check=True,
        capture_output=True,
    )
    return (folder / "made.xml").read_text()
