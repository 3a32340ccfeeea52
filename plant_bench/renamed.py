"""Renamed options, config keys and modules: error messages that give the new name of an old one."""

from collections.abc import Iterable, Mapping, Sequence
from itertools import zip_longest
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
VALUES: Mapping[tuple[str, str], str] = MappingProxyType({("--targets", "answer"): "expert-action"})
CONFIG_KEYS: Mapping[str, str] = MappingProxyType(  # of a trained network's config.json
    {"meetings": "conflicts", "tracks": "motion", "foresight": "horizon"}
)
CONSTANTS: Mapping[str, str] = MappingProxyType({"NOBODY": "NO_ACTOR"})  # of plant_bench.agent


def renamed_option(arguments: Sequence[str]) -> str:
    """Return an error message for the first renamed option; empty if there is none.

    Args:
        arguments: Arguments of the command line, without the program.

    >>> renamed_option(["score", "--law=lb2.1"])
    "The option '--law' of `plant-bench score` is now '--penalties'."
    >>> renamed_option(["train", "plant", "--targets", "answer"])
    "The value 'answer' of '--targets' is now 'expert-action'."
    >>> renamed_option(["score", "--meetings"])
    ''
    """
    for argument, following in zip_longest(arguments[1:], arguments[2:], fillvalue=""):
        option, _, value = argument.partition("=")
        new, commands = OPTIONS.get(option, ("", ()))
        if arguments[0] in commands:
            return f"The option '{option}' of `plant-bench {arguments[0]}` is now '{new}'."
        old_value = value or following
        if arguments[0] in OF_LEARNERS and (option, old_value) in VALUES:
            return f"The value '{old_value}' of '{option}' is now '{VALUES[option, old_value]}'."
    return ""


def renamed_keys(keys: Iterable[str]) -> str:
    """Return an error message for the renamed keys of a config; empty if there are none.

    >>> renamed_keys(["reach", "foresight"])
    "'foresight' is now 'horizon': rename it in the file"
    """
    found = [f"'{key}' is now '{CONFIG_KEYS[key]}'" for key in keys if key in CONFIG_KEYS]
    return f"{', '.join(found)}: rename it in the file" if found else ""


def renamed_import(error: BaseException) -> str:
    """Return the new name of what an import of an earlier version's name asked for; else "".

    >>> renamed_import(ModuleNotFoundError("", name="plant_bench.scoring.laws"))
    ". 'plant_bench.scoring.laws' is now 'plant_bench.scoring.penalties'."
    >>> renamed_import(ImportError("cannot import name 'NOBODY' from 'plant_bench.agent' (...)"))
    ". 'NOBODY' is now 'NO_ACTOR'."
    """
    if isinstance(error, ModuleNotFoundError):
        from plant_bench.renamed_modules import MODULES  # only errors need this table

        name = (error.name or "").removeprefix("plant_bench.")
        if name in MODULES and name != error.name:
            return f". '{error.name}' is now 'plant_bench.{MODULES[name]}'."
        return ""
    if isinstance(error, ImportError) and "'plant_bench.agent'" in str(error):
        for old, new in CONSTANTS.items():
            if f"'{old}'" in str(error):
                return f". '{old}' is now '{new}'."
    return ""
