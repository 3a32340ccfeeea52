"""A fake Ray cluster in this process: actors are ordinary objects, calls run on request.

What is real: the actors' worker processes. What is not: Ray, its nodes, and their loss.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from ray.exceptions import RayActorError


@dataclass(eq=False)
class Answer:
    """The result of a call, computed on request."""

    call: Callable[[], Any]


@dataclass(eq=False)
class Actor:
    """What `ray.remote(...).remote()` gives."""

    cluster: "FakeRay"
    node: str
    made: Any
    killed: bool = False

    def __getattr__(self, name: str) -> Any:
        return Method(self, name)


@dataclass
class Method:
    """A method of an actor."""

    actor: Actor
    name: str

    def remote(self, *given: Any) -> Answer:
        def call() -> Any:
            actor = self.actor
            if actor.killed or actor.node in actor.cluster.gone:
                raise RayActorError
            if actor.cluster.on_call is not None:
                actor.cluster.on_call(actor, self.name, given)
            return getattr(actor.made, self.name)(*given)

        answer = Answer(call)
        if self.name == "close":
            call()
        return answer


@dataclass
class Options:
    """What `ray.remote(...)` gives."""

    cluster: "FakeRay"
    made_of: Any
    node: str = ""

    def options(self, *, scheduling_strategy: Any, **_: Any) -> "Options":
        return Options(self.cluster, self.made_of, scheduling_strategy.node_id)

    def remote(self) -> Actor:
        facts = self.cluster.facts.get(self.node)
        actor = Actor(self.cluster, self.node, self.made_of(facts))
        self.cluster.actors.append(actor)
        return actor


@dataclass
class FakeRay:
    """Stands for the module `ray`.

    Attributes:
        cpus: Of each node.
        facts: What a node says of itself where that differs from here.
        gone: Nodes that are lost.
        on_call: Told of each call before it is made; may raise what Ray would.
        actors: All there have been.
    """

    cpus: dict[str, int]
    facts: dict[str, dict[str, str]] = field(default_factory=dict)
    gone: set[str] = field(default_factory=set)
    on_call: Callable[[Actor, str, tuple[Any, ...]], None] | None = None
    actors: list[Actor] = field(default_factory=list)
    connections: list[str] = field(default_factory=list)

    def is_initialized(self) -> bool:
        return bool(self.connections)

    def init(self, address: str, **_: Any) -> None:
        if address == "nowhere":
            raise ConnectionError("Could not find any running Ray instance.")
        self.connections.append(address)

    def shutdown(self) -> None:
        self.connections.clear()

    def put(self, value: Any) -> Any:
        return value

    def nodes(self) -> list[dict[str, Any]]:
        return [
            {
                "NodeID": name,
                "Alive": name not in self.gone,
                "Resources": {"CPU": float(cpus)},
                "NodeManagerHostname": f"host-{name[0]}",
            }
            for name, cpus in self.cpus.items()
        ]

    def remote(self, made_of: Any) -> Options:
        return Options(self, made_of)

    def wait(self, answers: list[Answer], **_: Any) -> tuple[list[Answer], list[Answer]]:
        return answers[:1], answers[1:]

    def get(self, answer: Answer) -> Any:
        return answer.call()

    def kill(self, actor: Actor) -> None:
        actor.made.close()
        actor.killed = True
