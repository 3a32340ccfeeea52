"""Writes a starter project for a planner from the templates beside this file."""

import importlib.util
import keyword
import re
import shutil
import tempfile
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from string import Template

from plant_bench.errors import InputError

TEMPLATES = Path(__file__).with_name("templates")
SUFFIX = ".tmpl"
PACKAGE = "package"  # template folder that is renamed to the planner's name
_NAME = re.compile(r"[a-z][a-z0-9_]{0,49}")


class Kind(StrEnum):
    """Kind of planner that the project starts with."""

    RULES = "rules"
    TORCH = "torch"


@dataclass(frozen=True)
class Project:
    """A project written to disk.

    Attributes:
        folder: Folder of the project.
        files: Paths of its files, relative to the folder.
        spec: Name by which `load_agent` loads the planner without installing the project.
    """

    folder: Path
    files: tuple[Path, ...]
    spec: str


def write_project(name: str, parent: Path, kind: Kind) -> Project:
    """Write a project into a new folder of that name, completely or not at all.

    Raises:
        InputError: The name cannot be used, or the folder exists.
    """
    check_name(name)
    folder = parent / name
    if folder.exists() or folder.is_symlink():
        message = f"{folder} exists already. Choose another name, or another folder with --out."
        raise InputError(message)
    if not parent.is_dir():
        message = f"There is no folder {parent}. Create it, or choose another one with --out."
        raise InputError(message)
    values = _template_values(name, kind)
    with tempfile.TemporaryDirectory(dir=parent, prefix=f".{name}-") as draft:
        whole = Path(draft) / name
        for part in ("shared", kind.value):
            _fill(TEMPLATES / part, whole, values)
        shutil.move(whole, folder)
    files = tuple(sorted(path.relative_to(folder) for path in folder.rglob("*") if path.is_file()))
    return Project(folder, files, f"{folder / name / 'agent.py'}:{values['class_name']}")


def check_name(name: str) -> None:
    """Check that a name is usable for the package and the planner.

    Raises:
        InputError: It is not a valid package name, or is already in use.
    """
    if not _NAME.fullmatch(name) or keyword.iskeyword(name):
        near = re.sub(r"\W+", "_", name.lower()).strip("_")
        near = f" Try {near}." if _NAME.fullmatch(near) and near != name else ""
        message = (
            f"'{name}' is not a valid package name: expected lowercase letters, digits and _, "
            f"beginning with a letter, and not a Python keyword.{near}"
        )
        raise InputError(message)
    from plant_bench.agents.loading.planner_spec import AGENTS

    if name.replace("_", "-") in AGENTS:
        message = f"'{name}' is a built-in planner. Choose another name."
        raise InputError(message)
    module = importlib.util.find_spec(name)
    if module is not None and module.origin is not None:
        message = f"There is already an installed package '{name}'. Choose another name."
        raise InputError(message)


def _template_values(name: str, kind: Kind) -> dict[str, str]:
    learned = kind is Kind.TORCH
    return {
        "package": name,
        "class_name": _class_name(name),
        "more_dependencies": ', "torch", "safetensors"' if learned else "",
        "network_note": (
            f"\nThe network is untrained: `python -m {name}.train DATA` trains it on data of "
            "`plant-bench collect`."
        )
        * learned,
    }


def _class_name(name: str) -> str:
    """Return a class name that does not clash with names used in the templates.

    >>> _class_name("my_planner"), _class_name("control")
    ('MyPlanner', 'ControlPlanner')
    """
    camel = "".join(part.capitalize() for part in name.split("_"))
    texts = [path.read_text("utf-8") for path in TEMPLATES.rglob(f"*.py{SUFFIX}")]
    taken = any(re.search(rf"\b{camel}\b", text) for text in texts)
    return f"{camel}Planner" if taken else camel


def _fill(template: Path, folder: Path, values: dict[str, str]) -> None:
    from plant_bench.atomic_files import write_whole_text

    for path in sorted(template.rglob(f"*{SUFFIX}")):
        relative = path.relative_to(template).with_suffix("")
        parts = [values["package"] if part == PACKAGE else part for part in relative.parts]
        target = folder.joinpath(*parts)
        write_whole_text(target, Template(path.read_text("utf-8")).substitute(values))
