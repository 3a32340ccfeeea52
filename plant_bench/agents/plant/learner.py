"""PlanT's learner: encoding, network, loss, initial weights; see `plant_bench.learner`."""

from collections.abc import Mapping
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import torch
from torch import Tensor, nn

from plant_bench.agents.plant.ablations import ABLATIONS, PAPER_FULL
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

_EXPORT_OPTIONS = ("onnx", "weights_bits")  # without influence on the weights


class PlanTLearner(Learner[PlanTOptions]):
    """PlanT: a transformer over nearby objects and the route."""

    name = NETWORK
    agent = "plant-unguarded"
    Options = PlanTOptions
    cached = True
    padding = PADDING
    encoders = ("plant_bench.agents.plant.samples",)
    ablations = ABLATIONS
    paper = PAPER_FULL

    def encode(self, frame: Frame) -> Encoded:
        """Return a frame's network inputs and targets."""
        return encode(frame, self.options.network.tokens)

    def network(self) -> nn.Module:
        """Return a new network."""
        return PlanTNetwork(self.options.network)

    def loss(self, network: Forward, batch: Mapping[str, Tensor]) -> dict[str, Tensor]:
        """Return the loss of equation 3 and its parts; applies speed dropout."""
        config = self.options.network
        inputs = Batch(*(batch[name] for name in Batch._fields))
        if network.training and config.speed_input and config.speed_dropout:
            chance = torch.rand(len(inputs.speed), device=inputs.speed.device)
            dropped = chance < config.speed_dropout
            inputs = inputs._replace(speed=inputs.speed.masked_fill(dropped, torch.nan))
        targets = Targets(batch["waypoints"], batch["futures"])
        losses = losses_of(network(inputs), targets, config.bins, self.options.overshoot_weight)
        return {
            "loss": losses.total(self.options.auxiliary),
            "waypoints": losses.waypoints,
            "vehicles": losses.vehicles,
        }

    @property
    def config(self) -> Mapping[str, Any]:
        """The model's config: the network's size and inputs."""
        return asdict(self.options.network)

    @property
    def recipe(self) -> Mapping[str, Any]:
        """All options that determine the weights."""
        values = asdict(self.options)
        return {name: value for name, value in values.items() if name not in _EXPORT_OPTIONS}

    @property
    def encoding(self) -> Mapping[str, Any]:
        """The options that determine the output of `encode`."""
        return asdict(self.options.network.tokens)

    @classmethod
    def options_of(cls, config: Mapping[str, Any]) -> PlanTOptions:
        """Return the options of a trained model: its network config, otherwise defaults.

        Raises:
            ValueError: It is not a PlanT config.
        """
        return PlanTOptions(config_from(config))

    def start_from(
        self, earlier: PlanTOptions, state: Mapping[str, Tensor]
    ) -> Mapping[str, Tensor]:
        """Return initial weights; those of new attributes are zero.

        Raises:
            InputError: The earlier network is not compatible.
        """
        now = self.options.network
        check_start(earlier.network, now)
        if not state:
            return state
        project = with_new_columns(state["project.weight"], earlier.network.tokens, now.tokens)
        return {**state, "project.weight": project}

    def facts(self, network: nn.Module) -> Mapping[str, str]:
        """Return additional facts for the model card."""
        used = sum(weights.numel() for weights in network.parameters())
        paper = bert_parameters(self.options.network.encoder)
        return {
            "parameters": f"{used:,}; {paper:,} as the paper counts",
            "with the safety layer": "`plant-bench score --agent plant@FOLDER`",
            "losses": "waypoints in metres, x and y added; vehicles in nats, six attributes added",
        }

    @property
    def title(self) -> str:
        """The model's title in its card."""
        return f"PlanT of size {self.options.network.size}"

    def export(self, folder: Path) -> None:
        """Write the ONNX graph if the options ask for it; delete one of earlier weights.

        Raises:
            InputError: The package onnx is missing.
        """
        (folder / GRAPH_FILE).unlink(missing_ok=True)
        if self.options.onnx:
            from plant_bench.agents.plant.onnx_export import export_graph

            export_graph(folder, self.options.weights_bits)

    def for_driving(self) -> PlanTOptions:
        """Return options that write an ONNX graph in float32, so that sizes are comparable."""
        return replace(self.options, onnx=True, weights_bits=32)


def check_start(earlier: PlanTConfig, now: PlanTConfig) -> None:
    """Check that training can start from an earlier network's weights.

    The speed dropout may differ, and attributes for conflicts and motion may be added.

    Raises:
        InputError: The networks differ in size or inputs.
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
            f"The weights to start from belong to another network: {', '.join(other)}. Give the "
            "options that it was trained with, or leave out --start."
        )
        raise InputError(message)


def with_new_columns(weight: Tensor, earlier: TokenSpec, now: TokenSpec) -> Tensor:
    """Return the projection weights with zero columns for new attributes."""
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
