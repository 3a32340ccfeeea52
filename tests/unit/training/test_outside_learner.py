"""An external learner: trained, stopped, resumed and scored."""

import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from typer.testing import CliRunner

from plant_bench.cli import app
from plant_bench.errors import InputError
from plant_bench.training import graceful_interrupt as interrupts
from plant_bench.training import learners
from plant_bench.training.ablation_variants import Recipe, variants_of
from plant_bench.training.closed_loop import ClosedLoop, closed_loop_score
from plant_bench.training.events import StepEnded, TrainingEvent
from plant_bench.training.frame_store import load_frames
from plant_bench.training.learners import LearnerSpec, learner_class
from plant_bench.training.loader import EncodingLoader
from plant_bench.training.settings import TrainingSettings
from plant_bench.training.training_run import Listeners, Machine, TrainingRun, run_training

FILE = Path(__file__).parents[2] / "outside" / "pixels.py"
SPEC = f"{FILE}:PixelLearner"


@pytest.fixture(autouse=True)
def no_tensorboard(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("plant_bench.training.history.has_tensorboard", lambda: False)


@pytest.fixture
def town_data(make_data: Callable[..., Path]) -> Path:
    return make_data("data", "one", "two", town="town01", ticks=160)


def training(data: Path, out: Path, **changes: Any) -> TrainingRun:
    settings = TrainingSettings(epochs=2, batch=4, rate=1e-2, held_out=0.5)
    made = TrainingRun(
        SPEC,
        learner_class(SPEC).Options(),
        (data,),
        out,
        settings,
        machine=Machine("cpu", 1, 1, 1, 0),
        work=out / "work",
    )
    return replace(made, **changes)


def weights_in(folder: Path) -> bytes:
    return (folder / "weights.safetensors").read_bytes()


def test_loader_processes_give_the_same_batches(town_data: Path) -> None:
    frames = load_frames([town_data])
    learner_spec = LearnerSpec(SPEC, learner_class(SPEC).Options())
    wanted = np.array_split(np.random.default_rng(0).permutation(len(frames)), 3)
    torch.manual_seed(5)
    here = list(EncodingLoader(frames, learner_spec, 0).batches(wanted))
    there = EncodingLoader(frames, learner_spec, 2)

    found = list(there.batches(wanted))
    again = list(there.batches(wanted[1:]))
    there.close()

    state = torch.get_rng_state()
    torch.manual_seed(5)
    assert torch.equal(state, torch.get_rng_state())  # the training's generator is unused
    for one, other in zip([*here, *here[1:]], [*found, *again], strict=True):
        assert list(one) == list(other)
        assert all(torch.equal(one[name], other[name]) for name in one)
    assert here[0]["picture"].shape == (len(wanted[0]), 3, 32, 32)
    assert here[0]["picture"].any()


def test_resumed_training_gives_the_same_result(tmp_path: Path, town_data: Path) -> None:
    whole = training(town_data, tmp_path / "whole")
    losses: list[float] = []

    def note(event: TrainingEvent) -> None:
        if isinstance(event, StepEnded):
            losses.append(event.loss)

    assert run_training(whole, Listeners(on_event=note))
    steps = len(losses) // 2
    halved = training(town_data, tmp_path / "halved", machine=Machine("cpu", 1, 1, 1, 1))
    done = 0

    def stop_in_the_second_epoch(event: TrainingEvent) -> None:
        nonlocal done
        done += isinstance(event, StepEnded)
        if done == steps + 1:
            interrupts.signal.raise_signal(interrupts.signal.SIGINT)

    assert not run_training(halved, Listeners(on_event=stop_in_the_second_epoch))
    assert run_training(halved)
    assert weights_in(halved.out) == weights_in(whole.out)
    assert losses[-1] < losses[0]
    card = (whole.out / "card.md").read_text()
    assert "pixels, trained by imitation" in card
    assert "| width | 4 |" in card
    head = (whole.work_folder / "losses.csv").read_text().splitlines()[0]
    assert head == "epoch,rate,train_waypoints,valid_waypoints,driving_score"


def test_loss_can_have_any_name(
    tmp_path: Path, town_data: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = learner_class(SPEC).loss

    def renamed(self: Any, network: Any, batch: Any) -> dict[str, torch.Tensor]:
        (value,) = whole(self, network, batch).values()
        return {"samples": value}

    monkeypatch.setattr(learner_class(SPEC), "loss", renamed)
    model = training(town_data, tmp_path / "model", settings=TrainingSettings(epochs=1, batch=4))
    assert run_training(model)
    head, row = (model.work_folder / "losses.csv").read_text().splitlines()[:2]
    found = dict(zip(head.split(","), row.split(","), strict=True))
    assert 0.0 < float(found["train_samples"]) != 1.0


@pytest.mark.sumo
def test_trained_external_learner_drives(tmp_path: Path, town_data: Path) -> None:
    model = training(town_data, tmp_path / "model", settings=TrainingSettings(epochs=1, batch=8))
    assert run_training(model)
    agent = f"{learner_class(SPEC).agent}@{model.out}"
    score = closed_loop_score(agent, tmp_path / "run", ClosedLoop("longest6", "town02-5", False))
    assert 0.0 <= score <= 100.0
    assert len(list((tmp_path / "run" / "episodes").glob("*.json"))) == 1


def test_frame_that_fails_to_encode_gives_one_message(
    tmp_path: Path, make_data: Callable[..., Path]
) -> None:
    data = make_data("nowhere", "one", "two", ticks=160)
    with pytest.raises(InputError, match=r"^There is no town 'nowhere'[^\n]*$"):
        run_training(training(data, tmp_path / "model", machine=Machine("cpu", 1, 1, 1, 1)))


def test_installed_learner_is_found_by_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    package, about = tmp_path / "outsiders", tmp_path / "outsiders-1.0.dist-info"
    package.mkdir()
    about.mkdir()
    (package / "__init__.py").touch()
    shutil.copy(FILE, package / "learn.py")
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: outsiders\nVersion: 1.0\n")
    entry = "[plant_bench.learners]\npixels = outsiders.learn:PixelLearner\n"
    (about / "entry_points.txt").write_text(entry)
    monkeypatch.syspath_prepend(tmp_path)
    learners.installed_learners.cache_clear()
    try:
        assert learners.known_learners() == ["plant", "pixels"]
        assert learner_class("pixels").name == "pixels"
        shown = CliRunner().invoke(app, ["train", "--help"]).output
        assert "Learns from rasters" in shown
        with pytest.raises(InputError, match="Did you mean 'pixels'"):
            learner_class("pixel")
    finally:
        learners.installed_learners.cache_clear()


def test_options_of_the_learner_are_command_options(tmp_path: Path, town_data: Path) -> None:
    words = ["train", SPEC, "--data", str(town_data), "--out", str(tmp_path / "model")]
    small = ["--pixels", "16", "--blind", "--epochs", "1", "--threads", "1", "--loaders", "0"]
    work = ["--work", str(tmp_path / "work"), "--accelerator", "cpu", "--workers", "1"]
    done = CliRunner().invoke(app, [*words, *small, *work])
    assert done.exit_code == 0, done.output
    config = (tmp_path / "model" / "config.json").read_text()
    assert '"pixels": 16' in config
    assert '"blind": true' in config
    refused = CliRunner().invoke(app, [*words, "--width", "65"])
    assert refused.exit_code == 2


def test_ablations_of_the_learner_come_from_its_options() -> None:
    base = Recipe(LearnerSpec(SPEC, learner_class(SPEC).Options()), TrainingSettings())
    found = {variant.name: variant for variant in variants_of((), base)}
    assert list(found) == ["base", "data-1of3", "data-2of3", "data-3of3", "blind"]
    assert found["blind"].recipe.learner.options.blind
    assert found["data-3of3"].training == "base"
    assert found["data-3of3"].paper == "-"


@pytest.mark.parametrize(
    ("spec", "message"),
    [
        ("plnt", "There is no learner 'plnt'. Did you mean 'plant'"),
        (f"{FILE}:PixelLerner", "Did you mean 'PixelLearner'"),
        (f"{FILE}:Pixels", "is not a learner: expected a subclass of plant_bench.learner.Learner"),
        ("nowhere.py:Learner", "There is no file"),
        ("plant_bench.nowhere:Learner", "cannot be loaded: ModuleNotFoundError"),
        (
            "plant_bench.learner:Learner",
            "define encode, loss, network, name, agent, Options",
        ),
    ],
)
def test_class_that_is_not_a_learner_raises_input_error(spec: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        learner_class(spec)
