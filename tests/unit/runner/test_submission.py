"""Findings of `verify` without a simulator: tampered, incomplete and foreign runs."""

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from plant_bench.errors import InputError
from plant_bench.reports.verification_report import print_submission
from plant_bench.runner.episode.jobs import episode_name, make_jobs
from plant_bench.runner.review.differences import first_difference
from plant_bench.runner.review.submission import read_submission
from plant_bench.runner.review.verification import sample_of
from plant_bench.runner.run.folder import RunFolder
from plant_bench.runner.run.provenance import provenance
from plant_bench.runner.run.summary_files import write_summary
from plant_bench.scoring.infractions import Status
from plant_bench.scoring.penalties import PenaltyScheme
from plant_bench.scoring.results import EpisodeResult, HazardRecord
from plant_bench.world.hazard import HazardKind, Phase
from plant_bench.world.route import load_suite

CHECKSUM = "a" * 64
CROSSING = HazardKind.CROSSING
CHOSEN = "town01-0,town02-0"


@pytest.fixture
def run(tmp_path: Path) -> RunFolder:
    return submitted(tmp_path / "run", CHOSEN, repetitions=2)


def submitted(path: Path, chosen: str, *, repetitions: int) -> RunFolder:
    suite = load_suite("longest6")
    folder = RunFolder(path)
    folder.create()
    told = provenance(
        "stranger",
        CHECKSUM,
        suite,
        suite="longest6",
        seed=0,
        density="dense",
        hazards=True,
        repetitions=repetitions,
    )
    folder.write("run.json", told.model_dump_json(indent=1) + "\n")
    routes = [route for route in suite if route.id in chosen.split(",")]
    jobs = make_jobs("stranger", CHECKSUM, routes, repetitions=repetitions, seed=0, density="dense")
    phases = [*[Phase.DONE] * 2, Phase.VOID, *[Phase.DONE] * 7, Phase.ARMED, Phase.DONE]
    for number, job in enumerate(jobs):
        result = EpisodeResult(
            **job.header(frozenset()).model_dump(),
            status=Status.TIMED_OUT,
            route_length=job.route.length,
            completion=0.5,
            distance=100.0,
            duration=100.0,
            hazards=(HazardRecord(kind=CROSSING, at=1.0, phase=phases[number], time=0.0),),
        )
        folder.save(episode_name(job), result, None)
    write_summary(folder)
    return folder


def findings(run: RunFolder) -> list[tuple[str, str]]:
    found = read_submission(run.path, selection=CHOSEN).findings
    return [(item.place.partition("/")[0], item.what) for item in found]


def change(path: Path, **values: object) -> None:
    path.write_text(json.dumps(json.loads(path.read_text()) | values, indent=1) + "\n")


def test_unchanged_run_has_no_findings(run: RunFolder):
    assert findings(run) == []


def test_run_with_ten_or_more_repetitions_has_no_findings(tmp_path: Path):
    run = submitted(tmp_path / "run", "town01-0", repetitions=12)

    assert read_submission(run.path, selection="town01-0").findings == ()


def test_record_with_changed_inputs_is_found(run: RunFolder):
    change(run.record_files()[0], inputs=["privileged"])
    write_summary(run)

    found = read_submission(run.path, selection=CHOSEN).findings

    assert [(item.what, item.found, item.wanted) for item in found] == [
        ("inputs", "privileged", "nothing")
    ]


def test_settings_other_than_the_benchmark_are_reported(run: RunFolder):
    write_summary(run, penalties=PenaltyScheme.LB2_1)

    notes = read_submission(run.path, selection=CHOSEN).notes

    assert notes == (
        "Settings that are not standard for scores: penalties lb2.1, 2 of 3 repetitions.",
    )


def test_untrusted_text_is_printed_without_markup(run: RunFolder, capsys: pytest.CaptureFixture):
    first = run.record_files()[0]
    change(first, density="[/bold] [red]")

    print_submission(read_submission(run.path, selection=CHOSEN))

    assert "[/bold] [red]" in capsys.readouterr().out


def test_changed_completion_contradicts_the_summary(run: RunFolder):
    change(run.record_files()[0], completion=1.0)

    assert ("summary.json", "line") in findings(run)
    assert ("summary.csv", "line") in findings(run)


def test_changed_summary_contradicts_the_records(run: RunFolder):
    file = run.path / "summary.json"
    file.write_text(file.read_text().replace('"mean": 50.0', '"mean": 99.0'))

    assert findings(run) == [("summary.json", "line")]


@pytest.mark.parametrize(
    ("field", "value"),
    [("seed", 7), ("density", "light"), ("agent_checksum", "b" * 64), ("town", "town06")],
)
def test_a_record_of_an_easier_episode_is_found(run: RunFolder, field: str, value: object):
    change(run.record_files()[0], **{field: value})

    assert ("episodes", field) in findings(run)


def test_a_missing_episode_is_named(run: RunFolder):
    run.record_files()[0].unlink()
    write_summary(run)

    found = read_submission(run.path, selection=CHOSEN).findings

    assert [item.found for item in found] == ["1 missing: town01-0 r0"]


def test_duplicate_episode_is_found(run: RunFolder):
    first = run.record_files()[0]
    first.with_name("town01-0_r0_00000000.json").write_bytes(first.read_bytes())

    assert ("episodes", "town01-0, repetition 0") in findings(run)
    assert ("episodes", "name") in findings(run)


def test_run_with_other_rules_keys_gives_a_note_and_no_finding(run: RunFolder):
    for path in run.record_files():
        path.rename(path.with_name(f"{path.stem.rpartition('_')[0]}_01234567.json"))

    submission = read_submission(run.path, selection=CHOSEN)

    assert not submission.findings
    assert "all keys in file names differ" in submission.notes[0]


def test_record_that_is_a_symlink_is_not_read(run: RunFolder, tmp_path: Path):
    first = run.record_files()[0]
    first.rename(tmp_path / "elsewhere.json")
    first.symlink_to(tmp_path / "elsewhere.json")

    assert ("episodes", "record") in findings(run)


def test_folder_of_symlinks_is_refused(run: RunFolder, tmp_path: Path):
    (run.path / "episodes").rename(tmp_path / "elsewhere")
    (run.path / "episodes").symlink_to(tmp_path / "elsewhere")

    with pytest.raises(InputError, match="is a symbolic link"):
        read_submission(run.path)


def test_routes_named_by_the_submission_are_not_read(run: RunFolder):
    change(run.run_file, suite="/dev/zero")

    with pytest.raises(InputError, match="which is not built in"):
        read_submission(run.path)


def test_first_different_field_is_given_with_both_values(run: RunFolder):
    told = run.results()[0]

    found = first_difference(told, told.model_copy(update={"completion": 0.25, "distance": 1.0}))

    assert found is not None
    assert (found.field, found.told, found.again) == ("completion", "0.5", "0.25")


def test_sample_covers_all_towns_and_depends_on_its_seed(make_records: Callable[..., dict]):
    records = make_records({"a": 10, "b": 3, "c": 1})

    samples = [sample_of(records, 3, seed) for seed in range(20)]

    assert all({records[name].town for name in names} == {"a", "b", "c"} for names in samples)
    assert len({tuple(names) for names in samples}) > 5
    assert sample_of(records, 3, 4) == sample_of(records, 3, 4)
    assert len(sample_of(records, 14, 0)) == 14


@pytest.fixture
def make_records(run: RunFolder) -> Callable[..., dict]:
    one = run.results()[0]

    def make(towns: dict[str, int]) -> dict[str, EpisodeResult]:
        return {
            f"{town}-{number}": one.model_copy(update={"town": town})
            for town, count in towns.items()
            for number in range(count)
        }

    return make
