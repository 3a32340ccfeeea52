"""Pages in a real browser: Chromium, from disk, with the network off.

Without Chromium or Playwright these tests are skipped; PLANT_BENCH_BROWSER=required makes that a
failure. Screenshots go to the folder that PLANT_BENCH_SCREENSHOTS names.
"""

import os
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

AXE = Path(__file__).parent / "axe.min.js"
NAMES = ("chromium", "chromium-browser", "google-chrome")
DESKTOP, PHONE = (1280, 900), (390, 844)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark all tests of this folder."""
    for item in items:
        if Path(__file__).parent in item.path.parents:
            item.add_marker(pytest.mark.browser)


def _lacking(reason: str) -> None:
    if os.environ.get("PLANT_BENCH_BROWSER") == "required":
        pytest.fail(f"{reason}, and PLANT_BENCH_BROWSER=required")
    pytest.skip(f"{reason}: apt-get install chromium, pip install playwright")


@pytest.fixture(scope="session")
def chromium() -> Iterator[Any]:
    """The browser, one for all tests."""
    try:
        from playwright.sync_api import sync_playwright
    except ImportError:
        _lacking("Playwright is not installed")
        return
    found = next((path for name in NAMES if (path := shutil.which(name))), None)
    if found is None:
        _lacking("There is no Chromium")
    arguments = ["--no-sandbox", "--disable-gpu"]
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=found, args=arguments)
        yield browser
        browser.close()


@pytest.fixture
def open_page(chromium: Any) -> Iterator[Callable[..., Any]]:
    """Open a file, offline; the test fails if the page asks the network or reports an error."""
    contexts, troubles = [], []

    def opened(file: Path, *, size: tuple[int, int] = DESKTOP, dark: bool = False, at: str = ""):
        context = chromium.new_context(
            viewport={"width": size[0], "height": size[1]},
            color_scheme="dark" if dark else "light",
            reduced_motion="reduce",
        )
        contexts.append(context)
        context.set_offline(True)
        context.route(
            lambda address: address.startswith(("http:", "https:", "ws:", "wss:")),
            lambda route: (troubles.append(f"asked for {route.request.url}"), route.abort()),
        )
        page = context.new_page()
        page.set_default_timeout(20_000)
        page.on("console", lambda told: told.type == "error" and troubles.append(told.text))
        page.on("pageerror", lambda error: troubles.append(str(error)))
        page.on("dialog", lambda dialog: (troubles.append("a dialog"), dialog.dismiss()))
        page.goto(file.as_uri() + at)
        return page

    yield opened
    for context in contexts:
        context.close()
    assert not troubles


@pytest.fixture
def screenshot() -> Callable[[Any, str], None]:
    """Save a screenshot of a page if PLANT_BENCH_SCREENSHOTS names a folder."""

    def kept(page: Any, name: str) -> None:
        folder = os.environ.get("PLANT_BENCH_SCREENSHOTS")
        if folder:
            Path(folder).mkdir(parents=True, exist_ok=True)
            page.screenshot(path=str(Path(folder) / f"{name}.png"))

    return kept


@pytest.fixture
def faults() -> Callable[[Any], list[str]]:
    """Return the serious and critical violations that axe-core finds on a page."""

    def found(page: Any) -> list[str]:
        page.evaluate(AXE.read_text(encoding="utf-8"))
        result = page.evaluate("axe.run(document, {resultTypes: ['violations']})")
        return [
            f"{item['id']}: {node['target']} {node['failureSummary']}"
            for item in result["violations"]
            if item["impact"] in ("serious", "critical")
            for node in item["nodes"][:3]
        ]

    return found


@pytest.fixture
def sideways() -> Callable[[Any], float]:
    """Return by how many pixels a page is wider than its window."""
    return lambda page: page.evaluate(
        "Math.max(document.documentElement.scrollWidth, document.body.scrollWidth) - innerWidth"
    )
