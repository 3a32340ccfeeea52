"""The training loop: steps, epochs and validation, on the processes of Lightning Fabric."""

import math
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
import torch
from lightning_fabric import Fabric
from torch import Tensor, nn

from plant_bench.learner import Learner
from plant_bench.training.batches import Split, epoch_batches
from plant_bench.training.checkpoint import SAMPLES, Progress
from plant_bench.training.divergence import DivergedError
from plant_bench.training.events import Listener, StepEnded
from plant_bench.training.loader import Loader, Tensors
from plant_bench.training.settings import TrainingSettings


class Trainer:
    """Trains a network step by step; mutable.

    Dropout is seeded by epoch, step and process, so a resumed training gives the same weights as an
    uninterrupted one. A row of the history holds `epoch` (from 1), `rate`, and mean losses as
    `train_NAME` and `valid_NAME`.

    Attributes:
        network: The network, in this process.
        optimizer: The optimiser.
        progress: Progress of the training.

    Args:
        fabric: A launched Fabric.
        learner: The learner.
        settings: The training settings.
        split: The data.
        loader: Loads batches of `split.frames`.
    """

    def __init__(
        self,
        fabric: Fabric,
        learner: Learner,
        settings: TrainingSettings,
        split: Split,
        loader: Loader,
    ) -> None:
        torch.manual_seed(settings.seed)
        self.network = learner.network()
        self.optimizer = optimizer_of(self.network, settings)
        self.progress = Progress()
        self._fabric, self._settings, self._split = fabric, settings, split
        self._learner, self._loader = learner, loader
        self._model, self._stepper = fabric.setup(self.network, self.optimizer)
        self._forward = _Forward(
            self._model, fabric.device.type, bfloat16=not settings.full_precision
        )

    def steps(self, listen: Listener) -> Iterator[None]:
        """Run the remaining steps of the current epoch; yields after each step.

        Raises:
            DivergedError: The loss or its gradient is not finite.
        """
        fabric, settings, progress = self._fabric, self._settings, self.progress
        for group in self.optimizer.param_groups:
            group["lr"] = settings.rate_of(progress.epoch)
        batches = self._epoch()
        rank, world = fabric.global_rank, fabric.world_size
        mine = [batch[rank::world] for batch in batches[progress.step :]]
        self._model.train()
        waited = self._loader.waited
        loaded = self._loader.batches(mine)
        for place, (chosen, batch) in enumerate(zip(mine, loaded, strict=True), progress.step):
            torch.manual_seed(_step_seed(settings.seed, progress.epoch, place, rank))
            where = f"step {place + 1} of {len(batches)} of epoch {progress.epoch + 1}"
            losses = self._step(self._moved(batch), where)
            _add(progress.sums, losses, len(chosen))
            progress.step = place + 1
            loss, waits = next(iter(losses.values())), self._loader.waited - waited
            waited = self._loader.waited
            listen(StepEnded(progress.epoch, place + 1, len(batches), loss, waits))
            yield

    def end_epoch(self) -> dict[str, float]:
        """Validate, append the epoch's row to the history, and go to the next epoch.

        Raises:
            DivergedError: A loss is not finite.
        """
        progress = self.progress
        row = {
            "epoch": float(progress.epoch + 1),
            "rate": self._settings.rate_of(progress.epoch),
        }
        for name, sums in (("train", progress.sums), ("valid", self._validate())):
            total = self._summed(sums)
            count = total.pop(SAMPLES, 0.0)
            row |= {f"{name}_{part}": value / count for part, value in total.items() if count}
        if odd := [name for name, value in row.items() if not math.isfinite(value)]:
            message = f"{odd[0]} was {row[odd[0]]} after epoch {progress.epoch + 1}"
            raise DivergedError(message)
        progress.history.append(row)
        progress.epoch, progress.step, progress.sums = progress.epoch + 1, 0, {}
        return row

    def any_process(self, flag: bool) -> bool:
        """Return whether a flag is set in any process; all processes get the same result."""
        if self._fabric.world_size == 1:
            return flag
        return bool(self._summed({"flag": float(flag)})["flag"])

    def _epoch(self) -> list[np.ndarray]:
        """Return the frame indices of each batch of the current epoch."""
        training, settings = self._split.training, self._settings
        batches = epoch_batches(
            self._loader.counts[training],
            settings.batch,
            seed=settings.seed,
            epoch=self.progress.epoch,
        )
        least = self._fabric.world_size
        return [training[batch] for batch in batches if len(batch) >= least]

    def _step(self, batch: Tensors, where: str) -> dict[str, float]:
        losses = self._learner.loss(self._forward, batch)
        self.optimizer.zero_grad()
        loss = next(iter(losses.values()))
        self._fabric.backward(loss)
        norm = self._fabric.clip_gradients(
            self._model,
            self._stepper,
            max_norm=self._settings.clip,
            error_if_nonfinite=False,
        )
        # The norm is the same in all processes, so all of them stop.
        if norm is not None and not math.isfinite(float(norm)):
            message = f"the loss was {float(loss.detach()):g}, its gradient's norm {float(norm):g}"
            raise DivergedError(f"{message}, at {where}")
        self._stepper.step()
        return {name: float(value.detach()) for name, value in losses.items()}

    def _validate(self) -> dict[str, float]:
        """Return the sums of losses over this process's share of the validation frames."""
        sums = dict.fromkeys(self.progress.sums, 0.0)
        size = 2 * self._settings.batch
        frames = self._split.validation[self._fabric.global_rank :: self._fabric.world_size]
        parts = [frames[at : at + size] for at in range(0, len(frames), size)]
        self._model.eval()
        with torch.no_grad():
            for chosen, batch in zip(parts, self._loader.batches(parts), strict=True):
                losses = self._learner.loss(self._forward, self._moved(batch))
                values = {name: float(value) for name, value in losses.items()}
                _add(sums, values, len(chosen))
        return sums

    def _moved(self, batch: Tensors) -> Tensors:
        device = self._fabric.device
        if device.type == "cpu":
            return batch
        return {name: values.to(device) for name, values in batch.items()}

    def _summed(self, sums: Mapping[str, float]) -> dict[str, float]:
        if self._fabric.world_size == 1 or not sums:
            return dict(sums)
        values = torch.tensor(list(sums.values()), device=self._fabric.device)
        total = self._fabric.all_reduce(values, reduce_op="sum")
        found = total.tolist() if isinstance(total, Tensor) else list(sums.values())
        return dict(zip(sums, found, strict=True))


class _Forward:
    """The network as `Learner.loss` calls it; `bfloat16` sets the type of matrix products."""

    def __init__(self, model: nn.Module, device: str, *, bfloat16: bool) -> None:
        self._model, self._device, self._bfloat16 = model, device, bfloat16

    @property
    def training(self) -> bool:
        """True in training, False in validation."""
        return self._model.training

    def __call__(self, *inputs: Any) -> Any:
        """Run a forward pass."""
        with torch.autocast(self._device, torch.bfloat16, enabled=self._bfloat16):
            return self._model(*inputs)


def optimizer_of(network: nn.Module, settings: TrainingSettings) -> torch.optim.AdamW:
    """Return AdamW with weight decay for the weights of linear layers only."""
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


def _add(sums: dict[str, float], losses: Mapping[str, float], count: int) -> None:
    for name, value in ((SAMPLES, 1.0), *losses.items()):
        sums[name] = sums.get(name, 0.0) + value * count


def _step_seed(seed: int, epoch: int, step: int, rank: int) -> int:
    state = np.random.SeedSequence((seed, epoch, step, rank)).generate_state(1, np.uint64)
    return int(state[0] >> np.uint64(1))
