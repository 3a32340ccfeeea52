"""Training checkpoints: everything needed to resume a training with identical results."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter

from plant_bench.atomic_files import write_whole
from plant_bench.errors import InputError, in_one_line
from plant_bench.training.tensor_tree import load_tree, save_tree

CHECKPOINT_FORMAT = 3
CHECKPOINT_FILE = "checkpoint.safetensors"
SAMPLES = "/samples"  # key in `Progress.sums`: number of samples; cannot be the name of a loss
PICKLED_FILE = "checkpoint.pt"  # written by earlier versions; not read, since a pickle can run code


@dataclass
class Progress:
    """Progress of a training; mutable.

    Attributes:
        epoch: The current epoch, from 0.
        step: Number of finished steps of this epoch.
        sums: Sums over this epoch's steps: `SAMPLES`, and the losses by name.
        history: One row per finished epoch, see `Trainer`.
        best: Score and epoch of the best closed-loop validation.
    """

    epoch: int = 0
    step: int = 0
    sums: dict[str, float] = field(default_factory=dict)
    history: list[dict[str, float]] = field(default_factory=list)
    best: tuple[float, int] | None = None

    @property
    def validations_since_best(self) -> int:
        """Closed-loop validations since the first one with the highest score; 0 without any."""
        scores = [row["driving_score"] for row in self.history if "driving_score" in row]
        return len(scores) - 1 - scores.index(max(scores)) if scores else 0


def save_checkpoint(
    folder: Path,
    progress: Progress,
    identity: dict[str, Any],
    network: dict[str, Any],
    optimizer: dict[str, Any],
) -> None:
    """Write a checkpoint atomically.

    Args:
        folder: Output folder.
        progress: Progress of the training.
        identity: Values that must be equal in a training that resumes from it.
        network: State of the network.
        optimizer: State of the optimiser.
    """
    payload = {
        "format": CHECKPOINT_FORMAT,
        "progress": vars(progress),
        "identity": identity,
        "network": network,
        "optimizer": optimizer,
    }
    write_whole(folder / CHECKPOINT_FILE, lambda part: save_tree(payload, part))


def load_checkpoint(
    folder: Path, identity: dict[str, Any]
) -> tuple[Progress, dict[str, Any], dict[str, Any]] | None:
    """Return progress and the states of network and optimiser; None if there is no checkpoint.

    Args:
        folder: Folder of the checkpoint.
        identity: See `save_checkpoint`.

    Raises:
        InputError: The checkpoint is broken, or of a training with other settings or data.
    """
    path = folder / CHECKPOINT_FILE
    if not path.is_file():
        if (folder / PICKLED_FILE).is_file():
            message = "a pickle of an earlier version, which is no longer supported"
            raise _broken(folder / PICKLED_FILE, ValueError(message))
        return None
    try:
        payload = load_tree(path)
        if payload["format"] != CHECKPOINT_FORMAT:
            message = f"expected format {CHECKPOINT_FORMAT}, got {payload['format']}"
            raise ValueError(message)
        earlier, states = payload["identity"], (payload["network"], payload["optimizer"])
        progress = TypeAdapter(Progress).validate_python(payload["progress"])
        earlier = dict(earlier)
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise _broken(path, error) from error
    other = [
        f"{name} {earlier.get(name)} (now {value})"
        for name, value in identity.items()
        if earlier.get(name) != value
    ]
    if other:
        message = (
            f"{path} is of another training: {', '.join(other)}. Use the same settings, another "
            "--out, or --overwrite to start anew."
        )
        raise InputError(message)
    return progress, *states


def broken_checkpoint(folder: Path, error: Exception) -> InputError:
    """Return the error for a checkpoint whose states do not fit the network."""
    return _broken(folder / CHECKPOINT_FILE, error)


def _broken(path: Path, error: Exception) -> InputError:
    reason = in_one_line(error) or type(error).__name__
    return InputError(f"Broken checkpoint: {path} ({reason}). Use --overwrite to start anew.")
