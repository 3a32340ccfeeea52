"""PlanT's loss (equation 3): L1 of waypoints, cross-entropy over bins of actors' futures."""

from collections.abc import Sequence
from dataclasses import dataclass

import torch
from jaxtyping import Float, Int
from torch import Tensor
from torch.nn import functional

from plant_bench.agents.plant.config import Bins
from plant_bench.agents.plant.network import Output

IGNORED = -100  # class index without a loss


@dataclass(frozen=True, eq=False, slots=True)
class Targets:
    """The targets of a batch.

    Attributes:
        waypoints: Positions in the ego frame, metres.
        futures: The tokens' attributes half a second later; NaN where there is no target.
    """

    waypoints: Float[Tensor, "batch waypoints 2"]
    futures: Float[Tensor, "batch tokens 6"]


@dataclass(frozen=True, eq=False, slots=True)
class Losses:
    """The parts of equation 3, as means over the batch.

    Attributes:
        waypoints: L1 distance: sum over x and y, mean over the waypoints, metres.
        vehicles: Cross-entropy: sum over the six attributes, mean over each scene's actors; 0 if
            there are none.
    """

    waypoints: Float[Tensor, ""]
    vehicles: Float[Tensor, ""]

    def total(self, weight: float) -> Float[Tensor, ""]:
        """Return the total loss; `weight` is lambda."""
        return self.waypoints + weight * self.vehicles


def losses_of(
    output: Output, targets: Targets, bins: Sequence[Bins], overshoot_weight: float = 1.0
) -> Losses:
    """Return the losses of an output.

    Args:
        output: The network's output.
        targets: The targets.
        bins: The bins of the six attributes.
        overshoot_weight: Weight of errors ahead of the target relative to errors behind it: above
            1, the network plans shorter distances than the median driven; 1 for equation 3.
    """
    errors = output.waypoints - targets.waypoints
    ahead, aside = errors.unbind(dim=2)
    along = torch.where(ahead > 0.0, overshoot_weight * ahead, -ahead)
    waypoints = (along + aside.abs()).mean()
    known = ~targets.futures[:, :, 0].isnan()
    each = torch.zeros_like(known, dtype=waypoints.dtype)
    for attribute, (logits, kind) in enumerate(zip(output.futures, bins, strict=True)):
        classes = classes_of(targets.futures[:, :, attribute], kind)
        each = each + functional.cross_entropy(
            logits.float().flatten(0, 1), classes.flatten(), ignore_index=IGNORED, reduction="none"
        ).view_as(each)
    scenes = each.sum(dim=1) / known.sum(dim=1).clamp(min=1)
    return Losses(waypoints, scenes.mean())


def classes_of(values: Float[Tensor, "*shape"], bins: Bins) -> Int[Tensor, "*shape"]:
    """Return the bin nearest to each value; `IGNORED` for NaN."""
    share = ((values - bins.low) / (bins.high - bins.low)).clamp(0.0, 1.0)
    classes = (share.nan_to_num() * (bins.count - 1)).round().long()
    return classes.masked_fill(values.isnan(), IGNORED)
