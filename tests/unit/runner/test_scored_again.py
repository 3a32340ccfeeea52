"""`verify` scores every recording again, whatever the sample of the simulator is."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import pytest

from plant_bench.reports.verification_report import Verification, print_verification
from plant_bench.runner.review import verification
from plant_bench.runner.review.submission import read_submission
from plant_bench.runner.review.verification import Checks, verify_episodes
from plant_bench.runner.run.folder import RunFolder
from plant_bench.runner.run.rescore_run import rescore_folder
from plant_bench.runner.run.summary_files import write_summary
from plant_bench.runner.workers.executors import Finished
from tests.unit.runner.test_rescore_run import recorded


@pytest.fixture
def run(tmp_path: Path) -> RunFolder:
    """A run of one episode whose record follows from its recording."""
    folder = recorded(tmp_path / "run", 0.1)
    (episode,) = rescore_folder(folder)
    assert episode.again is not None
    folder.save(episode.name, episode.again, None)
    write_summary(folder)
    return folder


@pytest.fixture
def here(monkeypatch: pytest.MonkeyPatch) -> None:
    """Run tasks in this process."""

    def run_tasks(
        tasks: Sequence[Any], function: Callable[..., Any], *, on_event: Any, **_: Any
    ) -> None:
        for index, task in enumerate(tasks):
            on_event(Finished(0, index, function(task, lambda _: None)))

    monkeypatch.setattr(verification, "run_tasks", run_tasks)


def checked(run: RunFolder) -> tuple[Checks, Verification]:
    submission = read_submission(run.path, selection="0", repetitions=1)
    checks = verify_episodes(submission, [], agent=None, workers=1, on_share=lambda _: None)
    return checks, Verification(submission, checks.simulated, "controls", 0, checks.rescored)


@pytest.mark.usefixtures("here")
def test_unchanged_record_is_confirmed(run: RunFolder):
    checks, _ = checked(run)

    assert [item.difference for item in checks.rescored] == [None]
    assert checks.simulated == []


@pytest.mark.usefixtures("here")
def test_better_record_outside_the_sample_is_rejected(
    run: RunFolder, capsys: pytest.CaptureFixture[str]
):
    (path,) = run.record_files()
    (record,) = run.results()
    run.save(path.stem, record.model_copy(update={"distance": 99.0}), None)
    write_summary(run)

    checks, result = checked(run)
    print_verification(result)

    difference = checks.rescored[0].difference
    assert difference is not None
    assert (difference.field, difference.told) == ("distance", "99.0")
    assert not result.confirmed
    said = capsys.readouterr().out
    assert "NOT CONFIRMED: 1 of 1 episode scored again from the recording" in said
    assert "Scored again from the recording: different" in said


@pytest.mark.usefixtures("here")
def test_broken_and_linked_recordings_are_rejected(run: RunFolder, tmp_path: Path):
    path = run.recording_path(run.record_files()[0].stem)
    path.rename(tmp_path / "elsewhere.parquet")
    path.symlink_to(tmp_path / "elsewhere.parquet")
    linked = checked(run)[0].rescored[0].difference
    path.unlink()
    path.write_bytes(b"ticks")
    broken = checked(run)[0].rescored[0].difference

    assert linked is not None
    assert linked.told == "symbolic link"
    assert broken is not None
    assert broken.told.startswith("Not a recording")


@pytest.mark.usefixtures("here")
def test_episode_without_a_recording_is_counted(run: RunFolder, capsys: pytest.CaptureFixture[str]):
    run.recording_path(run.record_files()[0].stem).unlink()

    checks, result = checked(run)
    print_verification(result)

    assert checks.rescored == []
    assert "0 of 1 episode scored again from the recording" in capsys.readouterr().out
