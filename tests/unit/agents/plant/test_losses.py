"""Equation 3, by hand."""

import math

import pytest
import torch

from plant_bench.agents.plant.config import Bins, PlanTConfig
from plant_bench.agents.plant.losses import IGNORED, Targets, classes_of, losses_of
from plant_bench.agents.plant.network import Output

BINS = PlanTConfig().bins


def test_bins_equal_those_of_the_paper() -> None:
    assert [bins.count for bins in BINS] == [4, 128, 128, 32, 128, 128]
    wide = PlanTConfig().bins[1]
    assert (wide.low, wide.high) == (-30.0, 30.0)


def test_values_are_assigned_to_the_nearest_bin() -> None:
    values = torch.tensor([-5.0, 0.0, 2.4, 2.6, 15.0, 99.0, math.nan])
    assert classes_of(values, Bins(4, 0.0, 15.0)).tolist() == [0, 0, 0, 1, 3, 3, IGNORED]


def test_waypoint_loss_counts_x_and_y() -> None:
    output = Output(torch.zeros(1, 4, 2), tuple(torch.zeros(1, 1, b.count) for b in BINS))
    targets = Targets(torch.tensor([[[1.0, -1.0]] * 4]), torch.full((1, 1, 6), math.nan))
    losses = losses_of(output, targets, BINS)
    assert float(losses.waypoints) == pytest.approx(2.0)
    assert float(losses.vehicles) == 0.0
    assert float(losses.total(0.2)) == pytest.approx(2.0)


@pytest.mark.parametrize(("ahead", "loss"), [(1.0, 4.0), (-1.0, 1.0)])
def test_overshoot_weight_scales_errors_ahead_of_the_target(ahead: float, loss: float) -> None:
    output = Output(torch.zeros(1, 4, 2), tuple(torch.zeros(1, 1, b.count) for b in BINS))
    targets = Targets(torch.tensor([[[-ahead, 0.0]] * 4]), torch.full((1, 1, 6), math.nan))

    assert float(losses_of(output, targets, BINS, 4.0).waypoints) == pytest.approx(loss)


def test_vehicle_loss_is_averaged_per_scene() -> None:
    futures = torch.full((2, 3, 6), math.nan)
    futures[0, :2] = 0.0
    output = Output(torch.zeros(2, 4, 2), tuple(torch.zeros(2, 3, b.count) for b in BINS))
    losses = losses_of(output, Targets(torch.zeros(2, 4, 2), futures), BINS)
    even = sum(math.log(bins.count) for bins in BINS)  # a guess without knowledge
    assert float(losses.vehicles) == pytest.approx(even / 2, rel=1e-5)  # one scene of two
    assert float(losses.total(0.2)) == pytest.approx(0.1 * even, rel=1e-5)
