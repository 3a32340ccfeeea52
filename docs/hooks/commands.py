"""Writes the site's page of commands from the commands themselves.

The page has no file in the repository: `mkdocs build` makes it.
"""

from collections.abc import Iterator
from typing import Any

import typer
from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files

PAGE = "reference/commands.md"
HEAD = """# Commands

This page is generated from the commands' own help when the site is built.
The same text is printed by `plant-bench COMMAND --help`.

Exit codes: 0 success, 1 a difference or a failure, 2 unusable input, 130 interrupted.
"""
OTHERS = """In place of `plant` name a learner of your own, `package.module:Class` or
`file.py:Class`. The command then has the options of that learner
([how to write one](../notes/learning.md#bring-a-learner)).
"""


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the generated page."""
    files.append(File.generated(config, PAGE, content=commands_page()))
    return files


def commands_page() -> str:
    """Return the page: a section for each command, in the order of `plant-bench --help`."""
    from plant_bench.cli import app

    root: Any = typer.main.get_command(app)
    context = root.make_context("plant-bench", [], resilient_parsing=True)
    return "\n".join([HEAD, *_sections(root, context)])


def _sections(group: Any, context: Any) -> Iterator[str]:
    for name in group.list_commands(context):
        command = group.get_command(context, name)
        if command is None or command.hidden:
            continue
        inner = command.make_context(name, [], parent=context, resilient_parsing=True)
        if hasattr(command, "list_commands"):
            yield f"## {inner.command_path}\n\n{command.help or ''}\n"
            if inner.command_path == "plant-bench train":
                yield OTHERS
            yield from _sections(command, inner)
        else:
            yield from _section(command, inner)


def _section(command: Any, context: Any) -> Iterator[str]:
    level = "##" if context.parent.parent is None else "###"
    yield f"{level} {context.command_path}\n"
    yield f"{command.help or ''}\n"
    usage = " ".join(command.collect_usage_pieces(context))
    yield f"```text\n{context.command_path} {usage}\n```\n"
    records = [item.get_help_record(context) for item in command.get_params(context)]
    rows = [(_code(names), _cell(text)) for names, text in filter(None, records)]
    yield "| argument or option | meaning |\n|---|---|"
    yield from (f"| {names} | {text} |" for names, text in rows)
    yield ""


def _code(text: str) -> str:
    return f"`{_cell(text)}`"


def _cell(text: str) -> str:
    return " ".join(text.split()).replace("|", "\\|")
