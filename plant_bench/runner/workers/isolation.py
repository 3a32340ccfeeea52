"""Runs planners in separate processes, where a hang, leak or crash fails only the episode.

The episode loop gets a proxy that queries the other process, so records, recordings and keys are
the same as without isolation.
"""

from contextlib import nullcontext
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from plant_bench.agent import Agent
from plant_bench.agents.loading.registry import Loader, load_agent
from plant_bench.agents.loading.reported_planner import ReportedPlanner
from plant_bench.agents.remote.launch_command import LaunchCommand, launch_command_of
from plant_bench.user_code import planner_log

if TYPE_CHECKING:  # runs without isolation need neither msgpack nor Linux
    from plant_bench.agents.remote.planner_connection import Profile
    from plant_bench.agents.remote.process import Limits


@dataclass(frozen=True)
class Isolation:
    """Settings for a run's planner in a separate process; picklable, sent to each worker.

    Attributes:
        command: Command line that starts the planner.
        limits: Time and memory limits.
        profile: Properties that the planner reported when the run started; None to query them
            again.
    """

    command: LaunchCommand
    limits: "Limits"
    profile: "Profile | None"

    def planner(self, spec: str) -> Agent:
        """Return a proxy of the planner; the process starts with the first `reset`."""
        from plant_bench.agents.remote.remote_agent import remote_agent

        profile = self.profile if spec == self.command.spec else None
        command = self.command if profile else launch_command_of(spec)
        return remote_agent(command, self.limits, profile)

    def for_other_machine(self) -> "Isolation":
        """Return these settings for a machine with other paths of Python and the planner's files.

        There the command is determined and the planner's properties are queried again.
        """
        return replace(self, profile=None)


def isolation_of(agent: str, limits: "Limits", log: Path | None = None) -> Isolation:
    """Start a planner once to query its properties, and return the settings of a run with it.

    Args:
        agent: Name of the planner.
        limits: Time and memory limits.
        log: File for the traceback if the planner's code fails; None to drop it.

    Raises:
        InputError: The planner does not start.
    """
    from plant_bench.agents.remote.planner_connection import end_processes
    from plant_bench.agents.remote.remote_agent import remote_agent

    command = launch_command_of(agent)
    with nullcontext() if log is None else planner_log(log):
        planner = remote_agent(command, limits)
    end_processes()
    return Isolation(command, limits, planner.profile)


def loader_of(isolation: Isolation | None) -> Loader:
    """Return the function that loads planners, into separate processes if isolated."""
    return load_agent if isolation is None else isolation.planner


def episode_loader(isolation: Isolation | None) -> Loader:
    """Return the loader for planners that drive: the tracebacks of their exceptions are logged.

    Planners in separate processes log them there.
    """
    return _load_reported if isolation is None else isolation.planner


def _load_reported(spec: str) -> Agent:
    return ReportedPlanner(load_agent(spec))
