"""Imitation learning: the complete training, from batches to a model folder."""

import json
import shutil
import time
from dataclasses import dataclass
from datetime import timedelta
from functools import partial
from pathlib import Path
from typing import Any

import torch
from lightning_fabric import Fabric
from lightning_fabric.strategies.ddp import DDPStrategy

from plant_bench.atomic_files import write_whole, write_whole_text
from plant_bench.errors import InputError
from plant_bench.model_folder import CONFIG_FILE, WEIGHTS_FILE, fill, save_model, weights_hash
from plant_bench.runner.run.provenance import command_line
from plant_bench.training.batches import Split
from plant_bench.training.card import Origin, model_card
from plant_bench.training.checkpoint import (
    CHECKPOINT_FILE,
    broken_checkpoint,
    load_checkpoint,
    save_checkpoint,
)
from plant_bench.training.closed_loop import ClosedLoop, closed_loop_score
from plant_bench.training.code_keys import closure_hash
from plant_bench.training.divergence import DivergedError, TrainingError
from plant_bench.training.events import Driving, EpochEnded, Listener
from plant_bench.training.graceful_interrupt import stop_on_interrupt
from plant_bench.training.history import DRIVING_SCORE, History
from plant_bench.training.initial_weights import state_to_start_from
from plant_bench.training.learners import LearnerSpec
from plant_bench.training.loader import Loader
from plant_bench.training.settings import TrainingSettings
from plant_bench.training.trainer import Trainer

CHECKPOINT_EVERY = 300.0  # s between checkpoints, in addition to one at the end of each epoch
LONGEST_WAIT = timedelta(days=2)  # timeout of the processes that wait for a validation run
CARD_FILE = "card.md"


@dataclass(frozen=True)
class TrainingRequest:
    """Settings of a training.

    Attributes:
        learner: The learner and its options.
        settings: The training settings.
        out: Folder for the finished model.
        work: Folder for checkpoint, logs and validation runs.
        closed_loop: What to drive for validation; None where `validate_every` is 0.
        overwrite: Start anew even if there is a checkpoint.
        start: Model folder with the initial weights; None for random ones.
        sources: Origin of the data for the card, one text per data folder.
    """

    learner: LearnerSpec
    settings: TrainingSettings
    out: Path
    work: Path
    closed_loop: ClosedLoop | None = None
    overwrite: bool = False
    start: Path | None = None
    sources: tuple[str, ...] = ()


def make_fabric(*, accelerator: str, devices: int) -> Fabric:
    """Launch Fabric; with several devices this starts the other processes.

    Raises:
        InputError: There is no such accelerator, or it cannot be used.
    """
    try:
        fabric = Fabric(
            accelerator=accelerator,
            devices=devices,
            strategy="auto" if devices == 1 else DDPStrategy(timeout=LONGEST_WAIT),
            precision="32-true",  # "bf16-mixed" would round the inputs too: see Trainer
        )
        fabric.launch()
    except (ValueError, RuntimeError, ImportError) as error:
        message = f"Cannot train on {devices} x '{accelerator}': {error}"
        raise InputError(message) from error
    return fabric


def train(
    request: TrainingRequest, split: Split, loader: Loader, fabric: Fabric, listen: Listener
) -> None:
    """Train to the end or until Ctrl-C; the same request resumes an interrupted training.

    A training ends after its last epoch, or after `patience` validations without a better score.

    Args:
        request: What to train.
        split: The data.
        loader: Loads batches of `split.frames`; is not closed.
        fabric: A launched Fabric.
        listen: Called with each event, in the first process only.

    Raises:
        InputError: A folder cannot be used, or holds another training.
        TrainingError: The loss is not finite.
        KeyboardInterrupt: The training was interrupted; the checkpoint is written.
    """
    learner = request.learner.build()
    trainer = Trainer(fabric, learner, request.settings, split, loader)
    if request.start is not None:
        state = state_to_start_from(learner, request.start)
        fill(trainer.network, state, request.start)
    output = _TrainingOutput(request, split, trainer, fabric)
    output.resume()
    try:
        _run_epochs(trainer, output, fabric, listen)
    except DivergedError as error:
        raise output.diverged(error) from None
    if fabric.is_global_zero:
        output.finish()


def _run_epochs(
    trainer: Trainer, output: "_TrainingOutput", fabric: Fabric, listen: Listener
) -> None:
    with stop_on_interrupt() as stop:
        over = trainer.any_process(output.is_finished)
        while not over:
            for _ in trainer.steps(listen if fabric.is_global_zero else _silent):
                if trainer.any_process(stop.requested):
                    output.save()
                    raise KeyboardInterrupt
                output.save_if_due()
            row = trainer.end_epoch()
            if fabric.is_global_zero:
                output.end_epoch(row, listen)
            fabric.barrier()
            output.save()
            over = trainer.any_process(output.is_finished)
            if trainer.any_process(stop.requested) and not over:
                raise KeyboardInterrupt


class _TrainingOutput:
    """The files of a training: checkpoint, history, best weights and model; mutable."""

    def __init__(
        self, request: TrainingRequest, split: Split, trainer: Trainer, fabric: Fabric
    ) -> None:
        self._request, self._split, self._trainer = request, split, trainer
        self._fabric, self._learner = fabric, request.learner.build()
        self._saved_at = time.monotonic()
        self._history: History | None = None
        self._best = request.work / "best"

    @property
    def is_finished(self) -> bool:
        """Whether the training has ended; only the first process knows all scores."""
        settings, progress = self._request.settings, self._trainer.progress
        return progress.epoch >= settings.epochs or self._is_out_of_patience

    @property
    def _is_out_of_patience(self) -> bool:
        patience = self._request.settings.patience
        return 0 < patience <= self._trainer.progress.validations_since_best

    def resume(self) -> None:
        """Resume from the checkpoint if there is one; otherwise start anew."""
        work = self._request.work
        if self._request.overwrite and self._fabric.is_global_zero:
            shutil.rmtree(work, ignore_errors=True)
        self._fabric.barrier()
        found = load_checkpoint(work, self._identity())
        if found is not None:
            self._trainer.progress, network, optimizer = found
            try:
                self._trainer.network.load_state_dict(network)
                self._trainer.optimizer.load_state_dict(optimizer)
            except (RuntimeError, ValueError, KeyError, TypeError, AttributeError) as error:
                raise broken_checkpoint(work, error) from error
            if not self._fabric.is_global_zero:
                self._trainer.progress.sums = dict.fromkeys(
                    self._trainer.progress.sums, 0.0
                )  # the checkpoint's sums count once, in the first process
        if self._fabric.is_global_zero:
            self._history = History(work)

    def save(self) -> None:
        """Write the checkpoint."""
        self._saved_at = time.monotonic()
        if self._fabric.is_global_zero:
            trainer = self._trainer
            states = trainer.network.state_dict(), trainer.optimizer.state_dict()
            save_checkpoint(self._request.work, trainer.progress, self._identity(), *states)

    def save_if_due(self) -> None:
        """Write the checkpoint if `CHECKPOINT_EVERY` seconds have passed since the last one."""
        if time.monotonic() - self._saved_at > CHECKPOINT_EVERY:
            self.save()

    def end_epoch(self, row: dict[str, float], listen: Listener) -> None:
        """Run the closed-loop validation if it is due, and write the history."""
        request, progress = self._request, self._trainer.progress
        every, drive = request.settings.validate_every, request.closed_loop
        last = progress.epoch == request.settings.epochs
        if drive is not None and every and (progress.epoch % every == 0 or last):
            listen(Driving(progress.epoch - 1))
            candidate = request.work / "candidate"
            self._write(candidate)
            run = request.work / "validation" / f"epoch-{progress.epoch:03d}"
            score = closed_loop_score(f"{self._learner.agent}@{candidate}", run, drive)
            row[DRIVING_SCORE] = score
            if progress.best is None or score >= progress.best[0]:
                progress.best = (score, progress.epoch)
                self._write(self._best)
        event = EpochEnded(progress.epoch - 1, row)
        if self._history is not None:
            self._history.add(event, progress.history)
        listen(event)

    def finish(self) -> None:
        """Write the model: the best validated weights, or the last ones without validation."""
        request, progress = self._request, self._trainer.progress
        chosen = f"These are the weights of the last epoch, {progress.epoch}."
        if progress.best is None:
            self._write(request.out)
        else:
            score, epoch = progress.best
            chosen = (
                f"These are the weights of epoch {epoch}, which had the best driving score in "
                f"closed-loop validation: DS {score:.1f}."
            )
            if self._is_out_of_patience:
                chosen += f" The training ended after epoch {progress.epoch} (early stopping)."
            for name in (CONFIG_FILE, WEIGHTS_FILE):
                write_whole(request.out / name, partial(shutil.copyfile, self._best / name))
        self._learner.export(request.out)
        card = model_card(
            request.out.name,
            self._learner,
            self._trainer.network,
            request.settings,
            self._split,
            progress.history,
            Origin(chosen, command_line(), request.sources, self._start()),
        )
        write_whole_text(request.out / CARD_FILE, card)
        if self._history is not None:
            self._history.close()

    def diverged(self, error: DivergedError) -> TrainingError:
        """Return the error of a training that cannot go on."""
        work = self._request.work
        kept = "No weights were kept"
        if (work / CHECKPOINT_FILE).is_file():
            kept = f"The weights of the last checkpoint are kept in {work / CHECKPOINT_FILE}"
        message = (
            f"The training diverged: {error}. {kept}, and no model was written. Try a lower --rate "
            f"than {self._request.settings.rate:g}, with --overwrite to start anew."
        )
        return TrainingError(message)

    def _write(self, folder: Path) -> None:
        learner, network = self._learner, self._trainer.network
        save_model(learner.name, learner.config, network.state_dict(), folder)

    def _identity(self) -> dict[str, Any]:
        """Return the values that must be equal in a resumed training, as plain JSON types."""
        parts = {
            "learner": self._learner.name,
            "code": closure_hash(type(self._learner).__module__),
            "data": self._split.fingerprint,
            "processes": self._fabric.world_size,
            "torch": str(torch.__version__),
            "start": self._start(),
            **self._learner.recipe,
            **self._request.settings.recipe,
        }
        return json.loads(json.dumps(parts, default=str))

    def _start(self) -> str:
        start = self._request.start
        return "" if start is None else weights_hash(start)


def _silent(_event: object) -> None:
    """Ignore the event."""
