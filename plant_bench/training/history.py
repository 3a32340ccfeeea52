"""Writes the history of a training: `losses.csv`, and TensorBoard files if it is installed."""

import csv
import importlib.util
from pathlib import Path

from plant_bench.atomic_files import whole_file
from plant_bench.training.events import EpochEnded

DRIVING_SCORE = "driving_score"  # the last column
NO_TENSORBOARD = (
    "TensorBoard is not installed: losses go to losses.csv only. For its logs: "
    "pip install tensorboard"
)


def has_tensorboard() -> bool:
    """Return whether TensorBoard is installed."""
    return importlib.util.find_spec("tensorboard") is not None


def columns_of(history: list[dict[str, float]]) -> list[str]:
    """Return the columns of a history: epoch, rate, the losses, and the driving score last.

    >>> columns_of([{"epoch": 1.0, "train_x": 0.5}, {"epoch": 2.0, "driving_score": 3.0}])
    ['epoch', 'train_x', 'driving_score']
    """
    names = dict.fromkeys(name for row in history for name in row)
    return [name for name in names if name != DRIVING_SCORE] + [DRIVING_SCORE]


class History:
    """Writes the rows of finished epochs; mutable.

    Args:
        folder: Output folder.
    """

    def __init__(self, folder: Path) -> None:
        folder.mkdir(parents=True, exist_ok=True)
        self._path = folder / "losses.csv"
        self._writer = None
        if has_tensorboard():
            from torch.utils.tensorboard import SummaryWriter

            self._writer = SummaryWriter(str(folder / "tensorboard"))

    def add(self, event: EpochEnded, history: list[dict[str, float]]) -> None:
        """Rewrite `losses.csv` with all rows, and log the new one to TensorBoard."""
        with whole_file(self._path) as part, part.open("w", encoding="utf-8", newline="") as file:
            table = csv.DictWriter(file, columns_of(history), lineterminator="\n")
            table.writeheader()
            table.writerows(history)
        if self._writer is not None:
            for name, value in event.row.items():
                if name != "epoch":
                    self._writer.add_scalar(name, value, event.epoch + 1)
            self._writer.flush()

    def close(self) -> None:
        """Close the files."""
        if self._writer is not None:
            self._writer.close()
