"""The command that starts a planner's process: the user's own, or Python with a planner server."""

import shutil
import sys
from dataclasses import dataclass
from pathlib import Path

from plant_bench.agents.loading.planner_spec import Kind, PlannerSpec
from plant_bench.errors import InputError

_SERVE = (sys.executable, "-P", "-m", "plant_bench.agents.remote.planner_server")


@dataclass(frozen=True)
class LaunchCommand:
    """A program that speaks the protocol.

    Attributes:
        spec: The planner's name as the user entered it.
        command: The program and its arguments.
        agent: The planner that the program creates, sent with "hello"; empty for the user's own
            program.
        files: Arguments that are existing files: the program, a script, its configuration.
    """

    spec: str
    command: tuple[str, ...]
    agent: str = ""
    files: tuple[Path, ...] = ()


def launch_command_of(spec: str) -> LaunchCommand:
    """Return a planner's launch command: the one it names, or Python that loads it.

    Raises:
        InputError: The command is empty, or the program does not exist.
    """
    parsed = PlannerSpec.parse(spec)
    if parsed.kind is not Kind.COMMAND:
        return LaunchCommand(spec, _SERVE, agent=spec)
    words = parsed.words
    if not words:
        message = f"Expected a program as in 'command:./my_planner --flag', got '{spec}'."
        raise InputError(message)
    if shutil.which(words[0]) is None:
        exists = Path(words[0]).exists()
        wrong = "is not executable (use chmod +x)" if exists else "does not exist"
        message = f"The agent '{spec}' cannot be started: {words[0]} {wrong}."
        raise InputError(message)
    files = tuple(Path(word) for word in words if Path(word).is_file())
    return LaunchCommand(spec, tuple(words), files=files)
