"""The benchmark as a Gymnasium environment; importing it registers "PlantBench-v0".

    gymnasium.make("plant_bench.gym:PlantBench-v0", suite="longest6", routes="0-2")

See docs/reference/gymnasium.md.
"""

from plant_bench.errors import InputError

try:
    import gymnasium
except ModuleNotFoundError as _error:
    _message = "The environment needs Gymnasium: pip install '.[gym]' in a checkout of plant-bench."
    raise InputError(_message) from _error

ENV_ID = "PlantBench-v0"

if ENV_ID not in gymnasium.registry:
    gymnasium.register(ENV_ID, entry_point="plant_bench.gym.environment:PlantBenchEnv")
