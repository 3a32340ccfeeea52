"""One complete episode with hazards: its recording, and the record recomputed from it."""

from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

from plant_bench.agent import NO_ACTOR
from plant_bench.agents.careful.driver import INTERVAL, RESTING_INTERVAL, STILL
from plant_bench.agents.loading.checksum import agent_checksum
from plant_bench.data.recording import Recording
from plant_bench.data.recording_file import RECORDING_FORMAT
from plant_bench.runner.episode.jobs import Job
from plant_bench.runner.episode.loop import run_episode
from plant_bench.scoring.rescore_episode import rescore
from plant_bench.scoring.results import EpisodeResult
from plant_bench.world.hazard import Phase
from plant_bench.world.route import Route
from plant_bench.world.town import load_town
from tests.builders import suite_route

pytestmark = pytest.mark.sumo


class Driven(NamedTuple):
    """A record and its recording."""

    route: Route
    result: EpisodeResult
    recording: Recording


@pytest.fixture(scope="module")
def driven(tmp_path_factory: pytest.TempPathFactory) -> Driven:
    """The first 200 m of a route with a hazard on them, in dense traffic."""
    whole = suite_route("town03-1")
    route = replace(
        whole,
        id="town03-1-short",
        points=whole.points[:201],
        elevations=whole.elevations[:201],
        speed_limits=whole.speed_limits[:201],
        passages=tuple(passage for passage in whole.passages if passage.exit < 200.0),
    )
    file: Path = tmp_path_factory.mktemp("episode") / "episode.parquet"
    job = Job("expert", agent_checksum("expert"), route, 0, 5, "dense")
    return Driven(route, run_episode(job, recording=file).result, Recording.load(file))


def test_recording_holds_a_reason_for_each_decision(driven: Driven) -> None:
    reasons = driven.recording.reasons
    decisions = [tick for tick, reason in enumerate(reasons) if reason is not None]
    assert decisions[0] == 0
    assert decisions[-1] < len(reasons) - 1  # no decision at the last scene
    gaps = {tick: onward - tick for tick, onward in pairwise(decisions)}
    assert set(gaps.values()) == {INTERVAL, RESTING_INTERVAL}
    resting = [tick for tick, gap in gaps.items() if gap == RESTING_INTERVAL]
    assert all(driven.recording[tick].ego.speed < STILL for tick in resting)
    assert len({reason.cause for reason in reasons if reason}) > 1


def test_actor_named_as_reason_is_in_sight(driven: Driven) -> None:
    pairs = zip(driven.recording, driven.recording.reasons, strict=True)
    named = [
        (scene, reason.actor) for scene, reason in pairs if reason and reason.actor != NO_ACTOR
    ]
    assert len(named) > 10
    assert all(np.isin(actor, scene.actors.ids) for scene, actor in named)


def test_recording_reproduces_the_record(driven: Driven) -> None:
    assert RECORDING_FORMAT == 2
    assert any(hazard.phase is Phase.DONE for hazard in driven.result.hazards)
    again = rescore(driven.recording, load_town(driven.route.town), driven.route)
    assert again.to_json() == driven.result.to_json()
