"""Training of a small network for a few steps: learning, stopping, resuming, saving."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
import torch

from plant_bench.agents.plant.config import SIZES, PlanTConfig, Size
from plant_bench.agents.plant.learner import PlanTLearner
from plant_bench.agents.plant.network import PlanTNetwork
from plant_bench.agents.plant.network_files import load_network
from plant_bench.agents.plant.training_options import PlanTOptions
from plant_bench.errors import InputError
from plant_bench.features.tokens import TokenSpec
from plant_bench.training import graceful_interrupt as interrupts
from plant_bench.training import imitation
from plant_bench.training.batches import Split, split_by_route
from plant_bench.training.closed_loop import ClosedLoop
from plant_bench.training.divergence import TrainingError
from plant_bench.training.events import StepEnded, TrainingEvent
from plant_bench.training.frame_store import load_frames
from plant_bench.training.imitation import TrainingRequest, make_fabric, train
from plant_bench.training.learners import LearnerSpec
from plant_bench.training.loader import make_loader
from plant_bench.training.settings import TrainingSettings
from plant_bench.training.trainer import optimizer_of
from plant_bench.training.training_run import TrainingRun

SETTINGS = TrainingSettings(epochs=2, drop_after=2, batch=8, rate=1e-2)


@pytest.fixture(autouse=True)
def tiny(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(SIZES, "mini", Size(1, 16, 2))
    monkeypatch.setattr("plant_bench.training.history.has_tensorboard", lambda: False)


@pytest.fixture
def split(data: Path) -> Split:
    return split_by_route(load_frames([data]), 0.1, 0)


def learner_spec(config: PlanTConfig) -> LearnerSpec:
    return LearnerSpec("plant", PlanTOptions(config))


def request_in(folder: Path, **changes: object) -> TrainingRequest:
    learner = learner_spec(PlanTConfig())
    request = TrainingRequest(learner, SETTINGS, folder / "model", folder / "work")
    return replace(request, **changes)


def run(request: TrainingRequest, split: Split, listen: Callable | None = None) -> list:
    told: list[TrainingEvent] = []
    loader = make_loader(split.frames, request.learner)
    fabric = make_fabric(accelerator="cpu", devices=1)
    train(request, split, loader, fabric, listen or told.append)
    return told


def weights_in(folder: Path) -> bytes:
    return (folder / "weights.safetensors").read_bytes()


def test_training_reduces_the_loss_and_saves_the_model(tmp_path: Path, split: Split) -> None:
    request = request_in(tmp_path, settings=replace(SETTINGS, epochs=4, drop_after=4))
    told = run(request, split)
    losses = [event.loss for event in told if isinstance(event, StepEnded)]
    assert losses[-1] < 0.8 * losses[0]
    assert load_network(request.out).config == PlanTConfig()
    card = (request.out / "card.md").read_text()
    assert "51 samples" in card
    assert split.fingerprint in card
    rows = (request.work / "losses.csv").read_text().splitlines()
    assert len(rows) == 5
    assert rows[0].split(",")[2:5] == ["train_loss", "train_waypoints", "train_vehicles"]
    assert all(rows[-1].split(",")[:8])


def test_resumed_training_gives_the_same_result(tmp_path: Path, split: Split) -> None:
    config = PlanTConfig(speed_input=True)
    whole = request_in(tmp_path / "whole", learner=learner_spec(config))
    run(whole, split)
    halved = request_in(tmp_path / "halved", learner=learner_spec(config))
    steps = 0

    def stop_in_the_second_epoch(event: TrainingEvent) -> None:
        nonlocal steps
        steps += isinstance(event, StepEnded)
        if steps == 6:
            interrupts.signal.raise_signal(interrupts.signal.SIGINT)

    with pytest.raises(KeyboardInterrupt):
        run(halved, split, stop_in_the_second_epoch)
    assert not halved.out.exists()
    run(halved, split)
    assert weights_in(halved.out) == weights_in(whole.out)


def test_best_validated_weights_are_kept(
    tmp_path: Path, split: Split, monkeypatch: pytest.MonkeyPatch
) -> None:
    scores, seen = iter([50.0, 20.0]), []

    def score(agent: str, out: Path, drive: ClosedLoop) -> float:
        seen.append(weights_in(Path(agent.removeprefix("plant-unguarded@"))))
        return next(scores)

    monkeypatch.setattr(imitation, "closed_loop_score", score)
    settings = replace(SETTINGS, validate_every=1)
    request = request_in(tmp_path, settings=settings, closed_loop=ClosedLoop("longest6", "0"))
    run(request, split)
    assert len(seen) == 2
    assert weights_in(request.out) == seen[0]
    assert "epoch 1" in (request.out / "card.md").read_text()
    assert "50" in (request.work / "losses.csv").read_text()


def driven_with(monkeypatch: pytest.MonkeyPatch, scores: list[float]) -> list[float]:
    """Return the given scores for successive validations; return the unused ones."""
    left = list(scores)
    monkeypatch.setattr(imitation, "closed_loop_score", lambda *_: left.pop(0))
    return left


def test_training_stops_when_validation_does_not_improve(
    tmp_path: Path, split: Split, monkeypatch: pytest.MonkeyPatch
) -> None:
    left = driven_with(monkeypatch, [30.0, 50.0, 40.0, 50.0, 60.0])
    settings = replace(SETTINGS, epochs=12, drop_after=12, validate_every=2, patience=2)
    request = request_in(tmp_path, settings=settings, closed_loop=ClosedLoop("longest6", "0"))
    run(request, split)
    assert left == [60.0]  # after epochs 2, 4, 6 and 8; equal is no better
    card = (request.out / "card.md").read_text()
    assert "The training ended after epoch 8" in card
    assert "DS 50.0" in card
    assert run(request, split) == []  # it stays at its end
    patient = replace(request, settings=replace(settings, patience=3, epochs=10))
    run(patient, split)  # and goes on where more patience is asked for
    assert left == []
    assert "of epoch 10" in (request.out / "card.md").read_text()


def test_patience_survives_a_restart(
    tmp_path: Path, split: Split, monkeypatch: pytest.MonkeyPatch
) -> None:
    left = driven_with(monkeypatch, [50.0, 40.0, 45.0, 60.0])
    settings = replace(SETTINGS, epochs=6, drop_after=6, validate_every=1, patience=2)
    request = request_in(tmp_path, settings=settings, closed_loop=ClosedLoop("longest6", "0"))

    def stop_in_the_third_epoch(event: TrainingEvent) -> None:
        if isinstance(event, StepEnded) and event.epoch == 2:
            interrupts.signal.raise_signal(interrupts.signal.SIGINT)

    with pytest.raises(KeyboardInterrupt):
        run(request, split, stop_in_the_third_epoch)
    assert left == [45.0, 60.0]
    run(request, split)
    assert left == [60.0]


def test_training_starts_from_given_weights(tmp_path: Path, split: Split) -> None:
    first = request_in(tmp_path / "first", learner=learner_spec(PlanTConfig(speed_input=True)))
    run(first, split)
    told_less = PlanTConfig(speed_input=True, speed_dropout=0.9)  # no part of the network
    still = replace(SETTINGS, epochs=1, rate=0.0)
    second = request_in(
        tmp_path / "second", learner=learner_spec(told_less), settings=still, start=first.out
    )
    run(second, split)
    assert weights_in(second.out) == weights_in(first.out)
    assert load_network(second.out).config == told_less
    assert "| initial weights | weights of hash" in (second.out / "card.md").read_text()
    with pytest.raises(InputError, match="start"):  # another start is another training
        run(replace(second, start=None), split)


@pytest.mark.parametrize("had", [TokenSpec(), TokenSpec(conflicts=True), TokenSpec(motion=True)])
def test_new_attributes_have_zero_weight_at_the_start(had: TokenSpec) -> None:
    earlier = PlanTNetwork(PlanTConfig(tokens=had))
    now = TokenSpec(conflicts=True, motion=True)
    learner = PlanTLearner(PlanTOptions(PlanTConfig(tokens=now)))
    network = learner.network()
    assert isinstance(network, PlanTNetwork)
    state = learner.start_from(PlanTOptions(earlier.config), earlier.state_dict())
    network.load_state_dict(state)

    told = torch.randn(3, now.attributes)
    known = [torch.ones(6), torch.full((4,), had.conflicts), torch.full((2,), had.motion)]
    kept = told[:, torch.cat(known).bool()]
    assert torch.allclose(network.project(told), earlier.project(kept), atol=1e-6)


def test_weights_of_another_network_are_refused_as_start(tmp_path: Path, split: Split) -> None:
    first = request_in(tmp_path / "first")
    run(first, split)
    other = PlanTConfig(limit_input=True, tokens=TokenSpec(reach=45.0))
    second = request_in(tmp_path / "second", learner=learner_spec(other), start=first.out)
    words = r"limit_input False \(now True\), reach 30.0 \(now 45.0\). Give the options"
    with pytest.raises(InputError, match=words):
        run(second, split)
    with pytest.raises(InputError, match="There are no weights in"):
        run(replace(second, start=tmp_path / "nowhere"), split)
    assert not second.out.exists()


def test_model_card_names_data_commands_without_local_paths(
    tmp_path: Path, split: Split, monkeypatch: pytest.MonkeyPatch
) -> None:
    arguments = ["/opt/bin/plant-bench", "train", "plant", "--data", str(tmp_path / "mine")]
    monkeypatch.setattr("sys.argv", [*arguments, f"--start=plant@{tmp_path}/weights/"])
    request = request_in(tmp_path, sources=("3 episodes of mine", "2 episodes of others"))
    run(request, split)
    card = (request.out / "card.md").read_text()
    assert "| data source | 3 episodes of mine |\n| data source | 2 episodes of others |" in card
    assert "`plant-bench train plant --data mine --start=plant@weights/`" in card
    assert str(tmp_path) not in card
    assert "| processor | " in card


def test_resuming_with_other_options_is_refused(tmp_path: Path, split: Split) -> None:
    run(request_in(tmp_path), split)
    other = request_in(tmp_path, settings=replace(SETTINGS, rate=1e-3))
    with pytest.raises(InputError, match=r"rate 0.01 \(now 0.001\)"):
        run(other, split)
    run(replace(other, overwrite=True), split)
    checkpoint = tmp_path / "work" / "checkpoint.safetensors"
    checkpoint.write_bytes(checkpoint.read_bytes()[:100])
    with pytest.raises(InputError, match="Broken checkpoint"):
        run(other, split)


def test_weight_decay_applies_only_to_linear_weights() -> None:
    network = PlanTNetwork(PlanTConfig())
    decayed, others = optimizer_of(network, SETTINGS).param_groups
    assert (decayed["weight_decay"], others["weight_decay"]) == (0.1, 0.0)
    linear = [module for module in network.modules() if isinstance(module, torch.nn.Linear)]
    assert len(decayed["params"]) == len(linear)
    total = len(decayed["params"]) + len(others["params"])
    assert total == len(list(network.parameters()))


def test_unknown_accelerator_raises_input_error() -> None:
    with pytest.raises(InputError, match="Cannot train on"):
        make_fabric(accelerator="abacus", devices=1)


def test_diverging_training_ends_with_one_line_that_names_the_step(
    tmp_path: Path, split: Split, monkeypatch: pytest.MonkeyPatch
) -> None:
    request = request_in(tmp_path)
    losses = PlanTLearner.loss
    calls = 0

    def loss(*arguments: Any) -> dict[str, torch.Tensor]:
        nonlocal calls
        calls += 1
        found = dict(losses(*arguments))
        name = next(iter(found))
        return found | ({name: found[name] * float("inf")} if calls == 2 else {})

    monkeypatch.setattr(PlanTLearner, "loss", loss)
    with pytest.raises(TrainingError) as caught:
        run(request, split)

    told = str(caught.value)
    assert "the loss was inf" in told
    assert "at step 2 of 3 of epoch 1. No weights were kept" in told
    assert "lower --rate than 0.01" in told
    assert not isinstance(caught.value, InputError)  # exit code 1
    assert not request.out.exists()


def test_training_state_is_of_the_whole_path_of_the_model() -> None:
    options = PlanTOptions()
    first, other, again = (
        TrainingRun("plant", options, (Path("data"),), Path(out)).work_folder
        for out in ("one/mine", "two/mine", "./one/../one/mine")
    )

    assert first == again
    assert first != other
    assert first.parent == Path("reports")
    assert first.name.startswith("training-mine-")
