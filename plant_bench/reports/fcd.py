"""Writes a recorded episode as a file of SUMO's floating car data (FCD).

Format: https://sumo.dlr.de/docs/Simulation/Output/FCDOutput.html. Positions are those of the front
bumper, angles are in degrees clockwise from north, as in SUMO.
"""

import gzip
import math
from collections.abc import Iterator
from pathlib import Path

from plant_bench.atomic_files import write_whole
from plant_bench.data.recording import Recording
from plant_bench.world.scene import EGO_LENGTH, ActorKind, Scene

EGO = "ego"
HEADER = (
    '<?xml version="1.0" encoding="UTF-8"?>\n'
    '<fcd-export xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" '
    'xsi:noNamespaceSchemaLocation="http://sumo.dlr.de/xsd/fcd_file.xsd">\n'
)


def write_fcd(recording: Recording, path: Path) -> int:
    """Write an episode as FCD; a path that ends in ".gz" is compressed.

    Returns:
        Number of time steps.

    Raises:
        OSError: The file cannot be written.
    """
    text = "".join((HEADER, *map(_timestep, recording), "</fcd-export>\n"))

    def write(part: Path) -> None:
        content = text.encode()
        if path.suffix == ".gz":
            content = gzip.compress(content, mtime=0)
        part.write_bytes(content)

    write_whole(path, write)
    return len(recording)


def _timestep(scene: Scene) -> str:
    return f'  <timestep time="{scene.time:.2f}">\n{"".join(_elements(scene))}  </timestep>\n'


def _elements(scene: Scene) -> Iterator[str]:
    ego = scene.ego
    yield _element("vehicle", EGO, (ego.x, ego.y, ego.yaw), EGO_LENGTH, ego.speed, "ego")
    actors = scene.actors
    for number, pose, extent, speed, kind in zip(
        actors.ids.tolist(),
        actors.poses.tolist(),
        actors.extents.tolist(),
        actors.speeds.tolist(),
        actors.kinds.tolist(),
        strict=True,
    ):
        name = ActorKind(kind).name.lower()
        element = "person" if kind == ActorKind.PEDESTRIAN else "vehicle"
        yield _element(element, str(number), tuple(pose), extent[0], speed, name)


def _element(
    element: str,
    name: str,
    pose: tuple[float, ...],
    length: float,
    speed: float,
    kind: str,
) -> str:
    x, y, yaw = pose
    front = 0.5 * length if element == "vehicle" else 0.0  # of a person, SUMO has the middle
    angle = (90.0 - math.degrees(yaw)) % 360.0
    return (
        f'    <{element} id="{name}" x="{x + front * math.cos(yaw):.2f}" '
        f'y="{y + front * math.sin(yaw):.2f}" angle="{angle:.2f}" type="{kind}" '
        f'speed="{speed:.2f}"/>\n'
    )
