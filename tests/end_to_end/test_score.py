"""From the command line to the tables, with SUMO: one short drive, resumed, rescored, compared."""

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
pytestmark = pytest.mark.sumo

STOPPING = """
from plant_bench.agent import Control


class Stops:
    inputs = frozenset()
    most = 60

    def reset(self, route):
        self.ticks = 0

    def act(self, observation):
        self.ticks += 1
        if self.ticks > self.most:
            raise ValueError("enough")
        return Control(1.0, 0.0)


class StopsLater(Stops):
    most = 200
"""


def plant_bench(*arguments: str, cwd: Path, code: int = 0) -> str:
    done = subprocess.run(
        [sys.executable, "-m", "plant_bench", *arguments],
        cwd=cwd,
        env=os.environ | {"NO_COLOR": "1", "TERM": "dumb"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == code, done.stdout + done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    """A folder with a run of the example agent in it."""
    folder = tmp_path_factory.mktemp("place")
    agent = f"{ROOT / 'examples' / 'my_agent.py'}:MyAgent"
    plant_bench(*score(agent, "one", workers=1), cwd=folder)
    return folder


def score(agent: str, out: str, *, workers: int, routes: str = "town01-5,town02-5") -> list[str]:
    fixed = ["--routes", routes, "--repetitions", "1", "--density", "light"]
    return ["score", "--agent", agent, *fixed, "--out", out, "--workers", str(workers)]


def records(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in (folder / "episodes").iterdir()}


def test_example_agent_makes_progress(place):
    rows = [json.loads(text) for text in records(place / "one").values()]

    assert len(rows) == 2
    assert all(row["completion"] > 0.2 for row in rows)
    assert (place / "one" / "summary.csv").read_text().count("\n") == 3
    assert json.loads((place / "one" / "run.json").read_text())["versions"]["libsumo"]


def test_results_do_not_depend_on_the_number_of_workers(place):
    agent = f"{ROOT / 'examples' / 'my_agent.py'}:MyAgent"
    plant_bench(*score(agent, "two", workers=2), cwd=place)

    assert records(place / "one") == records(place / "two")
    for path in (place / "one" / "recordings").iterdir():
        assert path.read_bytes() == (place / "two" / "recordings" / path.name).read_bytes()


def test_repeating_a_finished_command_drives_nothing(place):
    agent = f"{ROOT / 'examples' / 'my_agent.py'}:MyAgent"
    before = records(place / "one")

    said = plant_bench(*score(agent, "one", workers=1), cwd=place)

    assert "Nothing to drive" in said
    assert records(place / "one") == before


def test_verify_confirms_a_run_and_rejects_a_tampered_one(place):
    agent = f"{ROOT / 'examples' / 'my_agent.py'}:MyAgent"
    routes = ["--routes", "town01-5,town02-5", "--workers", "1"]
    shutil.copytree(place / "one", place / "tampered")
    record = next((place / "tampered" / "episodes").glob("town01-5*"))
    text = re.sub(r'"completion": [\d.]+', '"completion": 0.75', record.read_text())
    record.write_text(text)

    said = plant_bench("verify", "one", "--agent", agent, *routes, "--sample", "1", cwd=place)
    assert "CONFIRMED: 2 of 2 episodes scored again from the recording, 1 simulated again" in said

    drive = ["--controls", "--all", "--json", "found.json"]
    said = plant_bench("verify", "tampered", *routes, *drive, cwd=place, code=1)
    found = json.loads((place / "found.json").read_text())
    assert "2 simulated again, 1 and 1 different" in said
    assert [item["equal"] for item in found["episodes"]] == [False, True]
    assert found["episodes"][0]["difference"]["field"] == "completion"
    assert {item["place"] for item in found["findings"]} == {"summary.json", "summary.csv"}


def test_penalty_scheme_changes_the_summary_but_no_record(place):
    agent = f"{ROOT / 'examples' / 'my_agent.py'}:MyAgent"
    before = records(place / "one")

    said = plant_bench(*score(agent, "one", workers=1), "--penalties", "lb2.1", cwd=place)
    assert "penalties lb2.1" in said
    assert json.loads((place / "one" / "summary.json").read_text())["penalties"] == "lb2.1"
    assert "lb2.1" in (place / "one" / "summary.csv").read_text()

    said = plant_bench(*score(agent, "one", workers=1), cwd=place)
    assert "penalties lb1.0" in said
    assert "Other metrics" in said
    assert "cannot be distinguished" not in said  # one repetition
    assert json.loads((place / "one" / "summary.json").read_text())["penalties"] == "lb1.0"
    assert records(place / "one") == before
    assert all(json.loads(text)["measures"] for text in before.values())


def test_rescore_reproduces_the_records(place):
    assert "2 of 2 records are equal" in plant_bench("rescore", "one", cwd=place)
    for name in ("summary.json", "summary.csv"):
        assert (place / "one" / "rescored" / name).read_bytes() == (
            place / "one" / name
        ).read_bytes()
    assert "penalties lb2.1" in plant_bench("rescore", "one", "--penalties", "lb2.1", cwd=place)


def test_rescore_detects_a_changed_record(place, tmp_path):
    agent = f"{ROOT / 'examples' / 'my_agent.py'}:MyAgent"
    plant_bench(*score(agent, str(tmp_path / "run"), workers=2), cwd=place)
    path = min((tmp_path / "run" / "episodes").iterdir())
    record = json.loads(path.read_text())
    path.write_text(json.dumps(record | {"distance": record["distance"] / 2}))

    assert "1 of 2 records" in plant_bench("rescore", "run", cwd=tmp_path, code=1)


def test_crashing_agent_is_scored(place):
    (place / "stops.py").write_text(STOPPING)

    said = plant_bench(*score("stops.py:Stops", "crash", workers=2), cwd=place, code=2)

    assert "2 Failed - Agent crashed" in said
    assert "2 of 2 records are equal" in plant_bench("rescore", "crash", cwd=place)
    assert "Too few routes" in plant_bench("compare", "one", "crash", cwd=place)


def test_compare_exits_with_1_on_a_regression(tmp_path):
    (tmp_path / "stops.py").write_text(STOPPING)
    for name in ("Stops", "StopsLater"):
        drives = score(f"stops.py:{name}", name, workers=2, routes="6-11")
        plant_bench(*drives, cwd=tmp_path, code=2)

    assert "Better" in plant_bench("compare", "Stops", "StopsLater", cwd=tmp_path)
    assert "Worse" in plant_bench("compare", "StopsLater", "Stops", cwd=tmp_path, code=1)
    said = plant_bench(
        "compare", "StopsLater", "Stops", "--penalties", "lb2.1", cwd=tmp_path, code=1
    )
    assert "penalties lb2.1" in said
