"""`train` names the recording that it cannot use in one line, once."""

import json
import shutil
import sys
from collections.abc import Callable
from pathlib import Path

import pyarrow.parquet as pq
import pytest

from plant_bench.cli import main
from plant_bench.data.recording_file import METADATA_KEY


@pytest.fixture
def refusal(
    data: Path, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> Callable[[], str]:
    """Returns all that `train` prints; it must end with exit code 2 and leave no model."""

    def train() -> str:
        model = data.parent / "model"
        line = ["train", "plant", "--data", str(data), "--out", str(model), "--epochs", "1"]
        line += ["--work", str(data.parent / "work")]
        monkeypatch.setattr(sys, "argv", ["plant-bench", *line])
        with pytest.raises(SystemExit) as ended:
            main()
        assert ended.value.code == 2
        assert not model.exists()
        said = capfd.readouterr()
        return said.out + said.err

    return train


def test_recording_that_was_cut_off_is_named_once(data: Path, refusal: Callable[[], str]) -> None:
    file = data / "episodes" / "b.parquet"
    file.write_bytes(file.read_bytes()[:-1000])

    said = refusal()

    assert said.count("b.parquet") == 1
    assert "Traceback" not in said
    assert len([line for line in said.splitlines() if line.startswith("plant-bench: ")]) == 1


def test_recording_that_is_there_twice_is_refused(data: Path, refusal: Callable[[], str]) -> None:
    file = data / "episodes" / "b.parquet"
    table = pq.read_table(file)
    about = json.loads(table.schema.metadata[METADATA_KEY]) | {"scenario": "e1f5"}
    pq.write_table(table.replace_schema_metadata({METADATA_KEY: json.dumps(about)}), file)
    shutil.copy(file, data / "episodes" / "b_copy.parquet")

    said = refusal()

    assert "two are of the same episode: b.parquet and b_copy.parquet" in said
    assert "Traceback" not in said


def test_recording_that_is_missing_is_refused(data: Path, refusal: Callable[[], str]) -> None:
    (data / "records").mkdir()
    for name in "abcd":
        (data / "records" / f"{name}.json").write_text('{"left_out": ""}')

    said = refusal()

    assert "is missing: d." in said
    assert "Traceback" not in said
