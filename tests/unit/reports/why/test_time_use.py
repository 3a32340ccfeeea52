"""Where the time of a blocked or late episode went."""

from dataclasses import replace
from pathlib import Path

import pytest

from plant_bench.agent import NO_ACTOR, Cause, Control, Reason
from plant_bench.data.recorder import Recorder
from plant_bench.data.recording import Recording
from plant_bench.reports.why import incident_text
from plant_bench.reports.why.incident_findings import find
from plant_bench.reports.why.time_use import TimeUse, time_use_of
from plant_bench.reports.why.verdicts import verdict
from plant_bench.scoring.infractions import InfractionKind
from plant_bench.world.scene import ActorKind, Light
from tests.builders import make_actors, make_ego, make_scene
from tests.unit.reports.why.moments_by_hand import (
    FOE,
    HIT,
    braking_from,
    infraction,
    moment,
    postmortem,
    route,
)

BEHIND_CAR, AT_LIGHT, ALONE = 20.0, 46.0, 80.0  # m along the route
CAR_AT = 30.0


def use(path: Path, *stops: tuple[float, int, Reason | None], light: Light) -> TimeUse:
    """An episode of stops (place, ticks and recorded reason), with 1 m a tick in between."""
    recorder, tick, driven = Recorder(path / "e.parquet", {}), 0, 0
    actors = make_actors([(CAR_AT, 0.0, 0.0)], kinds=(ActorKind.CAR,), ids=(FOE,))
    for x, ticks, reason in stops:
        for metre in range(driven, int(x)):
            ego = make_ego(20.0, x=float(metre))
            recorder.add(make_scene(tick, ego=ego, actors=actors, lights=[light]))
            tick += 1
        driven = int(x)
        for row in range(ticks):
            ego = make_ego(x=x)
            decided = reason if row % 2 == 0 else None  # a decision every second tick
            scene = make_scene(tick, ego=ego, actors=actors, lights=[light])
            recorder.add(scene, Control(0.0, 0.0), decided)
            tick += 1
    recorder.close()
    return time_use_of(Recording.load(path / "e.parquet"), 7, route())


def test_stops_have_the_recorded_reasons(tmp_path: Path):
    found = use(
        tmp_path,
        (BEHIND_CAR, 40, Reason(Cause.CONFLICT, FOE)),
        (AT_LIGHT, 100, Reason(Cause.LIGHT)),
        (ALONE, 20, Reason(Cause.FREE)),
        light=Light.GREEN,
    )

    assert found.recorded
    assert found.seconds == pytest.approx(240 * 0.05)
    assert list(found.stationary) == [Cause.LIGHT, Cause.CONFLICT, Cause.FREE]
    assert list(found.stationary.values()) == pytest.approx([5.0, 2.0, 1.0])
    first, second, _ = found.stops
    assert (first.start, first.seconds) == pytest.approx((4.3, 5.0))
    assert first.progress == pytest.approx(AT_LIGHT, abs=0.5)
    assert (second.reason, second.kind) == (Reason(Cause.CONFLICT, FOE), ActorKind.CAR)


def test_stops_without_recorded_reasons_are_explained_by_the_scene(tmp_path: Path):
    stops = ((BEHIND_CAR, 60, None), (AT_LIGHT, 40, None), (ALONE, 20, None))

    red = use(tmp_path, *stops, light=Light.RED)
    green = use(tmp_path, *stops, light=Light.GREEN)

    assert not red.recorded
    assert [stop.reason for stop in red.stops] == [
        Reason(Cause.LEADER, FOE),
        Reason(Cause.LIGHT),
        Reason(Cause.FREE),
    ]
    assert [stop.reason.cause for stop in green.stops] == [Cause.LEADER, Cause.FREE, Cause.FREE]


def test_time_out_is_explained_by_where_the_time_went(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(incident_text, "_console", incident_text.Console(width=140))
    time = use(
        tmp_path, (AT_LIGHT, 100, Reason(Cause.LIGHT)), (ALONE, 20, Reason(Cause.FREE)),
        light=Light.GREEN,
    )  # fmt: skip
    moments = [moment(tick, braking_from(0)) for tick in range(HIT + 1)]
    incident, looked = postmortem(infraction(InfractionKind.TIMEOUT), moments)
    finding = find(incident, looked, time)

    text = verdict(finding, looked)
    incident_text.print_finding(finding, looked)

    assert text.startswith(
        "The ego was stationary for 6 of 10 s (as the planner recorded: 5 s for light, 1 s for "
        "nothing). The longest stop lasted 5 s, 46 m along the route."
    )
    assert "did not brake" not in text
    out = capsys.readouterr().out
    assert "Longest stops" in out
    assert "expert m/s2" not in out
    assert "did not brake" in verdict(find(incident, looked), looked)


def test_recorded_reason_is_shown_after_the_code_has_changed():
    now = moment(HIT, braking_from(0), planner=None)
    incident, looked = postmortem(infraction(), [now])

    cells = incident_text._cells(
        replace(now, reason=Reason(Cause.LIGHT, NO_ACTOR)), find(incident, looked)
    )

    assert cells[3] == "light"
    assert incident_text._cells(now, find(incident, looked))[3] == "-"
