"""The interface of a trainable planner: encoding, network, loss and options.

A learner defines how a frame becomes its network's input, the network, the loss, and its options as
one dataclass. Recordings, batches, checkpoints, early stopping by closed-loop score, the model card
and ablations are shared by all learners and depend on none of them.

    class Mine(Learner):
        name = "mine"                     # of the network, in the model's config.json
        agent = "my_package.agent:Mine"   # drives a model: `--agent my_package.agent:Mine@DIR`
        Options = MyOptions               # a frozen dataclass; its fields are the command's options

        def encode(self, frame):          # numpy arrays of the same shapes for all frames
            return {"image": draw(frame), "waypoints": frame.waypoints}

        def network(self):
            return MyNetwork(self.options)

        def loss(self, network, batch):   # tensors by the same names, with a batch axis
            predicted = network(batch["image"])
            return {"waypoints": (predicted - batch["waypoints"]).abs().mean()}

`plant-bench train my_package.learn:Mine` trains it; so does `train path/to/file.py:Mine`, and
`train mine` where an installed package declares the entry point `mine` of the group
`plant_bench.learners`.

An option's help text is its line under "Attributes:" in the docstring; a field's `metadata` may
hold "min", "max", and "option": a different name on the command line.
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
else:  # torch is not loaded for type annotations only
    Tensor = Module = Any

Encoded = Mapping[str, np.ndarray]
Batch = Mapping[str, Tensor]
Losses = Mapping[str, Tensor]


@dataclass(frozen=True, eq=False, slots=True)
class Frame:
    """One instant of a recording, sampled at 2 Hz; the same for every learner.

    Attributes:
        observation: The planner's input. Its `ego` holds the executed acceleration and steering.
        before: The actors half a second earlier.
        later: The actors half a second later.
        waypoints: Target positions of the ego's centre 0.5, 1.0, 1.5 and 2.0 s later, in the ego
            frame, metres. `--targets` selects the source: the driven path, or the path that results
            from `answer`.
        answer: The expert's most recent action, executed or not.
        disturbed: Whether an action other than the driver's was executed in the next two seconds.
        route: The route driven.
        seed: The episode's seed.
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
        """The town; loaded once per process.

        Raises:
            InputError: It does not exist.
        """
        return _town(self.route.town, self.route.town_folders)


@lru_cache(maxsize=32)
def _town(name: str, folders: tuple[Path, ...]) -> Town:
    return load_town(name, folders)


@runtime_checkable
class Forward(Protocol):
    """A network as `Learner.loss` calls it.

    Attributes:
        training: True in training, False in validation on the held-out routes.
    """

    @property
    def training(self) -> bool:
        """True in training, False in validation."""
        ...

    def __call__(self, *inputs: Any) -> Any:
        """Run a forward pass; matrix products may use bfloat16."""
        ...


OptionsT = TypeVar("OptionsT")


@dataclass(frozen=True)
class Choice:
    """One variant in an ablation.

    Attributes:
        name: The variant's name; unique among all of a learner's.
        change: Returns the variant's options, given the base options.
        paper: Driving score (DS) in the paper.
    """

    name: str
    change: Callable[[Any], Any]
    paper: str = "-"


class Learner(ABC, Generic[OptionsT]):
    """A trainable planner; each process creates it from its options.

    Attributes:
        name: The network's name in the model's config.
        agent: The planner that drives a model folder, as in `--agent AGENT@FOLDER`.
        Options: A frozen dataclass, which may be nested; all fields have defaults.
        inputs: The inputs in a frame's observation; none may be privileged.
        cached: Whether encodings are small enough to be cached on disk. If so, they are computed
            once, otherwise for each batch, by the processes of `--loaders`.
        padding: The arrays of `encode` with one row per object of a frame, all of equal length,
            mapped to the value that pads them in a batch.
        encoders: Modules whose code determines the output of `encode`; the learner's own if empty.
        ablations: The variants to compare, by the ablation's name; ablating the amount of data is
            always possible.
        paper: Driving score (DS) of the full model in its paper, for the table of ablations.

    Args:
        options: An instance of `Options`.
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
        """Return a frame's network inputs and targets, by name.

        Must be deterministic: randomness belongs in `loss`, where torch is seeded for each step.
        """

    @abstractmethod
    def network(self) -> Module:
        """Return a new network; torch is seeded before this call."""

    @abstractmethod
    def loss(self, network: Forward, batch: Batch) -> Losses:
        """Return losses by name, each a mean over the batch; the first is minimised, all logged."""

    @property
    def config(self) -> Mapping[str, Any]:
        """The model's config: JSON-serialisable, with all that its planner needs."""
        return asdict(self.options)  # pyright: ignore[reportArgumentType]

    @property
    def recipe(self) -> Mapping[str, Any]:
        """All options that determine the weights: training resumes only if they are equal."""
        return asdict(self.options)  # pyright: ignore[reportArgumentType]

    @property
    def encoding(self) -> Mapping[str, Any]:
        """The options that determine the output of `encode`, for the cache of encodings."""
        return self.recipe

    @classmethod
    def options_of(cls, config: Mapping[str, Any]) -> Any:
        """Return the options of a trained model.

        Args:
            config: The model's config, as returned by `config`.

        Raises:
            ValueError: It is not a config of this learner.
        """
        return TypeAdapter(cls.Options).validate_python(dict(config))

    def start_from(self, earlier: Any, state: Mapping[str, Tensor]) -> Mapping[str, Tensor]:
        """Return initial weights, converted from those of an earlier model (`--start`).

        Args:
            earlier: Options of the earlier model, see `options_of`.
            state: Its weights; empty if only compatibility is to be checked.

        Raises:
            InputError: The models are not compatible.
        """
        del earlier
        return state

    def facts(self, network: Module) -> Mapping[str, str]:
        """Return additional facts for the model card."""
        del network
        return {}

    @property
    def title(self) -> str:
        """The model's title in its card and in the table of ablations."""
        return self.name

    def export(self, folder: Path) -> None:
        """Write further files into a finished model's folder, beside weights and config.

        Raises:
            InputError: Writing them is not possible.
        """
        del folder

    def for_driving(self) -> Any:
        """Return the options with which `export` writes a faster model (`ablate --onnx`).

        Raises:
            InputError: The learner has no such export.
        """
        message = f"'{self.name}' has no ONNX export: leave out --onnx."
        raise InputError(message)
