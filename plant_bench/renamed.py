"""Renamed options and config keys: maps each old name to an error message with the new one."""

from collections.abc import Iterable, Mapping, Sequence
from types import MappingProxyType

OF_LEARNERS = ("train", "ablate")
# Old option: the new one, and the commands that have it.
OPTIONS: Mapping[str, tuple[str, tuple[str, ...]]] = MappingProxyType(
    {
        "--law": ("--penalties", ("score", "rescore", "compare", "report", "rfds")),
        "--meetings": ("--conflicts", OF_LEARNERS),
        "--no-meetings": ("--no-conflicts", OF_LEARNERS),
        "--tracks": ("--motion", OF_LEARNERS),
        "--no-tracks": ("--no-motion", OF_LEARNERS),
        "--foresight": ("--horizon", OF_LEARNERS),
        "--caution": ("--overshoot-weight", OF_LEARNERS),
        "--resting": ("--stationary-fraction", OF_LEARNERS),
    }
)
CONFIG_KEYS: Mapping[str, str] = MappingProxyType(  # of a trained network's config.json
    {"meetings": "conflicts", "tracks": "motion", "foresight": "horizon"}
)


def renamed_option(arguments: Sequence[str]) -> str:
    """Return an error message for the first renamed option; empty if there is none.

    Args:
        arguments: Arguments of the command line, without the program.

    >>> renamed_option(["score", "--law=lb2.1"])
    "The option '--law' of `plant-bench score` is now '--penalties'."
    >>> renamed_option(["score", "--meetings"])
    ''
    """
    for argument in arguments[1:]:
        new, commands = OPTIONS.get(argument.partition("=")[0], ("", ()))
        if arguments[0] in commands:
            old = argument.partition("=")[0]
            return f"The option '{old}' of `plant-bench {arguments[0]}` is now '{new}'."
    return ""


def renamed_keys(keys: Iterable[str]) -> str:
    """Return an error message for the renamed keys of a config; empty if there are none.

    >>> renamed_keys(["reach", "foresight"])
    "'foresight' is now 'horizon': rename it in the file"
    """
    found = [f"'{key}' is now '{CONFIG_KEYS[key]}'" for key in keys if key in CONFIG_KEYS]
    return f"{', '.join(found)}: rename it in the file" if found else ""
