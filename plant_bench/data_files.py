"""Where networks, routes and models live: beside the package, or inside it in a wheel."""

from pathlib import Path

from plant_bench.errors import InputError

_PACKAGE = Path(__file__).resolve().parent


def _data_dir(name: str) -> Path:
    for candidate in (_PACKAGE / "_data" / name, _PACKAGE.parent / name):
        if candidate.is_dir():
            return candidate
    message = (
        f"The folder '{name}' was not found beside or inside {_PACKAGE}. "
        "Install plant-bench again: its wheel carries networks, routes and models."
    )
    raise InputError(message)


def networks_dir() -> Path:
    """Return the folder with one sub-folder for each town.

    Raises:
        InputError: The installation is incomplete.
    """
    return _data_dir("networks")


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
