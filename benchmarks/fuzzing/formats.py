"""Table of the formats that plant-bench reads from untrusted files, by name."""

from fuzzing import agents, data, drives, maps, models, reports, route_files, runs, worlds

_ROOMS = (worlds, runs, reports, data, drives, models, maps, route_files, agents)
FORMATS = {item.name: item for room in _ROOMS for item in room.FORMATS}
