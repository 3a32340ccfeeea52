"""How PlanT learns: its input, loss and start; see `plant_bench.learner`."""

from collections.abc import Mapping
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import torch
from torch import Tensor, nn

from plant_bench.agents.plant.ablations import ABLATIONS, PAPER_WHOLE
from plant_bench.agents.plant.config import GRAPH_FILE, NETWORK, PlanTConfig, config_from
from plant_bench.agents.plant.losses import Targets, losses_of
from plant_bench.agents.plant.network import Batch, PlanTNetwork
from plant_bench.agents.plant.samples import PADDING, encode
from plant_bench.agents.plant.training_options import PlanTOptions
from plant_bench.agents.plant.transformer import bert_parameters
from plant_bench.errors import InputError
from plant_bench.features.motion import MOTION_ATTRIBUTES
from plant_bench.features.predicted_conflicts import CONFLICT_ATTRIBUTES
from plant_bench.features.tokens import ATTRIBUTES, TokenSpec
from plant_bench.learner import Encoded, Forward, Frame, Learner

_OF_GRAPHS = ("onnx", "weights_bits")  # options that decide no weights


class PlanTLearner(Learner[PlanTOptions]):
    """PlanT: a transformer over nearby objects and the route."""

    name = NETWORK
    agent = "plant-unguarded"
    Options = PlanTOptions
    cached = True
    padding = PADDING
    encoders = ("plant_bench.agents.plant.samples",)
    ablations = ABLATIONS
    paper = PAPER_WHOLE

    def encode(self, frame: Frame) -> Encoded:
        """Return what is learned from a frame."""
        return encode(frame, self.options.network.tokens)

    def network(self) -> nn.Module:
        """Return a new network."""
        return PlanTNetwork(self.options.network)

    def loss(self, network: Forward, batch: Mapping[str, Tensor]) -> dict[str, Tensor]:
        """Return equation 3 and its parts; the speed is withheld from some samples."""
        config = self.options.network
        given = Batch(*(batch[name] for name in Batch._fields))
        if network.training and config.speed_input and config.speed_dropout:
            chance = torch.rand(len(given.speed), device=given.speed.device)
            hidden = chance < config.speed_dropout
            given = given._replace(speed=given.speed.masked_fill(hidden, torch.nan))
        targets = Targets(batch["waypoints"], batch["futures"])
        losses = losses_of(network(given), targets, config.bins, self.options.overshoot_weight)
        return {
            "loss": losses.total(self.options.auxiliary),
            "waypoints": losses.waypoints,
            "vehicles": losses.vehicles,
        }

    @property
    def config(self) -> Mapping[str, Any]:
        """What is written into the model's config: the network's size and inputs."""
        return asdict(self.options.network)

    @property
    def recipe(self) -> Mapping[str, Any]:
        """All options that decide the weights."""
        values = asdict(self.options)
        return {name: value for name, value in values.items() if name not in _OF_GRAPHS}

    @property
    def encoding(self) -> Mapping[str, Any]:
        """The options that decide what `encode` returns."""
        return asdict(self.options.network.tokens)

    @classmethod
    def options_of(cls, config: Mapping[str, Any]) -> PlanTOptions:
        """Return the options of a trained model: its network's, and else the defaults.

        Raises:
            ValueError: It is none.
        """
        return PlanTOptions(config_from(config))

    def start_from(
        self, earlier: PlanTOptions, state: Mapping[str, Tensor]
    ) -> Mapping[str, Tensor]:
        """Return the weights to start from; what is told anew counts nothing yet.

        Raises:
            InputError: They are of another network.
        """
        now = self.options.network
        check_start(earlier.network, now)
        if not state:
            return state
        project = with_new_columns(state["project.weight"], earlier.network.tokens, now.tokens)
        return {**state, "project.weight": project}

    def facts(self, network: nn.Module) -> Mapping[str, str]:
        """Return what the card tells of it."""
        used = sum(weights.numel() for weights in network.parameters())
        paper = bert_parameters(self.options.network.encoder)
        return {
            "parameters": f"{used:,}; {paper:,} as the paper counts",
            "with its guard": "`plant-bench score --agent plant@FOLDER`",
            "losses": "waypoints in metres, x and y added; vehicles in nats, six attributes added",
        }

    @property
    def title(self) -> str:
        """What the card calls it."""
        return f"PlanT of size {self.options.network.size}"

    def export(self, folder: Path) -> None:
        """Write the graph, if it is asked for; one of earlier weights goes.

        Raises:
            InputError: The package onnx is missing.
        """
        (folder / GRAPH_FILE).unlink(missing_ok=True)
        if self.options.onnx:
            from plant_bench.agents.plant.onnx_export import export_graph

            export_graph(folder, self.options.weights_bits)

    def for_driving(self) -> PlanTOptions:
        """Return the options with which a graph is written: in float32, as sizes are compared."""
        return replace(self.options, onnx=True, weights_bits=32)


def check_start(earlier: PlanTConfig, now: PlanTConfig) -> None:
    """Check that a training may start from an earlier network's weights.

    How often the speed is withheld in training is no part of the network, and may differ; and
    attributes of conflicts and motion may be told that were not told before.

    Raises:
        InputError: The networks differ in size or in what they are told.
    """
    before, after = _options(earlier), _options(now)
    for name in ("conflicts", "motion"):
        before[name] = before[name] or after[name]
    other = [
        f"{name} {before[name]} (now {after[name]})"
        for name in after
        if before[name] != after[name]
    ]
    if other:
        message = (
            f"The weights to start from are of another network: {', '.join(other)}. Give the "
            "options that it was trained with, or leave out --start."
        )
        raise InputError(message)


def with_new_columns(weight: Tensor, earlier: TokenSpec, now: TokenSpec) -> Tensor:
    """Return the weights of attributes with zeros for those that are new."""
    columns = weight[:, :ATTRIBUTES]
    rest = weight[:, ATTRIBUTES:]
    for had, has, count in (
        (earlier.conflicts, now.conflicts, CONFLICT_ATTRIBUTES),
        (earlier.motion, now.motion, MOTION_ATTRIBUTES),
    ):
        if has:
            columns = torch.cat(
                (columns, rest[:, :count] if had else rest.new_zeros(len(rest), count)), 1
            )
        rest = rest[:, count * had :]
    return columns


def _options(config: PlanTConfig) -> dict[str, object]:
    values = asdict(config)
    del values["speed_dropout"]
    return values | values.pop("tokens")
