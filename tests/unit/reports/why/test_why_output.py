"""Printed and drawn output: complete, readable, and safe with hostile names."""

import io
from dataclasses import replace

import numpy as np
import pytest
from PIL import Image
from rich.console import Console

from plant_bench.errors import InputError
from plant_bench.reports.why import incident_list as listing
from plant_bench.reports.why import incident_text as text
from plant_bench.reports.why.incident_figure import save_picture
from plant_bench.reports.why.incident_findings import find
from plant_bench.reports.why.incident_list import print_infractions, worst_first
from plant_bench.reports.why.incident_text import print_episode, spread_moments
from plant_bench.reports.why.incidents import check_recorded, incidents
from plant_bench.reports.why.top_view import EGO, EXPERTS, TOP
from plant_bench.scoring.infractions import InfractionKind, Status
from tests.unit.reports.why.moments_by_hand import (
    HIT,
    braking_from,
    infraction,
    moment,
    postmortem,
    record,
)

HOSTILE = "[bold]$\\frac{a}$<script>\x1b[31m\U0001f697" + "x" * 10_000
WINDOW = range(HIT - 60, HIT + 1)


@pytest.fixture
def printed(monkeypatch):
    def of(module, call):
        console = Console(record=True, width=160, file=io.StringIO())
        monkeypatch.setattr(module, "_console", console)
        call()
        return console.export_text()

    return of


def looked_at(**changes):
    incident, looked = postmortem(
        infraction(), [moment(tick, braking_from(HIT - 30)) for tick in WINDOW], **changes
    )
    return find(incident, looked), looked


def test_printed_table_of_an_episode_ends_at_the_incident(printed):
    finding, looked = looked_at()

    out = printed(text, lambda: print_episode(looked, [finding]))

    assert "all 100 scenes equal the recorded ones" in out
    assert "1. collision with a vehicle at 3.55 s: the ego ran into car 17" in out
    rows = [line.split() for line in out.splitlines() if " s  " in line and "before" not in line]
    assert [row[0] for row in rows] == [
        "3.0",
        "2.6",
        "2.2",
        "1.9",
        "1.5",
        "1.1",
        "0.8",
        "0.4",
        "0.0",
    ]
    assert rows[-1][-1] == "0.0"
    assert "pedestrian 500001, car 17" in out
    assert "3.0 s before: 2 actors in sight, limit 8.3 m/s, straight on in 24 m" in out


def test_differing_scenes_are_reported(printed):
    finding, looked = looked_at(differs_at=40, difference="the ego")

    out = printed(text, lambda: print_episode(looked, [finding]))

    assert "differs from the recording from tick 40 of 100 on (the ego)" in out


def test_untrusted_names_are_printed_as_one_line(printed, tmp_path):
    finding, looked = looked_at()
    looked = replace(looked, result=looked.result.model_copy(update={"agent": HOSTILE}))

    out = printed(text, lambda: print_episode(looked, [finding]))
    save_picture(finding, looked, tmp_path / "why.png")

    assert "[bold]" in out
    assert "\x1b" not in out
    assert len(out) < 5000
    assert (tmp_path / "why.png").is_file()


def test_picture_shows_ego_top_ranked_and_expert_vehicle(tmp_path):
    finding, looked = looked_at()

    save_picture(finding, looked, tmp_path / "deep" / "why.png")

    with Image.open(tmp_path / "deep" / "why.png") as image:
        pixels = np.asarray(image.convert("RGB")).reshape(-1, 3).astype(int)
    for colour in (EGO, TOP, EXPERTS):
        wanted = [int(colour[place : place + 2], 16) for place in (1, 3, 5)]
        assert (np.abs(pixels - wanted).sum(axis=1) < 12).sum() > 40
    assert not list(tmp_path.rglob("*.part"))


def test_all_moments_are_shown_if_there_are_few():
    incident, looked = postmortem(infraction(), [moment(HIT, braking_from(0))])

    assert len(spread_moments(find(incident, looked))) == 1


def test_worst_routes_are_first_and_clean_episodes_left_out(printed):
    clean = record(route="town01-1")
    marred = record(infraction(), route="town01-2", repetition=1)
    worse = record(infraction(), infraction(time=9.0), route="town01-3")
    crashed = record(route="town01-4", status=Status.AGENT_CRASHED, reason=HOSTILE, completion=0.01)
    results = [clean, marred, worse, crashed]

    assert worst_first(results) == [crashed, worse, marred]
    out = printed(listing, lambda: print_infractions(results, "runs/a"))
    assert "3 infractions. 3 of 4 episodes have infractions or failed." in out
    assert "plant-bench why runs/a town01-4 --repetition 0" in out
    assert "collision with a vehicle (car 17) at 3.6 s" in out


def test_window_of_a_blocked_episode_covers_the_whole_block():
    blocked = infraction(InfractionKind.BLOCKED, time=400.0)
    [one] = incidents(record(blocked), 4.0)

    assert (one.window.first, one.window.last) == (8000 - 3600 - 80, 8000)
    assert one.window.ranked_from == 8000 - 80 - 20


@pytest.mark.parametrize("time", [-5.0, 1e11, 1e308])
def test_infraction_outside_the_recording_is_named(time):
    with pytest.raises(InputError, match="has an infraction at .* its recording lasts 10 s"):
        check_recorded(record(infraction(InfractionKind.BLOCKED, time=time)), 200)


def test_infraction_at_the_end_of_the_recording_is_explained():
    check_recorded(record(infraction(InfractionKind.BLOCKED, time=9.95)), 200)
