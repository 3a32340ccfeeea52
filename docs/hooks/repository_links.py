"""Lets pages link to files of the repository that are outside docs/.

On a code host such links work as they are. In the site a linked Markdown file becomes a page, and
any other file is copied.
"""

import os
import re
from collections.abc import Iterator
from pathlib import Path

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files
from mkdocs.structure.pages import Page

FOLDER = "repository"  # of the site, where such files are
LINK = re.compile(r"(\]\()([^)#:\s]+)((?:#[^)\s]*)?\))")
FENCE = re.compile(r"^```.*?^```", re.MULTILINE | re.DOTALL)


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the files that pages link to, and those that these link to."""
    root = Path(config.docs_dir).parent
    waiting = [file for file in files.documentation_pages() if not file.generated_by]
    while waiting:
        file = waiting.pop()
        for path in _linked(file, root):
            uri = f"{FOLDER}/{path}"
            if files.get_file_from_path(uri) is not None:
                continue
            if path.endswith(".md"):
                added = File.generated(config, uri, content=(root / path).read_text("utf-8"))
                waiting.append(added)
            else:
                added = File.generated(config, uri, content=(root / path).read_bytes())
            files.append(added)
    return files


def on_page_markdown(markdown: str, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Let links to such files lead to where they are in the site."""
    del files
    root = Path(config.docs_dir).parent
    here = _source(page.file)

    def changed(found: re.Match[str]) -> str:
        path = _target(here, found[2])
        if not (root / path).exists() or found[2].startswith("/"):
            return found[0]
        inside = path.removeprefix("docs/") if path.startswith("docs/") else f"{FOLDER}/{path}"
        link = os.path.relpath(inside, os.path.dirname(page.file.src_uri))  # noqa: PTH120
        return f"{found[1]}{link}{found[3]}"

    pieces, start = [], 0
    for fence in FENCE.finditer(markdown):
        pieces += [LINK.sub(changed, markdown[start : fence.start()]), fence[0]]
        start = fence.end()
    return "".join([*pieces, LINK.sub(changed, markdown[start:])])


def _linked(file: File, root: Path) -> Iterator[str]:
    here = _source(file)
    for found in LINK.finditer(FENCE.sub("", file.content_string)):
        path = _target(here, found[2])
        if not path.startswith(("docs/", "..")) and (root / path).is_file():
            yield path


def _source(file: File) -> str:
    """Return a page's path in the repository."""
    if file.src_uri.startswith(f"{FOLDER}/"):
        return file.src_uri.removeprefix(f"{FOLDER}/")
    return f"docs/{file.src_uri}"


def _target(here: str, link: str) -> str:
    return os.path.normpath(os.path.join(os.path.dirname(here), link))  # noqa: PTH118, PTH120
