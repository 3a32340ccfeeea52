"""The history of a training: `losses.csv` always, TensorBoard's files where it is installed."""

import csv
import importlib.util
from pathlib import Path

from plant_bench.training.events import EpochEnded
from plant_bench.whole_files import whole_file

COLUMNS: tuple[str, ...] = (
    "epoch",
    "rate",
    "train_waypoints",
    "train_vehicles",
    "valid_waypoints",
    "valid_vehicles",
    "driving_score",
)
NO_TENSORBOARD = (
    "TensorBoard is not installed: losses go to losses.csv only. For its logs: "
    "pip install tensorboard"
)


def has_tensorboard() -> bool:
    """Tell whether TensorBoard's files can be written."""
    return importlib.util.find_spec("tensorboard") is not None


class History:
    """Writes each epoch's row; mutable.

    Args:
        folder: Where to.
    """

    def __init__(self, folder: Path) -> None:
        folder.mkdir(parents=True, exist_ok=True)
        self._path = folder / "losses.csv"
        self._writer = None
        if has_tensorboard():
            from torch.utils.tensorboard import SummaryWriter

            self._writer = SummaryWriter(str(folder / "tensorboard"))

    def add(self, event: EpochEnded, history: list[dict[str, float]]) -> None:
        """Write the rows of all epochs so far, and the last one's to TensorBoard."""
        with whole_file(self._path) as part, part.open("w", encoding="utf-8", newline="") as file:
            table = csv.DictWriter(file, COLUMNS, lineterminator="\n")
            table.writeheader()
            table.writerows(history)
        if self._writer is not None:
            for name in COLUMNS[1:]:
                if name in event.row:
                    self._writer.add_scalar(name, event.row[name], event.epoch + 1)
            self._writer.flush()

    def close(self) -> None:
        """Close the files."""
        if self._writer is not None:
            self._writer.close()
