"""docs/how-to/add-a-hazard.md adds a hazard with one row and one script: done here as written."""

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.sumo

ROOT = Path(__file__).parents[2]
TABLE, SCRIPT = "world/hazard_table.py", "sim/hazards/stopped_rider.py"
DRIVE = """
import json, sys
from dataclasses import replace
from pathlib import Path

from plant_bench.sim.simulation import Simulation
from plant_bench.towns.hazard_image import save_hazard_pictures
from plant_bench.towns.route_hazards import place_hazards
from plant_bench.world.hazard import Hazard, HazardKind
from plant_bench.world.route import Scenario, load_suite
from plant_bench.world.town import load_town
from tests.sumo import driving

kind = HazardKind("stopped_rider")
found = []
for route in load_suite("longest6")[:3]:
    hazards = place_hazards(load_town(route.town), route, 2)
    found += [(route, hazard) for hazard in hazards if hazard.kind is kind]
route, hazard = min(found, key=lambda pair: pair[1].at)
assert Hazard.from_payload(json.loads(json.dumps(hazard.to_payload()))) == hazard
pictures = [path.name for path in save_hazard_pictures(Path(sys.argv[1]))]


def drive(agent):
    with Simulation(Scenario(replace(route, hazards=(hazard,)), 1, "empty")) as simulation:
        for referee in driving.drive(simulation, route, agent):
            if referee.progress > hazard.at + 45.0 or referee.status is not None:
                outcome = simulation.outcomes[0]
                return outcome.phase.value, outcome.reason, len(referee.infractions)


told = {"placed": len(found), "wait": hazard.parameters["wait"], "pictures": pictures}
print(json.dumps(told | {agent: drive(agent) for agent in ("cruise", "expert")}))
"""


def block(name: str) -> str:
    """Return the code block of the page that is marked with a name."""
    page = (ROOT / "docs" / "how-to" / "add-a-hazard.md").read_text(encoding="utf-8")
    (code,) = re.findall(rf"<!-- {name} -->\n```python\n(.*?)```", page, re.DOTALL)
    return code


def follow(folder: Path, *, script: bool = True) -> None:
    """Follow the page in a copy of the package."""
    package = folder / "plant_bench"
    shutil.copytree(ROOT / "plant_bench", package, ignore=shutil.ignore_patterns("__pycache__"))
    for name in ("networks", "routes", "models"):
        (folder / name).symlink_to(ROOT / name)
    table = (package / TABLE).read_text(encoding="utf-8")
    rows, mark, rest = table.partition("\n\nHAZARDS: ")
    assert mark
    (package / TABLE).write_text(f"{rows}{block('row')}{mark}{rest}", encoding="utf-8")
    if script:
        (package / SCRIPT).write_text(block("script"), encoding="utf-8")


def run(folder: Path) -> subprocess.CompletedProcess[str]:
    paths = os.pathsep.join((str(folder), str(ROOT)))
    return subprocess.run(
        [sys.executable, "-c", DRIVE, str(folder / "pictures")],
        env={**os.environ, "PYTHONPATH": paths}, cwd=folder, text=True, capture_output=True,
        check=False,
    )  # fmt: skip


def test_tutorial_row_and_script_make_a_working_hazard(tmp_path: Path) -> None:
    follow(tmp_path)
    done = run(tmp_path)
    assert done.returncode == 0, done.stderr
    told = json.loads(done.stdout.splitlines()[-1])
    assert told["placed"] >= 1
    assert 3.0 <= told["wait"] <= 6.0
    assert "stopped_rider.png" in told["pictures"]
    assert told["cruise"] == ["done", "", 1], "who sees nobody runs into the rider"
    assert told["expert"] == ["done", "", 0]


def test_hazard_row_with_a_missing_script_is_refused_by_name(tmp_path: Path) -> None:
    follow(tmp_path, script=False)
    done = run(tmp_path)
    assert done.returncode != 0
    last = done.stderr.splitlines()[-1]
    assert "InputError" in last
    for part in (
        "'stopped_rider' has no behaviour",
        "world/hazard_table.py",
        "stopped_rider:Stopped",
    ):
        assert part in last
