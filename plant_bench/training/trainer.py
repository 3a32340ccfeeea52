"""One training: steps, epochs, validation; over as many processes as Fabric was given."""

from collections.abc import Iterator
from dataclasses import asdict
from typing import Any

import numpy as np
import torch
from lightning_fabric import Fabric
from torch import Tensor, nn

from plant_bench.agents.plant.config import PlanTConfig
from plant_bench.agents.plant.network import Batch, PlanTNetwork
from plant_bench.errors import InputError
from plant_bench.features.meetings import MEETING_ATTRIBUTES
from plant_bench.features.tokens import ATTRIBUTES, TokenSpec
from plant_bench.features.tracks import TRACK_ATTRIBUTES
from plant_bench.training.batches import Split, Targets, collate, epoch_batches
from plant_bench.training.checkpoint import Progress
from plant_bench.training.events import Listener, StepEnded
from plant_bench.training.losses import Losses, losses_of
from plant_bench.training.settings import TrainingSettings


class Trainer:
    """A network, its optimiser and its data; mutable.

    Every step's dropout is seeded by its place, so a training that was stopped and goes on gives
    the same numbers as one that was not.

    Attributes:
        network: As it is now, in this process.
        optimizer: As it is now.
        progress: Where the training is.

    Args:
        fabric: Launched.
        config: Of the network.
        settings: How to train.
        split: What to learn from.
    """

    def __init__(
        self, fabric: Fabric, config: PlanTConfig, settings: TrainingSettings, split: Split
    ) -> None:
        torch.manual_seed(settings.seed)
        self.network = PlanTNetwork(config)
        self.optimizer = optimizer_of(self.network, settings)
        self.progress = Progress()
        self._fabric, self._settings, self._split = fabric, settings, split
        self._model, self._stepper = fabric.setup(self.network, self.optimizer)
        self._bins = config.bins
        self._withheld = config.speed_dropout if config.speed_input else 0.0

    def start_from(self, network: PlanTNetwork) -> None:
        """Take the weights of a network, see `check_start`; what is told anew counts nothing yet.

        Raises:
            InputError: It is of another config.
        """
        check_start(network.config, self.network.config)
        state = network.state_dict()
        state["project.weight"] = _with_new_columns(
            state["project.weight"], network.config.tokens, self.network.config.tokens
        )
        self.network.load_state_dict(state)

    def steps(self, listen: Listener) -> Iterator[None]:
        """Do the rest of the current epoch; after each step the caller may stop."""
        fabric, settings, progress = self._fabric, self._settings, self.progress
        for group in self.optimizer.param_groups:
            group["lr"] = settings.rate_of(progress.epoch)
        batches = epoch_batches(
            self._split.training.counts, settings.batch, seed=settings.seed, epoch=progress.epoch
        )
        batches = [batch for batch in batches if len(batch) >= fabric.world_size]
        self._model.train()
        for place in range(progress.step, len(batches)):
            mine = batches[place][fabric.global_rank :: fabric.world_size]
            torch.manual_seed(_step_seed(settings.seed, progress.epoch, place, fabric.global_rank))
            losses = self._step(mine)
            values = [float(losses.waypoints.detach()), float(losses.vehicles.detach())]
            for column, value in enumerate((1.0, *values)):
                progress.sums[column] += value * len(mine)
            progress.step = place + 1
            total = values[0] + settings.auxiliary * values[1]
            listen(StepEnded(progress.epoch, place + 1, len(batches), total))
            yield

    def end_epoch(self) -> dict[str, float]:
        """Validate, and return the epoch's row of the history; the next epoch is current then."""
        progress = self.progress
        row = {
            "epoch": float(progress.epoch + 1),
            "rate": self._settings.rate_of(progress.epoch),
        }
        for name, sums in (("train", progress.sums), ("valid", self._validate())):
            count, waypoints, vehicles = self._summed(sums)
            if count:
                row[f"{name}_waypoints"] = waypoints / count
                row[f"{name}_vehicles"] = vehicles / count
        progress.history.append(row)
        progress.epoch, progress.step, progress.sums = progress.epoch + 1, 0, [0.0, 0.0, 0.0]
        return row

    def any_wants(self, wish: bool) -> bool:
        """Tell whether any process has a wish, so that all do the same."""
        if self._fabric.world_size == 1:
            return wish
        return bool(self._summed([float(wish)])[0])

    def _step(self, chosen: np.ndarray) -> Losses:
        batch, targets = self._given(self._split.training, chosen)
        if self._withheld:
            hidden = torch.rand(len(chosen), device=batch.speed.device) < self._withheld
            batch = batch._replace(speed=batch.speed.masked_fill(hidden, torch.nan))
        losses = self._losses(batch, targets)
        self.optimizer.zero_grad()
        self._fabric.backward(losses.total(self._settings.auxiliary))
        self._fabric.clip_gradients(self._model, self._stepper, max_norm=self._settings.clip)
        self._stepper.step()
        return losses

    def _losses(self, batch: Batch, targets: Targets) -> Losses:
        """Return the losses; matrices are multiplied in bfloat16 if the settings say so."""
        low = self._settings.precision == "bf16-mixed"
        with torch.autocast(self._fabric.device.type, torch.bfloat16, enabled=low):
            output = self._model(batch)
        return losses_of(output, targets, self._bins, self._settings.caution)

    def _validate(self) -> list[float]:
        """Return sums over this process's share of the routes held out."""
        samples, sums = self._split.validation, [0.0, 0.0, 0.0]
        rank, world = self._fabric.global_rank, self._fabric.world_size
        places = np.arange(len(samples))[rank::world]
        self._model.eval()
        with torch.no_grad():
            for at in range(0, len(places), 2 * self._settings.batch):
                chosen = places[at : at + 2 * self._settings.batch]
                batch, targets = self._given(samples, chosen)
                losses = self._losses(batch, targets)
                parts = (1.0, float(losses.waypoints), float(losses.vehicles))
                for column, value in enumerate(parts):
                    sums[column] += value * len(chosen)
        return sums

    def _given(self, samples: Any, chosen: np.ndarray) -> tuple[Batch, Targets]:
        batch, targets = collate(samples, chosen)
        device = self._fabric.device
        if device.type == "cpu":
            return batch, targets
        moved = Batch(*(values.to(device) for values in batch))
        return moved, Targets(targets.waypoints.to(device), targets.futures.to(device))

    def _summed(self, sums: list[float]) -> list[float]:
        if self._fabric.world_size == 1:
            return sums
        values = torch.tensor(sums, device=self._fabric.device)
        total = self._fabric.all_reduce(values, reduce_op="sum")
        return total.tolist() if isinstance(total, Tensor) else sums


def check_start(earlier: PlanTConfig, wanted: PlanTConfig) -> None:
    """Check that a training may start from an earlier network's weights.

    How often the speed is withheld in training is no part of the network, and may differ; and
    attributes of meetings and tracks may be told that were not told before.

    Raises:
        InputError: The networks differ in size or in what they are told.
    """
    before, now = _options(earlier), _options(wanted)
    for name in ("meetings", "tracks"):
        before[name] = before[name] or now[name]
    other = [
        f"{name} {before[name]} (now {now[name]})" for name in now if before[name] != now[name]
    ]
    if other:
        message = (
            f"The weights to start from are of another network: {', '.join(other)}. Give the "
            "options that it was trained with, or leave out --start."
        )
        raise InputError(message)


def _with_new_columns(weight: Tensor, earlier: TokenSpec, now: TokenSpec) -> Tensor:
    """Return the weights of attributes with zeros for those that are new."""
    columns = weight[:, :ATTRIBUTES]
    rest = weight[:, ATTRIBUTES:]
    for had, has, count in (
        (earlier.meetings, now.meetings, MEETING_ATTRIBUTES),
        (earlier.tracks, now.tracks, TRACK_ATTRIBUTES),
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


def optimizer_of(network: nn.Module, settings: TrainingSettings) -> torch.optim.AdamW:
    """Return AdamW that decays the weights of linear layers and nothing else."""
    linear = [module for module in network.modules() if isinstance(module, nn.Linear)]
    decayed = [module.weight for module in linear]
    known = {id(weights) for weights in decayed}
    others = [weights for weights in network.parameters() if id(weights) not in known]
    return torch.optim.AdamW(
        [
            {"params": decayed, "weight_decay": settings.weight_decay},
            {"params": others, "weight_decay": 0.0},
        ],
        lr=settings.rate,
        betas=settings.betas,
    )


def _step_seed(seed: int, epoch: int, step: int, rank: int) -> int:
    state = np.random.SeedSequence((seed, epoch, step, rank)).generate_state(1, np.uint64)
    return int(state[0] >> np.uint64(1))
