import json

import pytest

from plant_bench.errors import InputError
from plant_bench.reports.replay.replay_source import source_in_run


@pytest.fixture
def run(source):
    folder = source.recording.parents[1]
    facts = {"agent": "cruise", "agent_checksum": "a", "suite": "longest6", "seed": 0}
    facts |= {"density": "dense", "protocol": "p", "towns": {}, "routes": {"town01-0": "c"}}
    facts |= {"repetitions": 3, "command": "", "versions": {}, "processor": ""}
    (folder / "run.json").write_text(json.dumps(facts))
    (folder / "episodes").mkdir()
    for number in (0, 2):
        path = folder / "episodes" / f"town01-0_r{number}_abc.json"
        path.write_text(source.result.model_copy(update={"repetition": number}).to_json())
    return folder


def test_an_episode_is_found_by_route_and_repetition(run, source):
    found = source_in_run(run, "town01-0", None)
    assert found.id == "ours/town01-0_r0_abc"
    assert found.recording == source.recording
    assert found.title == "cruise"
    assert source_in_run(run, "0", None).id == found.id
    assert source_in_run(run, "town01-0", 2).id == "ours/town01-0_r2_abc"


def test_unknown_episode_lists_the_existing_ones(run, tmp_path):
    with pytest.raises(InputError, match=r"no route 'town01-1'.*Did you mean town01-0\?"):
        source_in_run(run, "town01-1", None)
    with pytest.raises(InputError, match="town01-0, repetition 1: its repetitions are 0, 2"):
        source_in_run(run, "town01-0", 1)
    with pytest.raises(InputError, match="not a run of plant-bench"):
        source_in_run(tmp_path, "town01-0", None)
