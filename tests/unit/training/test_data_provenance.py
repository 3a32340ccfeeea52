"""Data folders: their description, their drivers, and several of them together."""

import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from plant_bench.agent import Control
from plant_bench.agents.plant.config import SIZES, PlanTConfig, Size
from plant_bench.agents.plant.network import PlanTNetwork
from plant_bench.agents.plant.network_files import save_network
from plant_bench.agents.plant.training_options import PlanTOptions
from plant_bench.data_files import routes_dir
from plant_bench.errors import InputError
from plant_bench.runner.collect.data_folder import Origin
from plant_bench.training import training_run as courses
from plant_bench.training.batches import Split
from plant_bench.training.data_provenance import source_of
from plant_bench.training.imitation import TrainingRequest
from plant_bench.training.settings import TrainingSettings
from plant_bench.training.training_run import Machine, TrainingRun, Validation, run_training


def say_origin(folder: Path, *, driver: str = "", frames: int | None = None) -> Path:
    origin = Origin(
        seed=3,
        density="dense",
        perturb=0.0 if driver else 0.3,
        protocol="p",
        agent="expert",
        agent_checksum="e" * 64,
        driver=driver,
        driver_checksum="d" * 64 if driver else "",
        rules="r" * 64,
        versions={},
    )
    (folder / "collect.json").write_text(origin.model_dump_json())
    if frames is not None:
        (folder / "data.json").write_text(json.dumps({"request": {"frames": frames}}))
    return folder


def test_data_folder_names_its_collect_command(data: Path) -> None:
    assert source_of(data, 3) == "3 episodes of data, of unknown origin (no collect.json)"
    say_origin(data, frames=500)
    assert source_of(data, 3) == (
        "3 episodes of data: `plant-bench collect --out data --frames 500 --seed 3 --density dense "
        f"--perturb 0.3` (expert {'e' * 16}, rules {'r' * 16})"
    )
    said = source_of(say_origin(data, driver="plant@/home/me/models/mine", frames=500), 2)
    assert "--density dense --driver plant@mine` (expert" in said
    assert f"driver {'d' * 16})" in said
    assert "/" not in said


def test_broken_origin_raises_input_error(data: Path) -> None:
    (data / "collect.json").write_text("{")
    with pytest.raises(InputError, match=r"collect\.json is broken"):
        source_of(data, 1)


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> list[tuple[TrainingRequest, Split]]:
    """The requested trainings; none is executed."""
    monkeypatch.setitem(SIZES, "mini", Size(1, 16, 2))
    requests: list[tuple[TrainingRequest, Split]] = []
    monkeypatch.setattr(courses, "train", lambda *some: requests.append((some[0], some[1])))
    return requests


def training(tmp_path: Path, *data: Path, held_out: float = 0.1, **changes: Any) -> TrainingRun:
    settings = TrainingSettings(
        held_out=held_out,
        targets=changes.pop("targets", "future"),
        validate_every=int("validation" in changes),
    )
    places = (tmp_path / "model", settings)
    share, work = changes.pop("share", 1.0), tmp_path / "work"
    machine = Machine("cpu", 1, 1, 1)
    return TrainingRun(
        "plant", PlanTOptions(), data, *places, share, machine=machine, work=work, **changes
    )


def test_several_data_folders_are_trained_on_together(
    tmp_path: Path, data: Path, make_data: Callable[..., Path], asked: list
) -> None:
    more = make_data("more", "one", "three")
    assert run_training(training(tmp_path, data, more))
    (request, split), *_ = asked
    assert split.episodes == 5
    assert len(split.training) + len(split.validation) == 5 * 17
    assert [text.split(",")[0] for text in request.sources] == [
        "3 episodes of data",
        "2 episodes of more",
    ]
    run_training(training(tmp_path, data))
    assert asked[1][1].fingerprint != split.fingerprint
    run_training(training(tmp_path, data, more, share=0.5))
    assert [text.split()[0] for text in asked[2][0].sources] == ["2", "1"]


def test_validation_uses_routes_of_the_first_folder(
    tmp_path: Path, data: Path, make_data: Callable[..., Path], asked: list
) -> None:
    more = make_data("more", "three", "four", "five", "six")
    drives = {"validation": Validation(None, None, True), "held_out": 0.7}
    run_training(training(tmp_path, data, more, **drives))
    (request, split), *_ = asked
    own = sorted({"one", "two"} & set(split.held_out))
    assert 0 < len(own) < len(split.held_out)
    assert request.closed_loop.routes == ",".join(own)
    assert request.closed_loop.suite == str(data / "routes")
    only = make_data("only", *sorted({"three", "four", "five", "six"} - set(split.held_out)))
    with pytest.raises(InputError, match="None of the held-out routes is in"):
        run_training(training(tmp_path, only, data, more, **drives))


def test_dagger_data_requires_expert_action_targets(
    tmp_path: Path, data: Path, make_data: Callable[..., Path], asked: list
) -> None:
    facts: dict[str, Any] = {"answers": lambda _tick: Control(0.5, 0.0), "disturbed": range(260)}
    own = say_origin(make_data("own", "one", "two", every=10, **facts), driver="plant@models/mine")
    with pytest.raises(InputError, match=r"own was driven by .*--targets expert-action"):
        run_training(training(tmp_path, data, own))
    assert not (data / "frames").exists()  # said before any frames are made
    assert run_training(training(tmp_path, own, targets="expert-action"))
    with pytest.raises(InputError, match=r"a\.parquet: Row 50 .* has no acceleration of an expert"):
        run_training(training(tmp_path, own, data, targets="expert-action"))


def test_incompatible_start_weights_are_refused_before_encoding(
    tmp_path: Path, data: Path, asked: list
) -> None:
    save_network(PlanTNetwork(PlanTConfig(limit_input=True)), tmp_path / "other")
    with pytest.raises(InputError, match="limit_input True .now False."):
        run_training(training(tmp_path, data, start=tmp_path / "other"))
    with pytest.raises(InputError, match="There are no weights in"):
        run_training(training(tmp_path, data, start=tmp_path / "nowhere"))
    assert not (data / "frames").exists()


@pytest.mark.parametrize("suite", ["longest6", "unseen", "copy"])
def test_benchmark_suites_are_refused_for_validation(
    tmp_path: Path, data: Path, asked: list, suite: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "copy").mkdir()
    shutil.copy(data / "routes" / "suite.json", tmp_path / "copy" / "a.json")
    shutil.copy(routes_dir() / "unseen" / "unseen03.json", tmp_path / "copy" / "b.json")
    with pytest.raises(InputError, match="a route of the benchmark's suite '(longest6|unseen)'"):
        run_training(training(tmp_path, data, validation=Validation(suite, None, True)))
    assert not (data / "frames").exists()


def test_other_suites_are_accepted_for_validation(tmp_path: Path, data: Path, asked: list) -> None:
    own = str(data / "routes" / "suite.json")
    assert run_training(training(tmp_path, data, validation=Validation(own, "0", True)))
    assert asked[0][0].closed_loop.suite == own
