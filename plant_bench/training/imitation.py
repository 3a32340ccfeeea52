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
from plant_bench.training.checkpoint import broken_checkpoint, load_checkpoint, save_checkpoint
from plant_bench.training.closed_loop import ClosedLoop, closed_loop_score
from plant_bench.training.code_keys import closure_hash
from plant_bench.training.events import Driving, EpochEnded, Listener
from plant_bench.training.graceful_interrupt import stop_wish
from plant_bench.training.history import DRIVING_SCORE, History
from plant_bench.training.initial_weights import state_to_start_from
from plant_bench.training.learners import Student
from plant_bench.training.loader import Loader
from plant_bench.training.settings import TrainingSettings
from plant_bench.training.trainer import Trainer

CHECKPOINT_EVERY = 300.0  # s, besides that at the end of each epoch
LONGEST_WAIT = timedelta(days=2)  # of the other processes, while the first one drives validations
CARD_FILE = "card.md"


@dataclass(frozen=True)
class TrainingRequest:
    """Request of a training.

    Attributes:
        student: The learner and its options.
        settings: The training settings.
        out: Folder for the finished model.
        work: Folder for checkpoint, logs and validation runs.
        closed_loop: What to drive for validation; None where `validate_every` is 0.
        overwrite: Start anew even if there is a checkpoint.
        start: Folder of the weights to start from, if not from chance.
        sources: Where the data comes from, a text a folder, for the card.
    """

    student: Student
    settings: TrainingSettings
    out: Path
    work: Path
    closed_loop: ClosedLoop | None = None
    overwrite: bool = False
    start: Path | None = None
    sources: tuple[str, ...] = ()


def make_fabric(*, accelerator: str, devices: int) -> Fabric:
    """Return a launched Fabric; with several devices this starts the other processes.

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
    """Train to the end, or until Ctrl-C; the same request goes on where it was stopped.

    The end is the last epoch, or, where the settings know patience, when it is at an end.

    Args:
        request: What to train.
        split: On what.
        loader: Gives batches of it; still open at the end.
        fabric: Launched.
        listen: Told what happens, in the first process only.

    Raises:
        InputError: A folder cannot be used, or holds another training.
        KeyboardInterrupt: The user wished to stop; the checkpoint is written.
    """
    learner = request.student.learner()
    trainer = Trainer(fabric, learner, request.settings, split, loader)
    if request.start is not None:
        state = state_to_start_from(learner, request.start)
        fill(trainer.network, state, request.start)
    keeper = _Keeper(request, split, trainer, fabric)
    keeper.take_up()
    with stop_wish() as wish:
        over = trainer.any_wants(keeper.is_over)
        while not over:
            for _ in trainer.steps(listen if fabric.is_global_zero else _silent):
                if trainer.any_wants(wish.wanted):
                    keeper.save()
                    raise KeyboardInterrupt
                keeper.save_now_and_then()
            row = trainer.end_epoch()
            if fabric.is_global_zero:
                keeper.end_epoch(row, listen)
            fabric.barrier()
            keeper.save()
            over = trainer.any_wants(keeper.is_over)
            if trainer.any_wants(wish.wanted) and not over:
                raise KeyboardInterrupt
    if fabric.is_global_zero:
        keeper.finish()


class _Keeper:
    """Keeps what a training leaves on disk; changes with each epoch."""

    def __init__(
        self, request: TrainingRequest, split: Split, trainer: Trainer, fabric: Fabric
    ) -> None:
        self._request, self._split, self._trainer = request, split, trainer
        self._fabric, self._learner = fabric, request.student.learner()
        self._saved_at = time.monotonic()
        self._history: History | None = None
        self._best = request.work / "best"

    @property
    def is_over(self) -> bool:
        """Whether there is nothing left to train; the first process alone knows all scores."""
        settings, progress = self._request.settings, self._trainer.progress
        return progress.epoch >= settings.epochs or self._is_out_of_patience

    @property
    def _is_out_of_patience(self) -> bool:
        patience = self._request.settings.patience
        return 0 < patience <= self._trainer.progress.validations_since_best

    def take_up(self) -> None:
        """Go on from the checkpoint if there is one; otherwise start anew."""
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
                )  # they are the first process's
        if self._fabric.is_global_zero:
            self._history = History(work)

    def save(self) -> None:
        """Write the checkpoint."""
        self._saved_at = time.monotonic()
        if self._fabric.is_global_zero:
            trainer = self._trainer
            states = trainer.network.state_dict(), trainer.optimizer.state_dict()
            save_checkpoint(self._request.work, trainer.progress, self._identity(), *states)

    def save_now_and_then(self) -> None:
        """Write the checkpoint if the last one is old."""
        if time.monotonic() - self._saved_at > CHECKPOINT_EVERY:
            self.save()

    def end_epoch(self, row: dict[str, float], listen: Listener) -> None:
        """Validate by driving if it is time, and write the history."""
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
        """Write the model: the best that was driven, or else the last."""
        request, progress = self._request, self._trainer.progress
        chosen = f"These are the weights of the last epoch, {progress.epoch}."
        if progress.best is None:
            self._write(request.out)
        else:
            score, epoch = progress.best
            chosen = (
                f"These are the weights of epoch {epoch}, the best of those that were driven: "
                f"DS {score:.1f} on the validation routes."
            )
            if self._is_out_of_patience:
                chosen += f" The training ended after epoch {progress.epoch}: no better came."
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

    def _write(self, folder: Path) -> None:
        learner, network = self._learner, self._trainer.network
        save_model(learner.name, learner.config, network.state_dict(), folder)

    def _identity(self) -> dict[str, Any]:
        """Return what makes two trainings the same, as plain values."""
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
