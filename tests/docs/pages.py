"""The README and the pages of docs/, and what is in them."""

import re
import shlex
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
PAGES = [ROOT / "README.md", *sorted(DOCS.rglob("*.md"))]
FENCE = re.compile(r"^```(\w*)\n(.*?)^```", re.MULTILINE | re.DOTALL)
SEPARATORS = {"&&", "||", ";", "|", "&", ">", "<", "do", "done", "(", ")"}


@dataclass(frozen=True)
class Block:
    """A block of commands.

    Attributes:
        page: The page, relative to the repository.
        line: Of the page, on which it starts.
        text: Its commands.
    """

    page: str
    line: int
    text: str

    @property
    def lines(self) -> list[str]:
        """Its lines, continued ones joined, without comments and empty ones."""
        joined = self.text.replace("\\\n", " ").splitlines()
        return [line.strip() for line in joined if line.strip() and not line.startswith("#")]


def page_name(page: Path) -> str:
    return page.relative_to(ROOT).as_posix()


def blocks_of(page: Path, language: str = "bash") -> list[Block]:
    text = page.read_text(encoding="utf-8")
    return [
        Block(page_name(page), text.count("\n", 0, found.start()) + 1, found[2])
        for found in FENCE.finditer(text)
        if found[1] == language
    ]


def commands_in(line: str) -> Iterator[list[str]]:
    """Give the arguments of each `plant-bench` in a line of shell."""
    lexer = shlex.shlex(line, posix=True, punctuation_chars=True)
    lexer.whitespace_split = True
    words: list[str] = []
    for word in [*lexer, ";"]:
        if word not in SEPARATORS:
            words.append(word)
            continue
        if words and words[0].rsplit("/", 1)[-1] == "plant-bench":
            yield words[1:]
        words = []
