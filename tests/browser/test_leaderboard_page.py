"""The leaderboard in a browser: from disk, offline, with mouse and keyboard."""

import json

import pytest

from plant_bench.reports.carla_checkpoint_writing import checkpoint
from plant_bench.reports.leaderboard.board_builder import make_leaderboard
from plant_bench.reports.leaderboard.leaderboard_page import write_page
from plant_bench.reports.leaderboard.score_sources import find_sources, read_run
from plant_bench.scoring import metrics_table
from plant_bench.scoring.aggregation import RunAggregate, median
from plant_bench.scoring.metrics_table import LOWER, METRICS, measure_row, score_row
from plant_bench.scoring.penalties import PenaltyScheme

HOSTILE = "</script><img src=x onerror=alert(1)><b>😀 \u202e" + "x" * 10_000
DRILL_DOWNS = 9  # with own runs and without rankings
DESKTOP, PHONE = (1280, 900), (390, 844)


@pytest.fixture
def board(tmp_path, write_run):
    """A page with four planners (the last with a hostile name), another protocol and the paper."""
    planners = {"steady": 40, "careless": 1, "middling": 2, HOSTILE: 3}
    runs = [
        write_run(tmp_path / f"run{n}", name, worse=worse, routes=8, recorded=True, reason=name)
        for n, (name, worse) in enumerate(planners.items())
    ]
    runs.append(write_run(tmp_path / "old", "steady", protocol="longest6-sumo-v0"))
    runs.append(foreign_checkpoint(runs[1], tmp_path / "<b>another simulator&.json"))
    sources = find_sources(runs, below=tmp_path)
    made = make_leaderboard(
        sources, penalties=PenaltyScheme.LB1_0, paper=True, progress=lambda _: None
    )
    return write_page(made, tmp_path / "out", replays=True)


def foreign_checkpoint(run, path):
    """Write a run as a checkpoint file of another program."""
    results = [item for item in read_run(run).results if item.repetition == 0]
    numbers = {item.route: number for number, item in enumerate(results)}
    made = checkpoint(results, numbers=numbers, expected=len(results), walls={})
    content = json.loads(json.dumps(made))
    for item in content["_checkpoint"]["records"]:
        del item["plant_bench"]
    path.write_text(json.dumps(content), encoding="utf-8")
    return path


@pytest.fixture
def more_metrics(monkeypatch):
    """Add a score and an episode metric by their rows alone."""
    seconds = measure_row(
        "jerk_p95", "least jerk", "m/s³", 2, LOWER, median, "Least jerk.", name="least_jerk"
    )
    count = RunAggregate("episodes", lambda results, _: float(len(results)))
    episodes = score_row("count", "COUNT", "", 0, LOWER, count, "How many episodes.")
    monkeypatch.setattr(metrics_table, "METRICS", (*METRICS, episodes, seconds))


def planners(page, section=0):
    cells = page.locator("section.board").nth(section).locator("table").first.locator("tbody th")
    return [text[:8] for text in cells.all_inner_texts()]


def test_page_names_the_leader_and_separates_protocols(board, open_page, screenshot):
    page = open_page(board)
    assert "steady leads" in page.locator(".verdict").first.inner_text()
    assert "The difference is not significant" in page.locator(".verdict").first.inner_text()
    page.locator("#board-0-matrix > summary").click()
    against = page.locator("#board-0-matrix tbody tr").first.locator("td").all()
    assert [cell.get_attribute("class") for cell in against] == ["same", "even", "ahead", "ahead"]
    assert page.locator("section.board").count() == 4
    for place in range(2):
        assert "another simulator" in page.locator("section.elsewhere").nth(place).inner_text()
    assert [len(planners(page, place)) for place in range(4)] == [4, 1, 1, 9]
    screenshot(page, "leaderboard-light")


def test_clicking_a_column_sorts_ascending_and_descending(board, open_page):
    page = open_page(board)
    table = page.locator("section.board").first.locator("table").first
    assert planners(page)[0] == "steady"
    heads = table.locator("button.sort")
    for place in range(heads.count()):
        heads.nth(place).click()
        first = table.locator("th[aria-sort]").get_attribute("aria-sort")
        heads.nth(place).click()
        assert table.locator("th[aria-sort]").get_attribute("aria-sort") != first
    heads.nth(0).click()
    names = planners(page)
    heads.nth(0).click()
    assert planners(page) == names[::-1] != names


def test_new_metrics_appear_as_columns(more_metrics, board, open_page):
    page = open_page(board)
    table = page.locator("section.board").first.locator("table").first
    heads = [text.strip("↑↓\n") for text in table.locator("thead th").all_inner_texts()]
    place = heads.index("COUNT")
    assert heads[place - 1] == "CV"
    button = table.locator("button.sort").nth(place)
    assert button.get_attribute("title") == "How many episodes."
    button.click()
    assert table.locator("th[aria-sort]").get_attribute("aria-sort") == "ascending"
    assert table.locator("tbody tr").first.locator("th, td").nth(place).inner_text() == "8 ± 0"
    elsewhere = page.locator("section.elsewhere tbody tr").first.locator("th, td").nth(place)
    assert elsewhere.inner_text() == "–"
    assert "How many episodes." in page.locator("#legend").inner_text()
    page.locator("#board-0-comfort > summary").click()
    comfort = page.locator("#board-0-comfort table")
    assert comfort.locator("thead th").last.inner_text().split("\n") == ["least jerk", "m/s³"]
    assert comfort.locator("tbody tr").first.locator("td").last.inner_text() == "3.25"


def test_columns_match_the_metrics_table(board, open_page):
    page = open_page(board)
    table = page.locator("section.board").first.locator("table").first
    heads = [text.strip("↑↓\n") for text in table.locator("thead th").all_inner_texts()]
    assert heads[1:7] == ["DS", "RC", "IS", "CV", "IT ms", "RFDS"]
    page.get_by_role("button", name="careless").first.click()
    episodes = page.locator("#board-0-episodes table")
    heads = episodes.locator("thead th").all_inner_texts()
    assert heads[2:6] == ["DS", "RC", "IS", "Time"]
    worst = episodes.locator("tbody tr").first.locator("th, td").all_inner_texts()
    assert worst[2:6] == ["60.0", "100.0", "0.60", "1:40"]


def test_rows_filter_by_text_track_town_and_table(board, open_page):
    page = open_page(board)
    page.fill("#filter-text", "care")
    assert planners(page) == ["careless"]
    assert "1 of" in page.locator("#filter-count").inner_text()
    page.fill("#filter-text", "")
    page.select_option("#filter-track", "sensors")
    assert planners(page) == []
    assert len(planners(page, 3)) == 3
    page.select_option("#filter-track", "")
    cell = page.locator("section.board").first.locator("tbody tr td").first
    whole = cell.inner_text()
    page.select_option("#filter-town", "town01")
    assert cell.inner_text() != whole
    page.select_option("#filter-board", "board-2")
    assert page.locator("section.board:visible").count() == 1


def test_all_controls_work_with_the_keyboard(board, open_page, screenshot):
    page = open_page(board)
    opened = set()
    for _ in range(200):
        page.keyboard.press("Tab")
        summary = page.evaluate(
            "document.activeElement.matches('section.board:first-child .drill > summary')"
            " ? document.activeElement.parentElement.id : ''"
        )
        if summary and summary not in opened:
            opened.add(summary)
            page.keyboard.press("Enter")
            page.locator(f"#{summary} .body *").first.wait_for(state="attached")
        if len(opened) == DRILL_DOWNS:
            break
    assert len(opened) == DRILL_DOWNS
    page.locator("#board-0-routes td button").first.focus()
    page.keyboard.press("ArrowRight")
    page.keyboard.press("ArrowDown")
    label = page.evaluate("document.activeElement.getAttribute('aria-label')")
    assert "town01-2" in label
    page.keyboard.press("Enter")
    routes = page.locator("#board-0-episodes tbody tr td:nth-child(2)").all_inner_texts()
    assert len(routes) == 2
    assert all(text.startswith("town01-2") for text in routes)
    screenshot(page, "leaderboard-episodes")


def test_two_planners_are_compared_side_by_side(board, open_page, screenshot):
    page = open_page(board)
    page.get_by_role("button", name="careless").first.click()
    row = page.locator("#board-0-episodes tbody tr").first
    assert row.get_by_role("link").get_attribute("href").startswith("replay.html#careless/town0")
    row.get_by_role("button", name="Compare").click()
    picks = page.locator("#picks")
    assert picks.is_visible()
    picks.get_by_role("button", name="steady").click()
    first, second = (
        picks.get_by_role("link").get_attribute("href").removeprefix("replay.html#").split("&")
    )
    assert (first.split("/")[0], second.split("/")[0]) == ("careless", "steady")
    assert first.split("/")[1] == second.split("/")[1]
    screenshot(page, "leaderboard-compare")
    picks.get_by_role("button", name="Clear").click()
    assert picks.is_hidden()


def open_all(page):
    for part in page.locator("details.drill").all():
        part.evaluate("part => { part.open = true; }")
    page.wait_for_timeout(200)


@pytest.mark.parametrize("dark", [False, True], ids=["light", "dark"])
@pytest.mark.parametrize("size", [DESKTOP, PHONE], ids=["desktop", "phone"])
def test_page_is_accessible_and_fits_the_window(
    board, open_page, faults, sideways, screenshot, size, dark
):
    page = open_page(board, size=size, dark=dark)
    shown = page.evaluate("getComputedStyle(document.body).backgroundColor")
    assert (shown == "rgb(20, 23, 27)") == dark
    open_all(page)
    assert sideways(page) <= 0
    assert faults(page) == []
    window, theme = "phone" if size == PHONE else "desktop", "dark" if dark else "light"
    screenshot(page, f"leaderboard-{window}-{theme}")


def test_no_label_of_a_plot_is_cut_off_on_a_phone(board, open_page):
    page = open_page(board, size=PHONE)
    open_all(page)

    labels, cut = page.evaluate(
        """() => {
            const texts = [...document.querySelectorAll(".plot svg text")];
            const outside = texts.filter((text) => {
                const inner = text.getBoundingClientRect();
                const outer = text.closest(".plot").getBoundingClientRect();
                const aside = inner.left < outer.left - 1 || inner.right > outer.right + 1;
                return inner.width && (aside || inner.bottom > outer.bottom + 1);
            });
            return [texts.length, outside.map((text) => text.textContent)];
        }"""
    )

    assert labels > 10
    assert cut == []


def test_repetitions_are_counted_from_zero(board, open_page):
    page = open_page(board)
    open_all(page)

    shown = page.locator("#board-0-episodes tbody tr td:nth-child(2)").first.inner_text()
    assert "repetition 0" in shown


def test_theme_switch_changes_the_theme(board, open_page):
    page = open_page(board)
    before = page.evaluate("getComputedStyle(document.body).backgroundColor")
    page.click("#theme")
    assert page.evaluate("getComputedStyle(document.body).backgroundColor") != before
    assert page.locator("#theme").inner_text() == "Light mode"


def test_untrusted_names_are_rendered_as_text(board, open_page):
    """All text is shown and none is executed: a dialog or an error would fail the test."""
    page = open_page(board)
    open_all(page)
    assert page.locator("img").count() == 0
    assert page.get_by_text("<b>another simulator&", exact=True).count() > 0
    assert page.locator("section.board").first.get_by_text("</script><img").count() > 0
    assert (
        page.locator("body *").evaluate_all(
            "all => all.filter((item) => item.children.length === 0 && item.tagName !== 'SCRIPT'"
            " && item.textContent.length > 1000).length"
        )
        == 0
    )
