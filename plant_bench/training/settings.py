"""How to train; the defaults are the paper's."""

from dataclasses import dataclass
from typing import Literal

from plant_bench.training.samples import TargetKind

Precision = Literal["bf16-mixed", "32-true"]


def drop_after(epochs: int) -> int:
    """Return after how many of so many epochs the rate falls: 45 of 47, as in the paper."""
    return round(epochs * 45 / 47)


@dataclass(frozen=True)
class TrainingSettings:
    """All that decides a training's numbers, apart from data and network.

    Attributes:
        epochs: 47 (PlanT, "Implementation").
        drop_after: Epochs after which the rate is a tenth: 45 (as above).
        batch: Samples a step, over all processes: 128 (as above).
        rate: Learning rate: 1e-4 (as above).
        betas: Of AdamW (PlanT, lit_module.py).
        weight_decay: Of the weights of linear layers: 0.1 (PlanT, "Implementation").
        clip: Largest norm of the gradient: 1.0 (as above).
        auxiliary: Lambda, weight of the others' future: 0.2 (as above).
        caution: Weight of waypoints too far ahead, see `losses_of`: 1 (equation 3).
        seed: Of weights, order, dropout and the choice of routes held out.
        resting: Share that is learnt from of the samples in which the ego stands and stays.
        held_out: Share of the routes held out for validation.
        precision: Of the encoder's arithmetic.
        targets: What the waypoints are: where the ego went, as PlanT, or where the expert's answer
            leads, see `samples_of`.
        validate_every: Epochs between two closed-loop validations; 0 for none.
        patience: Validations without a better score after which the training ends; 0 for never.
    """

    epochs: int = 47
    drop_after: int = 45
    batch: int = 128
    rate: float = 1e-4
    betas: tuple[float, float] = (0.9, 0.95)
    weight_decay: float = 0.1
    clip: float = 1.0
    auxiliary: float = 0.2
    caution: float = 1.0
    seed: int = 0
    resting: float = 1.0
    held_out: float = 0.1
    precision: Precision = "bf16-mixed"
    targets: TargetKind = "future"
    validate_every: int = 0
    patience: int = 0

    def rate_of(self, epoch: int) -> float:
        """Return an epoch's learning rate; epochs count from 0."""
        return self.rate if epoch < self.drop_after else 0.1 * self.rate
