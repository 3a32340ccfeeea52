"""Check a release's tag, and print the changelog's section on it.

    python .ci/release_notes.py v1.2.3

The version must be the same in the tag, in plant_bench/__init__.py and in CITATION.cff, and have a
section in CHANGELOG.md. Exit code 2 and one line where that is not so.
"""

import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
STATED = {
    "plant_bench/__init__.py": r'^__version__ = "(.+)"$',
    "CITATION.cff": r'^version: "?([^"\n]+)"?$',
}


def release_notes(tag: str, root: Path = ROOT) -> str:
    """Return the text of a version's section in CHANGELOG.md, without its heading.

    Args:
        tag: `v` and the version.
        root: The folder of the checkout.

    Raises:
        ValueError: The tag has another form, or a file states another version or none.
    """
    form = re.fullmatch(r"v(\d+\.\d+\.\d+\S*)", tag)
    if form is None:
        message = f"expected a tag such as v1.2.3, got {tag!r}"
        raise ValueError(message)
    version = form[1]
    for name, pattern in STATED.items():
        found = re.search(pattern, (root / name).read_text(encoding="utf-8"), re.MULTILINE)
        stated = found[1] if found else "no version"
        if stated != version:
            message = f"{name}: expected version {version} as in the tag {tag}, got {stated}"
            raise ValueError(message)
    changelog = (root / "CHANGELOG.md").read_text(encoding="utf-8")
    heading = rf"^## \[{re.escape(version)}\].*\n((?:(?!^## |^\[[^\]]+\]: ).*\n?)*)"
    section = re.search(heading, changelog, re.MULTILINE)
    if section is None or not section[1].strip():
        message = f"CHANGELOG.md: expected a section '## [{version}]' with text, found none"
        raise ValueError(message)
    return section[1].strip() + "\n"


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit("usage: release_notes.py TAG")
    try:
        sys.stdout.write(release_notes(sys.argv[1]))
    except ValueError as error:
        sys.stderr.write(f"Error: {error}\n")
        sys.exit(2)
