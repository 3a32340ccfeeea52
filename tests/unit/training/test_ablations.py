"""Variants of a base, shares of the data, and the command that trains, drives and tabulates."""

import math
from dataclasses import replace
from pathlib import Path

import pytest
import torch

from plant_bench.agents.plant.ablations import ABLATIONS
from plant_bench.agents.plant.config import PlanTConfig
from plant_bench.agents.plant.training_options import PlanTOptions
from plant_bench.cli import ablation_table as ablating
from plant_bench.cli.ablation_table import ablate
from plant_bench.errors import InputError
from plant_bench.features.tokens import TokenSpec
from plant_bench.runner.episode.jobs import episode_name, make_jobs
from plant_bench.runner.run.folder import RunFolder
from plant_bench.runner.run.score_run import Run, ScoreRequest
from plant_bench.scoring.infractions import Status
from plant_bench.scoring.results import EpisodeResult
from plant_bench.training.ablation_run import AblationRequest
from plant_bench.training.ablation_variants import Recipe, trainings_of, variants_of
from plant_bench.training.frame_store import load_frames, recordings_in
from plant_bench.training.learners import LearnerSpec
from plant_bench.training.settings import TrainingSettings, drop_after
from plant_bench.training.threads import threads_kept
from plant_bench.training.training_run import Machine, TrainingRun
from plant_bench.world.route import load_suite


def recipe(config: PlanTConfig, auxiliary: float = 0.2, share: float = 0.7) -> Recipe:
    learner_spec = LearnerSpec("plant", PlanTOptions(config, auxiliary))
    return Recipe(learner_spec, TrainingSettings(), share)


BASE = recipe(PlanTConfig())
COMPLETION = {"base": 0.8, "no-rear": 0.4}


def test_variant_differs_from_the_base_in_one_option() -> None:
    found = {variant.name: variant.recipe for variant in variants_of((), BASE)}
    assert found["no-rear"] == recipe(PlanTConfig(tokens=TokenSpec(rear=False)))
    assert found["no-speeds"] == recipe(PlanTConfig(tokens=TokenSpec(speed=False)))
    assert found["no-auxiliary"] == recipe(PlanTConfig(), 0.0)
    assert found["data-1of3"] == replace(BASE, share=0.7 / 3)
    assert found["medium"] == recipe(PlanTConfig("medium"))
    assert found["stop-line"] == recipe(PlanTConfig(tokens=TokenSpec(stop_line=True)))
    papers = {variant.name: variant.paper for variant in variants_of((), BASE)}
    assert papers["data-3of3"] == papers["medium"] == "81.36 ± 6.54"


def test_single_variant_can_be_selected() -> None:
    found = variants_of(["small", "rear"], BASE)
    assert [variant.name for variant in found] == ["base", "no-rear", "rear", "small"]


def test_no_speeds_variant_disables_all_inputs_derived_from_speed() -> None:
    """Predicted conflicts, motion and horizon would reveal the speeds to the network."""
    told = TokenSpec(reach=30.0, horizon=5.0, conflicts=True, motion=True, stop_line=True)
    base = recipe(PlanTConfig(tokens=told))
    found = {variant.name: variant.recipe for variant in variants_of(["speeds"], base)}
    without = TokenSpec(reach=30.0, speed=False, stop_line=True)
    assert found["no-speeds"] == recipe(PlanTConfig(tokens=without))
    assert found["speeds"] == base


def test_variants_equal_to_the_base_share_its_training() -> None:
    variants = variants_of((), BASE)
    shared = {variant.name for variant in variants if variant.training == "base"}
    kept = {"rear", "speeds", "auxiliary", "data-3of3", "mini", "reach-30"}
    added = {
        "stop-line",
        "vulnerable",
        "limit-input",
        "speed-input",
        "conflicts",
        "horizon",
        "motion",
    }
    assert shared == kept | {"base"} | {f"no-{name}" for name in added}
    trainings = trainings_of(variants)
    assert len(trainings) == len(set(map(str, trainings.values())))
    told = recipe(PlanTConfig(tokens=TokenSpec(stop_line=True)))
    names = [(item.name, item.training) for item in variants_of(["stop-line"], told)]
    assert names == [("base", "base"), ("no-stop-line", "no-stop-line"), ("stop-line", "base")]


def test_unknown_ablation_raises_input_error() -> None:
    with pytest.raises(InputError, match="Did you mean speeds"):
        variants_of(["speed"], BASE)


def test_training_names_are_unique() -> None:
    names = [choice.name for choices in ABLATIONS.values() for choice in choices]
    assert len(names) == len(set(names))


def test_learning_rate_drops_at_the_epoch_of_the_paper() -> None:
    assert (drop_after(47), drop_after(10)) == (45, 10)


def test_share_of_data_prefers_first_repetitions(tmp_path: Path) -> None:
    folder = tmp_path / "episodes"
    folder.mkdir()
    for route in range(20):
        for repetition in range(2):
            (folder / f"town0{route % 4}-{route}_r{repetition}_{route:08x}.parquet").touch()
    half, fewer = recordings_in(tmp_path, 0.5), recordings_in(tmp_path, 0.25)
    assert len(half) == 20
    assert all("_r0_" in path.name for path in half)
    assert set(fewer) < set(half)
    assert len({path.name[:6] for path in fewer}) == 4
    assert recordings_in(tmp_path) == sorted(folder.iterdir())


def test_a_share_of_the_samples_is_loaded(data: Path) -> None:
    assert len(load_frames([data], share=0.67).routes) == 2


@pytest.fixture
def done(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """The list of trainings and runs that would be made; none is executed."""
    log: list[str] = []

    def train(run: TrainingRun) -> bool:
        log.append(f"train {run.out.parent.relative_to(run.out.parents[2])}")
        run.out.mkdir(parents=True, exist_ok=True)
        (run.out / "weights.safetensors").touch()
        return True

    def drive(request: ScoreRequest, out: Path, _: object) -> Run:
        name, seed = out.parts[-3:-1]
        jobs = make_jobs(
            request.agent,
            "0" * 64,
            load_suite("longest6")[:1],
            repetitions=request.repetitions,
            seed=0,
            density="dense",
        )
        run = Run(RunFolder(out), jobs, jobs, [])
        run.folder.create()
        for job in jobs:
            completion = COMPLETION[name] + 0.1 * (seed == "seed-1")
            result = EpisodeResult(
                **job.header(frozenset()).model_dump(),
                status=Status.TIMED_OUT,
                route_length=job.route.length,
                completion=completion,
                distance=completion * job.route.length,
                duration=100.0,
            )
            run.folder.save(episode_name(job), result, None)
        log.append(f"drive {request.agent.rpartition('out/')[2]}")
        return run

    monkeypatch.setattr(ablating, "train_with_progress", train)
    monkeypatch.setattr(ablating, "drive_missing", drive)
    return log


def request_of(tmp_path: Path, data: Path, **changes: object) -> AblationRequest:
    drives = ScoreRequest("plant", routes="0", repetitions=2)
    request = AblationRequest(["rear"], BASE, (data,), tmp_path / "out", drives, 2, Machine())
    return replace(request, **changes)


def test_each_variant_is_trained_scored_and_in_the_table(
    tmp_path: Path, data: Path, done: list[str]
) -> None:
    assert ablate(request_of(tmp_path, data)) == 0
    places = [f"{name}/seed-{seed}" for name in ("base", "no-rear") for seed in (0, 1)]
    steps = [[f"train {place}", f"drive {place}/model"] for place in places]
    assert done == [step for pair in steps for step in pair]
    lines = (tmp_path / "out" / "ablations.md").read_text().splitlines()
    rows = [[cell.strip() for cell in line.split("|")] for line in lines if line.startswith("|")]
    assert [row[1:5] for row in rows[2:]] == [
        ["base", "base", "85.0 ± 5.8", "+0.0"],
        ["rear", "no-rear", "45.0 ± 5.8", "-40.0"],
        ["rear", "rear (base)", "85.0 ± 5.8", "+0.0"],
    ]
    assert rows[3][-2] == "72.86 ± 5.56"
    assert "- driven: 1 routes of longest6, 2 repetitions, dense traffic" in lines
    table = (tmp_path / "out" / "ablations.csv").read_text().splitlines()
    assert len(table) == 4
    assert math.isclose(float(table[2].split(",")[4]), 45.0)


def test_finished_trainings_are_not_repeated(tmp_path: Path, data: Path, done: list[str]) -> None:
    ablate(request_of(tmp_path, data))
    done.clear()
    ablate(request_of(tmp_path, data, seeds=3))
    trained = [step for step in done if step.startswith("train")]
    assert trained == ["train base/seed-2", "train no-rear/seed-2"]
    other = replace(BASE, settings=replace(BASE.settings, epochs=3))
    with pytest.raises(InputError, match="trained with other settings or on other data"):
        ablate(request_of(tmp_path, data, base=other))
    done.clear()
    ablate(request_of(tmp_path, data, base=other, overwrite=True))
    assert sum(step.startswith("train") for step in done) == 4


def test_interrupted_ablation_writes_no_table(
    tmp_path: Path, data: Path, done: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(ablating, "drive_missing", lambda *_, **__: None)
    assert ablate(request_of(tmp_path, data)) == 130
    assert not (tmp_path / "out" / "ablations.md").exists()
    with pytest.raises(InputError, match="There is no route '99'"):
        ablate(request_of(tmp_path, data, drives=ScoreRequest("plant", routes="99")))


def test_creating_a_planner_keeps_the_torch_thread_count() -> None:
    torch.set_num_threads(2)
    with threads_kept():
        torch.set_num_threads(1)
    assert torch.get_num_threads() == 2


@pytest.mark.sumo
def test_ablation_trains_and_scores_and_repeats_nothing(
    tmp_path: Path, data: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("plant_bench.cli.training_progress.has_tensorboard", lambda: False)
    monkeypatch.setattr("plant_bench.training.history.has_tensorboard", lambda: False)
    base = replace(BASE, settings=TrainingSettings(epochs=1, drop_after=1, batch=16), share=1.0)
    drives = ScoreRequest("plant", routes="town02-5", repetitions=1, density="light")
    request = request_of(
        tmp_path, data, base=base, drives=drives, seeds=1, machine=Machine("cpu", 1, 1, 1)
    )
    assert ablate(request) == 0
    table = (tmp_path / "out" / "ablations.md").read_bytes()
    assert table.count(b"no-rear") == 1
    found = [*tmp_path.rglob("weights.safetensors"), *tmp_path.rglob("episodes/*.json")]
    assert len(found) == 4
    before = {path: path.stat().st_mtime_ns for path in found}
    assert ablate(request) == 0
    assert {path: path.stat().st_mtime_ns for path in before} == before
    assert (tmp_path / "out" / "ablations.md").read_bytes() == table
