"""Finds the folders of towns, routes and models, in a source checkout or an installed wheel.

Towns are also found in a folder `towns` inside or beside a suite's folder (each route of the suite
stores these folders), and in the folders of the environment variable PLANT_BENCH_TOWNS (separated
as in PATH).
"""

import os
import re
from collections.abc import Sequence
from pathlib import Path

from plant_bench.errors import InputError

_PACKAGE = Path(__file__).resolve().parent
TOWNS_VARIABLE = "PLANT_BENCH_TOWNS"
TOWNS_FOLDER, ROUTES_FOLDER = "towns", "routes"


def _data_dir(name: str) -> Path:
    for candidate in (_PACKAGE / "_data" / name, _PACKAGE.parent / name):
        if candidate.is_dir():
            return candidate
    message = (
        f"The folder '{name}' was not found beside or inside {_PACKAGE}. "
        "Install plant-bench again: its wheel contains networks, routes and models."
    )
    raise InputError(message)


def networks_dir() -> Path:
    """Return the folder with one sub-folder for each town.

    Raises:
        InputError: The installation is incomplete.
    """
    return _data_dir("networks")


def town_dir(name: str, also_in: Sequence[Path] = ()) -> Path:
    """Return a town's folder, from `networks/`, `also_in` or PLANT_BENCH_TOWNS, in this order.

    Args:
        name: Name of the town.
        also_in: Further folders of towns.

    Raises:
        InputError: There is no such town.
    """
    if not re.fullmatch(r"\w[\w.-]{0,59}", name):
        message = (
            f"'{name[:60]}' is not a valid town name: expected up to 60 letters, digits, '_', '-' "
            "and '.', not beginning with '-' or '.'."
        )
        raise InputError(message)
    folders = [networks_dir(), *also_in, *map(Path, _further())]
    for folder in folders:
        if (folder / name / "town.json").is_file():
            return folder / name
    known = sorted({path.parent.name for folder in folders for path in folder.glob("*/town.json")})
    message = f"There is no town '{name}'. Available towns: {', '.join(known) or 'none'}."
    raise InputError(message)


def _further() -> list[str]:
    return [item for item in os.environ.get(TOWNS_VARIABLE, "").split(os.pathsep) if item]


def make_towns_variable_absolute() -> None:
    """Make the folders of PLANT_BENCH_TOWNS absolute, so that the working folder may change."""
    if folders := _further():
        os.environ[TOWNS_VARIABLE] = os.pathsep.join(str(Path(item).absolute()) for item in folders)


def towns_dirs_of(suite: Path) -> list[Path]:
    """Return the folders in which a suite may include its own towns; they need not exist."""
    folder = suite.resolve()
    return [folder / TOWNS_FOLDER, folder.parent / TOWNS_FOLDER]


def routes_dir() -> Path:
    """Return the folder with one sub-folder for each route suite.

    Raises:
        InputError: The installation is incomplete.
    """
    return _data_dir("routes")


def models_dir() -> Path:
    """Return the folder with the trained weights and their cards.

    Raises:
        InputError: The installation is incomplete.
    """
    return _data_dir("models")
