"""Benchmark: size and opening time of the leaderboard page with many planners.

    python benchmarks/leaderboard_page.py reports/plant-longest6 reports/expert-longest6

Copies of real records under other names stand for further planners, with three repetitions each.
The page is opened from disk in Chromium, offline; the median time until it is drawn is printed.
"""

import argparse
import shutil
import statistics
import tempfile
from pathlib import Path

from playwright.sync_api import Browser, sync_playwright

from plant_bench.reports.leaderboard.board_builder import make_leaderboard
from plant_bench.reports.leaderboard.leaderboard_page import write_page
from plant_bench.reports.leaderboard.score_sources import find_sources, read_run
from plant_bench.scoring.penalties import PenaltyScheme

REPETITIONS = 3
LARGEST_MB, SLOWEST_S = 3.0, 1.0


def main() -> None:
    """Run the command line."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("runs", nargs="+", type=Path, help="runs with at least three repetitions")
    parser.add_argument("--planners", type=int, default=12)
    parser.add_argument("--times", type=int, default=7)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        runs = [
            relabelled(arguments.runs[number % len(arguments.runs)], folder / str(number), number)
            for number in range(arguments.planners)
        ]
        sources = find_sources(runs, below=folder)
        made = make_leaderboard(
            sources, penalties=PenaltyScheme.LB1_0, paper=True, progress=lambda _: None
        )
        page = write_page(made, folder, replays=True)
        episodes = sum(line.episodes for line in made.boards[0].rows)
        size = page.stat().st_size / 1e6
        print(f"{len(runs)} planners, {episodes} episodes: {size:.2f} MB (target {LARGEST_MB})")
        with sync_playwright() as playwright:
            path = shutil.which("chromium")
            browser = playwright.chromium.launch(executable_path=path, args=["--no-sandbox"])
            times = [opening_time(browser, page) for _ in range(arguments.times)]
            browser.close()
        middle = statistics.median(times)
        print(f"opens in {middle:.2f} s (target {SLOWEST_S}), slowest {max(times):.2f} s")


def relabelled(run: Path, target: Path, number: int) -> Path:
    """Copy a run's records under the name of another planner."""
    source = read_run(run)
    name, checksum = f"{source.provenance.agent}-{number}", f"{number:064x}"
    facts = {"agent": name, "agent_checksum": checksum}
    for part in ("episodes", "recordings"):
        (target / part).mkdir(parents=True)
    for item in source.episodes:
        if item.result.repetition < REPETITIONS:
            record = item.result.model_copy(update=facts)
            (target / "episodes" / f"{item.name}.json").write_text(record.to_json())
            (target / "recordings" / f"{item.name}.parquet").touch()
    note = source.provenance.model_copy(update={**facts, "repetitions": REPETITIONS})
    (target / "run.json").write_text(note.model_dump_json())
    return target


def opening_time(browser: Browser, page: Path) -> float:
    """Return seconds from the start of the navigation until the page is drawn."""
    context = browser.new_context(viewport={"width": 1280, "height": 900})
    context.set_offline(True)
    tab = context.new_page()
    tab.goto(page.as_uri())
    tab.wait_for_function("performance.getEntriesByName('drawn').length > 0")
    seconds = tab.evaluate("performance.getEntriesByName('drawn')[0].startTime / 1000")
    context.close()
    return float(seconds)


if __name__ == "__main__":
    main()
