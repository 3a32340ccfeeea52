"""Training settings: epochs, learning rate, batch size and others; defaults are the paper's."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any

from plant_bench.training.frames import TargetKind


def drop_after(epochs: int) -> int:
    """Return after how many of so many epochs the rate falls: 45 of 47, as in the paper."""
    return round(epochs * 45 / 47)


@dataclass(frozen=True)
class TrainingSettings:
    """All that decides a training's numbers, apart from data and learner; sources are PlanT's.

    Attributes:
        epochs: Passes over the data (PlanT, "Implementation").
        drop_after: Epochs before the rate falls to a tenth; 45 of 47 without it (as above).
        batch: Samples a step, over all devices (as above).
        rate: Learning rate (as above).
        betas: Of AdamW (PlanT, lit_module.py).
        weight_decay: Of the weights of linear layers (PlanT, "Implementation").
        clip: Largest norm of the gradient (as above).
        seed: Of weights, order, dropout and held-out routes.
        stationary_fraction: Share kept of samples in which the ego is and stays stationary.
        held_out: Share of the routes kept for validation.
        full_precision: float32 instead of bfloat16, in which matrices are multiplied otherwise.
        targets: Learn where the ego went (as PlanT), or where the expert's acceleration leads.
        validate_every: Epochs between closed-loop validations; 0 for none.
        patience: Validations without a better score that end it; 0 for none.
    """

    epochs: int = field(default=47, metadata={"min": 1})
    drop_after: int | None = field(default=None, metadata={"min": 0})
    batch: int = field(default=128, metadata={"min": 1})
    rate: float = 1e-4
    betas: tuple[float, float] = (0.9, 0.95)
    weight_decay: float = field(default=0.1, metadata={"min": 0.0})
    clip: float = field(default=1.0, metadata={"min": 0.0})
    seed: int = field(default=0, metadata={"min": 0})
    stationary_fraction: float = field(default=1.0, metadata={"min": 0.0, "max": 1.0})
    held_out: float = field(default=0.1, metadata={"min": 0.0, "max": 0.9})
    full_precision: bool = False
    targets: TargetKind = "future"
    validate_every: int = field(default=0, metadata={"min": 0})
    patience: int = field(default=0, metadata={"min": 0})

    @property
    def drop(self) -> int:
        """Epochs after which the rate is a tenth."""
        return drop_after(self.epochs) if self.drop_after is None else self.drop_after

    @property
    def recipe(self) -> Mapping[str, Any]:
        """What decides the weights: a longer training goes on from a shorter one."""
        values = asdict(self) | {"drop_after": self.drop}
        return {name: value for name, value in values.items() if name not in _LENGTH}

    def rate_of(self, epoch: int) -> float:
        """Return an epoch's learning rate; epochs count from 0."""
        return self.rate if epoch < self.drop else 0.1 * self.rate


_LENGTH = frozenset({"epochs", "patience"})
