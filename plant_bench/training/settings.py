"""Training settings common to all learners, such as epochs and learning rate; paper's defaults."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any

from plant_bench.training.frames import TargetKind


def drop_after(epochs: int) -> int:
    """Return the number of epochs before the learning rate drops: 45 of 47, as in the paper."""
    return round(epochs * 45 / 47)


@dataclass(frozen=True)
class TrainingSettings:
    """All settings that affect the trained weights, apart from data and learner.

    Attributes:
        epochs: Passes over the data (PlanT, "Implementation").
        drop_after: Epochs before the learning rate drops to a tenth. Default: 45 of 47 (PlanT,
            "Implementation").
        batch: Samples per step, over all devices (PlanT, "Implementation").
        rate: Learning rate (PlanT, "Implementation").
        betas: Betas of AdamW (PlanT, lit_module.py).
        weight_decay: Weight decay of linear layers (PlanT, "Implementation").
        clip: Maximum norm of the gradient (PlanT, "Implementation").
        seed: Seed of initial weights, sample order, dropout and held-out routes.
        stationary_fraction: Fraction of the samples with a stationary ego to keep (those in which
            it is stationary and stays so).
        held_out: Share of the routes held out for validation.
        full_precision: Multiply matrices in float32 instead of bfloat16.
        targets: Waypoints to learn: the driven path (PlanT), or the path that results if the
            expert's acceleration is held constant.
        validate_every: Epochs between closed-loop validations; 0 for none.
        patience: Stop after this many validations without a better score; 0 to never stop early.
    """

    epochs: int = field(default=47, metadata={"min": 1, "max": 1_000_000})
    drop_after: int | None = field(default=None, metadata={"min": 0, "max": 1_000_000})
    batch: int = field(default=128, metadata={"min": 1, "max": 1_000_000})
    rate: float = field(default=1e-4, metadata={"min": 1e-12, "max": 1e6})
    betas: tuple[float, float] = field(default=(0.9, 0.95), metadata={"min": 0.0, "max": 0.999999})
    weight_decay: float = field(default=0.1, metadata={"min": 0.0, "max": 1e6})
    clip: float = field(default=1.0, metadata={"min": 0.0, "max": 1e6})
    seed: int = field(default=0, metadata={"min": 0, "max": 2**31 - 1})
    stationary_fraction: float = field(default=1.0, metadata={"min": 0.0, "max": 1.0})
    held_out: float = field(default=0.1, metadata={"min": 0.0, "max": 0.9})
    full_precision: bool = False
    targets: TargetKind = "future"
    validate_every: int = field(default=0, metadata={"min": 0, "max": 1_000_000})
    patience: int = field(default=0, metadata={"min": 0, "max": 1_000_000})

    @property
    def drop(self) -> int:
        """Number of epochs before the learning rate drops."""
        return drop_after(self.epochs) if self.drop_after is None else self.drop_after

    @property
    def recipe(self) -> Mapping[str, Any]:
        """Settings that must be equal to resume; the length may change, to extend a training."""
        values = asdict(self) | {"drop_after": self.drop}
        return {name: value for name, value in values.items() if name not in _LENGTH}

    def rate_of(self, epoch: int) -> float:
        """Return the learning rate of an epoch, counted from 0."""
        return self.rate if epoch < self.drop else 0.1 * self.rate


_LENGTH = frozenset({"epochs", "patience"})
