import subprocess
import sys

LOADED = """
import sys
from plant_bench.runner.workers.preloading import preloader

def load(agent, *modules, isolate=False):
    preloader(agent, isolate=isolate)()
    return [module in sys.modules for module in modules]

later = preloader("expert", isolate=False)
assert "plant_bench.runner.episode.loop" not in sys.modules, "making it loads nothing"
assert load("their.module:Planner", "plant_bench.runner.episode.loop", "their") == [True, False]
assert load("expert", "plant_bench.agents.expert", isolate=True) == [False]
guarded = "plant_bench.agents.plant.guarded_plant"
assert load("plant@no/such", guarded, "onnxruntime") == [True, False]
assert load("plant", "onnxruntime", "torch") == [True, False]
"""


def test_workers_preload_only_built_in_planners():
    done = subprocess.run(
        [sys.executable, "-c", LOADED], capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stderr) == (0, "")
