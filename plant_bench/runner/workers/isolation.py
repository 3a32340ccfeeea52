"""Runs planners in separate processes: one that hangs, leaks or crashes only fails its episode.

The episode loop gets a proxy that queries the other process, so records, recordings and keys are
the same as without isolation.
"""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from plant_bench.agent import Agent
from plant_bench.agents.loading.registry import Loader, load_agent
from plant_bench.agents.remote.launch_command import LaunchCommand, launch_command_of

if TYPE_CHECKING:  # runs without it need neither msgpack nor what only Linux has
    from plant_bench.agents.remote.process import Limits
    from plant_bench.agents.remote.process_reuse import Profile


@dataclass(frozen=True)
class Isolation:
    """How a run's planner is kept apart; picklable, and given to each worker.

    Attributes:
        program: What is started for it.
        limits: What it may take.
        profile: What it said of itself when the run began; None for another machine.
    """

    program: LaunchCommand
    limits: "Limits"
    profile: "Profile | None"

    def planner(self, spec: str) -> Agent:
        """Return the run's planner; it starts with its first `reset`."""
        from plant_bench.agents.remote.remote_agent import remote_agent

        known = self.profile if spec == self.program.spec else None
        program = self.program if known else launch_command_of(spec)
        return remote_agent(program, self.limits, known)

    def elsewhere(self) -> "Isolation":
        """Return the same for another machine, where Python and the planner's files lie elsewhere.

        What is started is found there, and what it says of itself is asked anew.
        """
        return replace(self, profile=None)


def isolation_of(agent: str, limits: "Limits") -> Isolation:
    """Start a planner for once, ask it what it is, and end it.

    Raises:
        InputError: It does not start.
    """
    from plant_bench.agents.remote.process_reuse import end_processes
    from plant_bench.agents.remote.remote_agent import remote_agent

    program = launch_command_of(agent)
    planner = remote_agent(program, limits)
    end_processes()
    return Isolation(program, limits, planner.profile)


def loader_of(isolation: Isolation | None) -> Loader:
    """Return what makes planners: in processes of their own, or in this one without isolation."""
    return load_agent if isolation is None else isolation.planner
