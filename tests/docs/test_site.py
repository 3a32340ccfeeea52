"""The pages as a site: links lead somewhere, and the site builds."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

from tests.docs.pages import DOCS, FENCE, PAGES, ROOT, page_name

LINK = re.compile(r"\]\(([^)\s]+)\)")
ELSEWHERE = ("http://", "https://", "mailto:")
GENERATED = {DOCS / "reference" / "commands.md"}  # by docs/hooks/commands.py
LINKING = [
    *PAGES,
    *(ROOT / name for name in ("CONTRIBUTING.md", "CHANGELOG.md", "benchmarks/README.md")),
    *sorted(ROOT.glob("models/**/*.md")),
]


def links(page: Path) -> list[tuple[Path, str]]:
    """Return where the relative links of a page lead: files and anchors."""
    text = FENCE.sub("", page.read_text(encoding="utf-8"))
    found = []
    for link in LINK.findall(text):
        if not link.startswith(ELSEWHERE):
            path, _, anchor = link.partition("#")
            found.append(((page.parent / path).resolve() if path else page, anchor))
    return found


def anchors(page: Path) -> set[str]:
    """Return the anchors of a page's headings, as Python-Markdown and code hosts make them."""
    text = FENCE.sub("", page.read_text(encoding="utf-8"))
    names = set()
    for heading in re.findall(r"^#+ (.*)$", text, re.MULTILINE):
        plain = re.sub(r"[^\w\s-]", "", heading.replace("`", "")).strip().lower()
        names.add(re.sub(r"[\s-]+", "-", plain))
    return names


@pytest.mark.parametrize("page", LINKING, ids=page_name)
def test_relative_links_lead_somewhere(page: Path) -> None:
    broken = [
        f"{path}#{anchor}"
        for path, anchor in links(page)
        if path not in GENERATED
        and (not path.exists() or (anchor and path.suffix == ".md" and anchor not in anchors(path)))
    ]

    assert broken == []


def test_there_are_links() -> None:
    assert sum(len(links(page)) for page in PAGES) > 50


@pytest.mark.slow
@pytest.mark.timeout(900)
def test_the_site_builds(tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-m", "mkdocs", "build", "--strict", "--site-dir", str(tmp_path / "site")],
        cwd=ROOT, capture_output=True, text=True, check=False,
    )  # fmt: skip

    assert done.returncode == 0, done.stderr
    commands = (tmp_path / "site" / "reference" / "commands.html").read_text(encoding="utf-8")
    for part in ("plant-bench score", "--repetitions", "plant-bench train plant", "--epochs"):
        assert part in commands
    python = (tmp_path / "site" / "reference" / "python.html").read_text(encoding="utf-8")
    assert "Base seed of the traffic" in python, "taken from a docstring"
