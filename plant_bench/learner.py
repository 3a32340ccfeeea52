"""The contract between training and a planner that learns: all that its author must read.

A learner brings what is its own: how a frame becomes its network's input, the network, the loss,
and its options as one dataclass. Recordings, batches, checkpoints, early stopping by closed-loop
score, the card and the ablations are the same for all, and know no planner by its name.

    class Mine(Learner):
        name = "mine"                     # of the network, in the model's config.json
        agent = "my_package.agent:Mine"   # drives with a model: `--agent my_package.agent:Mine@DIR`
        Options = MyOptions               # a frozen dataclass; its fields are the command's options

        def encode(self, frame):          # numpy arrays, of one shape for all frames
            return {"picture": draw(frame), "waypoints": frame.waypoints}

        def network(self):
            return MyNetwork(self.options)

        def loss(self, network, batch):   # tensors by the same names, with one more axis
            answer = network(batch["picture"])
            return {"waypoints": (answer - batch["waypoints"]).abs().mean()}

`plant-bench train my_package.learn:Mine` trains it; so does `train path/to/file.py:Mine`, and
`train mine` where an installed package declares the entry point `mine` of the group
`plant_bench.learners`.

An option's help is its line in the docstring's "Attributes:"; `metadata` of a field may hold "min",
"max", and "option": another name on the command line.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Generic, Protocol, TypeVar, runtime_checkable

import numpy as np
from jaxtyping import Float
from pydantic import TypeAdapter

from plant_bench.agent import Control, Input, Observation
from plant_bench.errors import InputError
from plant_bench.world.route import Route
from plant_bench.world.scene import Actors
from plant_bench.world.town import Town, load_town

if TYPE_CHECKING:
    from torch import Tensor
    from torch.nn import Module
else:  # torch is not loaded to look at a type
    Tensor = Module = Any

Encoded = Mapping[str, np.ndarray]
Batch = Mapping[str, Tensor]
Losses = Mapping[str, Tensor]


@dataclass(frozen=True, eq=False, slots=True)
class Frame:
    """One instant of a recording, two a second; the same for every learner.

    Attributes:
        observation: What a planner sees. What was executed is in its `ego`.
        before: The actors half a second earlier.
        later: The actors half a second later.
        waypoints: Where the ego's centre should be 0.5, 1.0, 1.5 and 2.0 s later, in the ego frame,
            metres. `--targets` says what that is: where it went, or where `answer` leads.
        answer: The control that the expert last asked for, whether or not it was executed.
        disturbed: Whether something else than the answer was executed in the next two seconds.
        route: That was driven.
        seed: Of the episode.
    """

    observation: Observation
    before: Actors
    later: Actors
    waypoints: Float[np.ndarray, "waypoints 2"]
    answer: Control | None
    disturbed: bool
    route: Route
    seed: int

    @property
    def town(self) -> Town:
        """The town, read once in a process.

        Raises:
            InputError: It is not there.
        """
        return _town(self.route.town, self.route.town_folders)


@lru_cache(maxsize=32)
def _town(name: str, folders: tuple[Path, ...]) -> Town:
    return load_town(name, folders)


@runtime_checkable
class Forward(Protocol):
    """A network as `Learner.loss` calls it.

    Attributes:
        training: Whether it is being trained; otherwise it is checked on the routes held out.
    """

    @property
    def training(self) -> bool:
        """As above."""
        ...

    def __call__(self, *inputs: Any) -> Any:
        """Do a forward pass; its matrices may be multiplied in bfloat16."""
        ...


OptionsT = TypeVar("OptionsT")


@dataclass(frozen=True)
class Choice:
    """One of the things that an ablation compares.

    Attributes:
        name: Of the choice; unique among all of a learner's.
        change: Makes its options from those of the base.
        paper: DS in the paper.
    """

    name: str
    change: Callable[[Any], Any]
    paper: str = "-"


class Learner(ABC, Generic[OptionsT]):
    """A planner that learns; made anew in each process, from its options alone.

    Attributes:
        name: Of the network, in the model's config.
        agent: What drives with a model folder, as in `--agent AGENT@FOLDER`.
        Options: A frozen dataclass, perhaps of others; all values have defaults.
        inputs: What a frame's observation holds; nothing privileged.
        cached: Whether encodings are small enough for the disk. They are then made once; otherwise
            anew for each batch, by the processes of `--loaders`.
        padding: The arrays of `encode` that have a row for each of a frame's objects, all equally
            many, with what fills those of a batch up.
        encoders: Modules whose code decides what `encode` returns; the learner's own if empty.
        ablations: What may be compared, by the ablation's name; the share of the data always can.
        paper: DS of the whole in its paper, for the table of ablations.

    Args:
        options: Of `Options`.
    """

    name: ClassVar[str]
    agent: ClassVar[str]
    Options: ClassVar[type]
    inputs: ClassVar[frozenset[str]] = frozenset({Input.OBJECTS, Input.ROUTE, Input.LIGHT})
    cached: ClassVar[bool] = False
    padding: ClassVar[Mapping[str, float]] = {}
    encoders: ClassVar[tuple[str, ...]] = ()
    ablations: ClassVar[Mapping[str, tuple[Choice, ...]]] = {}
    paper: ClassVar[str] = "-"

    def __init__(self, options: OptionsT) -> None:
        self.options = options

    @abstractmethod
    def encode(self, frame: Frame) -> Encoded:
        """Return what is learned from a frame: input and targets, by name.

        Equal frames give equal arrays: chance belongs into `loss`, where torch's is seeded by step.
        """

    @abstractmethod
    def network(self) -> Module:
        """Return a new network; torch's random numbers are seeded before."""

    @abstractmethod
    def loss(self, network: Forward, batch: Batch) -> Losses:
        """Return named means over the batch; the first is minimised, all are logged."""

    @property
    def config(self) -> Mapping[str, Any]:
        """What is written into the model's config: JSON-able, all that its agent needs."""
        return asdict(self.options)  # pyright: ignore[reportArgumentType]

    @property
    def recipe(self) -> Mapping[str, Any]:
        """All options that decide the weights: a training goes on only where they are equal."""
        return asdict(self.options)  # pyright: ignore[reportArgumentType]

    @property
    def encoding(self) -> Mapping[str, Any]:
        """The options that decide what `encode` returns, if encodings are cached."""
        return self.recipe

    @classmethod
    def options_of(cls, config: Mapping[str, Any]) -> Any:
        """Return the options of a trained model, for ablations of it.

        Args:
            config: Of the model, as `config` gave it.

        Raises:
            ValueError: It is none of this learner's.
        """
        return TypeAdapter(cls.Options).validate_python(dict(config))

    def start_from(self, earlier: Any, state: Mapping[str, Tensor]) -> Mapping[str, Tensor]:
        """Return the weights to start from, made from those of an earlier model (`--start`).

        Args:
            earlier: Options of the earlier model, see `options_of`.
            state: Its weights; may be empty, if it is only checked that they would do.

        Raises:
            InputError: They cannot be started from.
        """
        del earlier
        return state

    def facts(self, network: Module) -> Mapping[str, str]:
        """Return what the model's card tells of it, besides what is told of all models."""
        del network
        return {}

    @property
    def title(self) -> str:
        """What the model's card and the table of ablations call it."""
        return self.name

    def export(self, folder: Path) -> None:
        """Write what else a finished model's folder is to hold, beside weights and config.

        Raises:
            InputError: It cannot be.
        """
        del folder

    def for_driving(self) -> Any:
        """Return the options with which a model's fast form is written (`ablate --onnx`).

        Raises:
            InputError: There is none.
        """
        message = f"'{self.name}' writes no graph: leave out --onnx."
        raise InputError(message)
