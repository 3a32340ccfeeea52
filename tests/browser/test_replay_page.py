"""The page of replays in a browser, from disk and offline."""

import base64
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from plant_bench.reports.replay.replay_site import replay_path, write_replays
from plant_bench.runner.review.expert_braking import ExpertView
from tests.unit.reports.replay.drives import HIT_AT, SPEED, drive

PHONE = (390, 844)
BLUE = (63, 160, 255)
HOSTILE = "</script><img src=x onerror=alert(1)>" + "🚗" * 10_000
RANKER = f"""
import numpy as np
from plant_bench.agent import Input, Plan

class Ranks:
    inputs = frozenset({{Input.OBJECTS}})
    def reset(self, route): pass
    def act(self, observation):
        return Plan(np.stack([np.arange(1.0, 5.0) * {SPEED} / 2.0, np.full(4, 0.2)], axis=1))
    def rank(self, observation):
        return np.where(observation.actors.ids == 3, 4.0, 0.5)
"""


def third_until_1_9(*_drive: object) -> ExpertView:
    """The expert brakes for actor 3 until its responses are no longer known, at 1.9 s."""
    return ExpertView(np.arange(0, 40, 10), np.full(4, 3), "from 1.9 s on the ego differs.")


@pytest.fixture(scope="module")
def site(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("site")
    (folder / "ranker.py").write_text(RANKER)
    sources = [
        drive(folder, run="ours", title="ours", agent=f"{folder / 'ranker.py'}:Ranks"),
        replace(
            drive(folder, run="theirs", title="theirs", plans=False), ask_expert=third_until_1_9
        ),
        drive(folder, run="hostile", title=HOSTILE, reason=HOSTILE),
        drive(folder, run="thin", title="thin", every=10),
        drive(folder, run="broken", title="broken"),
        drive(folder, run="old", title="old", repetition=3, scenario="f" * 16),
    ]
    write_replays(folder, sources, workers=1, progress=lambda *_: None)
    replay_path(folder, sources[4].id).write_text("plantBench.addEpisode({", encoding="utf-8")
    return folder


def at(*runs: str) -> str:
    return "#" + "&".join(f"{run}/town01-0_r0_abc" for run in runs)


@pytest.fixture
def opened(open_page, site):
    def opened(address: str, **settings):
        page = open_page(site / "replay.html", at=address, **settings)
        page.wait_for_selector("main[aria-busy=false]")
        return page

    return opened


def clock(page) -> float:
    minutes, seconds = page.inner_text("#clock").split(" /")[0].split(":")
    return 60.0 * int(minutes) + float(seconds)


def painted(page, which: int = 0) -> np.ndarray:
    """Return the pixels of a scene: uint8 (height, width, 4)."""
    size, data = page.evaluate(
        """which => {
          const canvas = document.querySelectorAll('.stage canvas')[which];
          const {width, height} = canvas;
          const pixels = canvas.getContext('2d').getImageData(0, 0, width, height).data;
          let text = '';
          for (let at = 0; at < pixels.length; at += 9999)
            text += String.fromCharCode(...pixels.subarray(at, at + 9999));
          return [[height, width, 4], btoa(text)];
        }""",
        which,
    )
    return np.frombuffer(base64.b64decode(data), np.uint8).reshape(size)


def has_colour(pixels: np.ndarray, colour: tuple[int, int, int], least: int = 20) -> bool:
    return bool((np.abs(pixels[..., :3].astype(int) - colour).max(axis=-1) < 12).sum() >= least)


def settle(page) -> None:
    page.evaluate("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")


def test_replay_plays_from_disk_and_stops_at_the_end(opened, screenshot):
    page = opened(at("ours"))
    assert page.inner_text("#heading") == "town01-0"
    assert clock(page) == 0.0
    first = painted(page)
    assert has_colour(first, (255, 210, 31)), "the ego"
    assert has_colour(first, (90, 95, 102), least=10_000), "the road under it"
    page.select_option("#speed", "2")
    page.click("#play")
    assert page.inner_text("#play") == "Pause"
    page.wait_for_selector("#play:text-is('Play')")
    assert clock(page) == 4.0
    assert (painted(page) != first).any()
    assert page.inner_text("#live") == "The end."
    screenshot(page, "replay")


def test_list_key_and_timeline_jump_to_infractions(opened, screenshot):
    page = opened(at("ours"))
    page.get_by_role("button", name=re.compile("Collision with a car")).click()
    assert clock(page) == HIT_AT
    assert "Collision with a car" in page.inner_text("#live")
    assert page.locator("[aria-current=true]").count() == 1
    now = page.inner_text(".now")
    assert "29 of 50 km/h" in now
    assert "16 of 1126 m" in now
    assert "truck 3" in now
    settle(page)
    assert has_colour(painted(page), (210, 31, 31)), "the mark where it happened"
    screenshot(page, "replay_infraction")
    page.keyboard.press("n")
    assert clock(page) == 3.0
    page.keyboard.press("p")
    assert clock(page) == HIT_AT
    page.keyboard.press("End")
    page.keyboard.press("p")
    assert clock(page) == 3.0, "the nearest one before"
    page.keyboard.press("n")
    assert page.inner_text("#live") == "No infraction after this."
    box = page.locator("#chart").bounding_box()
    inside = box["width"] - 40 - 12
    page.mouse.click(box["x"] + 40 + inside * HIT_AT / 4.0 + 3, box["y"] + 10)
    assert clock(page) == HIT_AT
    page.mouse.click(box["x"] + 40 + inside * 0.9, box["y"] + 50)
    assert clock(page) == pytest.approx(3.6, abs=0.05)
    page.locator("#time").fill("1.5")
    assert clock(page) == 1.5


def test_all_controls_have_a_key(opened):
    page = opened(at("ours"))
    page.keyboard.press("ArrowRight")
    assert clock(page) == pytest.approx(0.1)
    page.keyboard.press("Shift+ArrowRight")
    assert clock(page) == 4.0
    page.keyboard.press("ArrowLeft")
    assert clock(page) == pytest.approx(3.9)
    page.keyboard.press("Home")
    assert clock(page) == 0.0
    page.keyboard.press("]")
    assert page.input_value("#speed") == "2"
    page.keyboard.press("[")
    page.keyboard.press("[")
    assert page.input_value("#speed") == "0.5"
    page.keyboard.press("f")
    assert page.get_attribute("#follow", "aria-pressed") == "false"
    settle(page)
    before = painted(page)
    page.keyboard.press("+")
    settle(page)
    assert (painted(page) != before).any()
    page.keyboard.press("?")
    assert page.locator("#help").is_visible()
    page.keyboard.press("Escape")
    assert not page.locator("#help").is_visible()
    page.keyboard.press("Space")
    assert page.inner_text("#play") == "Pause"
    page.keyboard.press("Space")
    assert page.inner_text("#play") == "Play"


def test_two_planners_play_side_by_side_in_sync(opened, screenshot):
    page = opened(at("ours"))
    page.wait_for_selector("#compare-group:not([hidden])")
    assert page.locator("#compare option").all_inner_texts()[:2] == ["no other", "theirs (DS 21.0)"]
    page.select_option("#compare", label="theirs (DS 21.0)")
    page.wait_for_selector(".stage:nth-child(2)")
    page.keyboard.press("n")
    settle(page)
    assert clock(page) == HIT_AT
    panels = page.locator(".panel")
    assert "Attends to" in panels.nth(0).inner_text()
    assert "vehicle ahead: car 1" in panels.nth(1).inner_text()
    assert has_colour(painted(page, 0), (255, 59, 48)), "the box of whom it attends to"
    assert has_colour(painted(page, 1), BLUE), "the box of whom the expert would brake for"
    assert "would brake for truck 3" in panels.nth(1).inner_text()
    assert "from 1.9 s on the ego differs." in panels.nth(1).inner_text()
    assert not has_colour(painted(page, 1), (255, 59, 48))
    screenshot(page, "replay_beside")
    page.keyboard.press("n")
    settle(page)
    assert not has_colour(painted(page, 1), BLUE, least=1), "its own reason is not blue"
    assert "Expert\nnot known" in panels.nth(1).inner_text()
    page.select_option("#compare", "")
    page.wait_for_selector(".stage:nth-child(2)", state="detached")


def test_comparing_different_scenarios_shows_a_note(opened):
    page = opened(at("ours", "old"))
    assert "different scenarios" in page.inner_text("#about")


def test_dragging_pans_and_follow_returns_to_the_ego(opened):
    page = opened(at("ours"))
    settle(page)
    before = painted(page)
    box = page.locator(".stage canvas").bounding_box()
    page.mouse.move(box["x"] + 200, box["y"] + 200)
    page.mouse.down()
    page.mouse.move(box["x"] + 260, box["y"] + 150)
    page.mouse.up()
    settle(page)
    assert page.get_attribute("#follow", "aria-pressed") == "false"
    assert (painted(page) != before).any()
    page.click("#follow")
    settle(page)
    assert (painted(page) == before).all()


def test_untrusted_text_is_shown_and_not_executed(opened):
    page = opened(at("hostile"))
    assert page.locator("img").count() == 0
    assert page.inner_text(".name").startswith("</script><img src=x")
    assert "</script><img" in page.inner_text(".note >> nth=0")


def test_missing_or_broken_replays_show_a_message(chromium, site):
    context = chromium.new_context()
    page = context.new_page()
    words = {
        at("thin"): "is thinned",
        at("nobody"): "is missing. Create the replays again",
        at("broken"): "is broken. Delete it",
        "#../../etc/passwd": "This address does not belong to a replay",
        "#ours/%E0%A4%A": "This address does not belong to a replay",
    }
    for address, told in words.items():
        page.goto("about:blank")
        page.goto((site / "replay.html").as_uri() + address)
        page.wait_for_selector("#message.bad")
        assert told in page.inner_text("#message"), address
        assert not page.locator("#player").is_visible()
    context.close()


def test_page_without_an_address_lists_the_replays(opened):
    page = opened("")
    page.get_by_role("link", name="theirs, town01-0, repetition 0").click()
    page.wait_for_selector(".stage")
    assert page.inner_text("#heading") == "town01-0"


@pytest.mark.parametrize("dark", [False, True])
@pytest.mark.parametrize("runs", [("ours",), ("ours", "theirs")])
def test_page_has_no_serious_accessibility_violation(opened, faults, screenshot, dark, runs):
    page = opened(at(*runs), dark=dark)
    page.wait_for_selector("#compare-group:not([hidden])")
    page.keyboard.press("n")
    assert faults(page) == []
    page.keyboard.press("?")
    assert faults(page) == []
    screenshot(page, f"replay_help_{dark}_{len(runs)}")


def test_page_fits_a_phone_without_horizontal_scrolling(opened, sideways, faults, screenshot):
    page = opened(at("ours", "theirs"), size=PHONE)
    page.wait_for_selector("#compare-group:not([hidden])")
    assert sideways(page) <= 0
    assert faults(page) == []
    screenshot(page, "replay_phone")


def test_theme_switches_between_dark_and_light(opened):
    page = opened(at("ours"))
    settle(page)
    light = painted(page).mean()
    page.click("#theme")
    settle(page)
    assert painted(page).mean() < light - 40
