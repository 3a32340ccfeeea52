"""Lines that a run prints where there is no terminal."""

import pytest

from plant_bench.cli import run_progress
from plant_bench.runner.episode.jobs import Job
from plant_bench.runner.run.episode_queue import EpisodeProgressed, EpisodeStarted
from plant_bench.scoring.penalties import PenaltyScheme
from tests.builders import straight_route


def test_slow_episode_is_said_every_minute(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    now = 1000.0
    monkeypatch.setattr(run_progress.time, "monotonic", lambda: now)
    job = Job("mine", "c0ffee", straight_route(name="town01-5"), 2, 0, "dense")
    show = run_progress.RunProgress([job], [job], PenaltyScheme.LB1_0)
    said = []
    show(EpisodeStarted(0, job))
    for now, share in [(1059.0, 0.001), (1061.0, 0.002), (1062.0, 0.003), (1122.0, 0.25)]:  # noqa: B007 - `now` is the clock
        show(EpisodeProgressed(0, job, share))
        said.append(capsys.readouterr().err)

    assert said == [
        "",
        "town01-5 r2: 0.2 % of the route driven.\n",
        "",
        "town01-5 r2: 25.0 % of the route driven.\n",
    ]
