"""A training half way: everything needed to go on as if nothing had happened."""

import pickle
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import torch

from plant_bench.errors import InputError

CHECKPOINT_FORMAT = 1
CHECKPOINT_FILE = "checkpoint.pt"


@dataclass
class Progress:
    """Where a training is; mutable.

    Attributes:
        epoch: The epoch it is in, from 0.
        step: Steps of this epoch that are done.
        sums: Sums over this epoch's steps: samples, waypoint loss and vehicle loss.
        history: A row for each finished epoch, see `Trainer`.
        best: Score and epoch of the best closed-loop validation.
    """

    epoch: int = 0
    step: int = 0
    sums: list[float] = field(default_factory=lambda: [0.0, 0.0, 0.0])
    history: list[dict[str, float]] = field(default_factory=list)
    best: tuple[float, int] | None = None

    @property
    def validations_since_best(self) -> int:
        """Closed-loop validations since the first of the highest score; 0 where there was none."""
        scores = [row["driving_score"] for row in self.history if "driving_score" in row]
        return len(scores) - 1 - scores.index(max(scores)) if scores else 0


def save_checkpoint(
    folder: Path,
    progress: Progress,
    identity: dict[str, Any],
    network: dict[str, Any],
    optimizer: dict[str, Any],
) -> None:
    """Write a checkpoint, whole or not at all.

    Args:
        folder: Where to.
        progress: Where the training is.
        identity: What must be equal for another command to go on with it.
        network: State of the network.
        optimizer: State of the optimiser.
    """
    folder.mkdir(parents=True, exist_ok=True)
    payload = {
        "format": CHECKPOINT_FORMAT,
        "progress": vars(progress),
        "identity": identity,
        "network": network,
        "optimizer": optimizer,
    }
    part = folder / f"{CHECKPOINT_FILE}.part"
    torch.save(payload, part)
    part.replace(folder / CHECKPOINT_FILE)


def load_checkpoint(
    folder: Path, identity: dict[str, Any]
) -> tuple[Progress, dict[str, Any], dict[str, Any]] | None:
    """Return progress and the states of network and optimiser, None where there is no checkpoint.

    Raises:
        InputError: It is broken, or of a training with other settings or data.
    """
    path = folder / CHECKPOINT_FILE
    if not path.is_file():
        return None
    try:
        payload = torch.load(path, map_location="cpu", weights_only=True)
        if payload["format"] != CHECKPOINT_FORMAT:
            message = f"format {CHECKPOINT_FORMAT} is wanted"
            raise ValueError(message)
        earlier, states = payload["identity"], (payload["network"], payload["optimizer"])
        progress = Progress(**payload["progress"])
    except (OSError, RuntimeError, ValueError, KeyError, TypeError, EOFError) as error:
        raise _broken(path, error) from error
    except pickle.UnpicklingError as error:
        raise _broken(path, error) from error
    other = [
        f"{name} {earlier.get(name)} (now {value})"
        for name, value in identity.items()
        if earlier.get(name) != value
    ]
    if other:
        message = (
            f"{path} is of another training: {', '.join(other)}. Ask for the same, choose another "
            "--out, or give --overwrite to start anew."
        )
        raise InputError(message)
    return progress, *states


def _broken(path: Path, error: Exception) -> InputError:
    reason = str(error).splitlines()[0] if str(error) else type(error).__name__
    return InputError(f"Broken checkpoint: {path} ({reason}). Give --overwrite to start anew.")
