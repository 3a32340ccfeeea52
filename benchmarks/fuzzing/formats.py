"""Each format that plant-bench reads from strangers, by its name."""

from fuzzing import agents, data, drives, maps, models, runs, worlds

_ROOMS = (worlds, runs, data, drives, models, maps, agents)
FORMATS = {item.name: item for room in _ROOMS for item in room.FORMATS}
