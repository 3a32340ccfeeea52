"""Parses the text that names a planner, as in `--agent`.

plant, plant@models/mine       a built-in planner, optionally with its class's argument
my-planner                     a planner of an installed package
package.module:Class@argument  a class that can be imported
path/to/file.py:Class          a class in a file
command:./program --flag       a program in another process (docs/reference/protocol-agents.md)
"""

import ast
import re
import shlex
from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from functools import cache
from pathlib import Path

from plant_bench.agents.loading.installed import installed_planners
from plant_bench.errors import InputError, did_you_mean

COMMAND = "command:"
_PATH = re.compile(r"(^|[@=:])(~?/[^@=:]+)")

AGENTS: dict[str, str] = {
    "cruise": "plant_bench.agents.cruise:Cruise",
    "expert": "plant_bench.agents.expert:Expert",
    "expert-filtered": "plant_bench.agents.ranking.expert_filtered:FilteredExpert",
    "expert-nearest": "plant_bench.agents.ranking.expert_nearest:expert_nearest",
    "idm": "plant_bench.agents.idm_follower:IdmFollower",
    "plant": "plant_bench.agents.plant.guarded_plant:GuardedPlanT",
    "plant-unguarded": "plant_bench.agents.plant.agent:PlanT",
    "rule-based": "plant_bench.agents.rule_based:RuleBased",
    "rule-based-tracks": "plant_bench.agents.rule_based_tracks:RuleBasedTracks",
    "sumo": "plant_bench.agents.sumo_driver:SumoDriver",
}


class Kind(Enum):
    """Where a planner comes from."""

    BUILT_IN = "built-in"
    INSTALLED = "installed"
    MODULE = "module"
    FILE = "file"
    COMMAND = "command"


@dataclass(frozen=True, slots=True)
class PlannerSpec:
    """A parsed planner name.

    Attributes:
        text: The text as the user wrote it.
        kind: Where the planner comes from.
        module: The module, or the path of the file; empty for a command.
        name: The class or factory function; for a command, the command line.
        argument: The argument for the class; None for none.
    """

    text: str
    kind: Kind
    module: str
    name: str
    argument: str | None = None

    @classmethod
    def parse(cls, text: str) -> "PlannerSpec":
        """Parse a planner's name; nothing is loaded.

        Raises:
            InputError: There is no such planner; the message suggests similar names.

        >>> PlannerSpec.parse("plant@models/mine").argument
        'models/mine'
        >>> PlannerSpec.parse("my/agent.py:Mine").kind.value
        'file'
        """
        return _parsed(text)

    @property
    def words(self) -> list[str]:
        """The words of a command.

        Raises:
            InputError: It is not a valid command line.
        """
        try:
            return shlex.split(self.name)
        except ValueError as error:
            message = f"The agent '{self.text}' is not a valid command: {error}."
            raise InputError(message) from error


def is_command(text: str) -> bool:
    """Return whether a text names a command; the command itself is not checked."""
    return text.startswith(COMMAND)


def with_paths(text: str, change: Callable[[str], str]) -> str:
    """Return a text with `change` applied to every absolute path; paths end at "@", "=" and ":"."""
    return _PATH.sub(lambda match: match[1] + change(match[2]), text)


def without_folders(argument: str) -> str:
    """Return an argument with absolute paths replaced by their last component.

    >>> without_folders("plant@/home/me/models/mine"), without_folders("models/mine")
    ('plant@mine', 'models/mine')
    """
    return with_paths(argument, lambda path: Path(path).name + "/" * path.endswith("/"))


@cache
def _parsed(text: str) -> PlannerSpec:
    if is_command(text):
        return PlannerSpec(text, Kind.COMMAND, "", text.removeprefix(COMMAND))
    target, argument = _split(text)
    kind, found = Kind.BUILT_IN, AGENTS.get(target)
    if found is None and ":" not in target and target in installed_planners():
        kind, found = Kind.INSTALLED, installed_planners()[target].target
    module, _, name = (found or target).rpartition(":")
    if not module or not name:
        if target.rstrip(":").endswith(".py"):
            raise InputError(_class_missing(target.rstrip(":"), argument))
        known = [*AGENTS, *(name for name in installed_planners() if name not in AGENTS)]
        hint = did_you_mean(target, known, cutoff=0.5, quote="'")
        message = (
            f"There is no agent '{target}'.{hint} "
            f"Agents: {', '.join(known)}; or give package.module:Class or file.py:Class."
        )
        raise InputError(message)
    if found is None:
        kind = Kind.FILE if module.endswith(".py") else Kind.MODULE
    return PlannerSpec(text, kind, module, name, argument)


def _class_missing(file: str, argument: str | None) -> str:
    """Return the message for a file that is named without its class; it names those to choose."""
    path = Path(file).expanduser()
    if not path.is_file():
        return f"There is no file {file}. Expected a planner as file.py:Class."
    ending = "" if argument is None else f"@{argument}"
    try:
        statements = ast.parse(path.read_bytes()).body
    except (SyntaxError, ValueError, OSError, RecursionError):
        statements = []
    classes = [item for item in statements if isinstance(item, ast.ClassDef)]
    planners = [item.name for item in classes if "act" in map(_name_of, item.body)]
    names = planners or [item.name for item in classes]
    if not names:
        return f"Expected a planner as file.py:Class, got '{file}{ending}'."
    choice = f"Add :{names[0]}" if len(names) == 1 else f"Add one of :{', :'.join(names)}"
    return f"'{file}' names no class. {choice}, as in {file}:{names[0]}{ending}."


def _name_of(statement: ast.stmt) -> str:
    return statement.name if isinstance(statement, ast.FunctionDef) else ""


def _split(text: str) -> tuple[str, str | None]:
    """Return the part that names the class, and the argument after "@"."""
    name, at, argument = text.partition("@")
    if at and (name in AGENTS or ":" not in text):
        return name, argument
    found = re.fullmatch(r"(.+?:\w+)@(.+)", text)
    return (found[1], found[2]) if found else (text, None)
