"""Packs are complete or absent, and nothing is built twice."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from plant_bench.errors import InputError
from plant_bench.training import column_store as packs
from plant_bench.training.column_store import EpisodeBuilder, open_packs

made: list[int] = []


def make(count: int) -> tuple[dict[str, np.ndarray], dict[str, Any]]:
    made.append(count)
    rows = np.arange(count, dtype=np.float32)
    return {"a": rows, "b": np.stack((rows, -rows), axis=1).astype(np.int64)}, {"count": count}


def make_but_two(count: int) -> tuple[dict[str, np.ndarray], dict[str, Any]]:
    if count == 2:
        message = "two is too much"
        raise InputError(message)
    return make(count)


def make_other_shapes(count: int) -> tuple[dict[str, np.ndarray], dict[str, Any]]:
    return {"a": np.zeros((2, count))}, {}


@pytest.fixture(autouse=True)
def forget() -> None:
    made.clear()


def test_episodes_are_concatenated_in_each_column(tmp_path: Path) -> None:
    (pack,) = open_packs(tmp_path, {"x": 3, "y": 0, "z": 2}, EpisodeBuilder(make))
    assert pack.columns["a"].tolist() == [0, 1, 2, 0, 1]
    assert pack.columns["b"].tolist() == [[0, 0], [1, -1], [2, -2], [0, 0], [1, -1]]
    assert [episode.facts["count"] for episode in pack.episodes] == [3, 0, 2]
    assert not pack.columns["a"].flags.writeable
    assert isinstance(pack.columns["a"].base, np.memmap)
    (empty,) = open_packs(tmp_path / "empty", {"x": 0}, EpisodeBuilder(make))
    assert empty.columns["b"].shape == (0, 2)


def test_existing_packs_are_not_rebuilt(tmp_path: Path) -> None:
    open_packs(tmp_path, {"x": 3}, EpisodeBuilder(make))
    found = open_packs(tmp_path, {"x": 3, "y": 2}, EpisodeBuilder(make))
    assert made == [3, 2]
    assert sorted(episode.name for pack in found for episode in pack.episodes) == ["x", "y"]
    open_packs(tmp_path, {"y": 2}, EpisodeBuilder(make))
    assert made == [3, 2]
    assert not list((tmp_path / "parts").iterdir())


def test_interrupted_packing_resumes_with_the_missing_part(tmp_path: Path) -> None:
    tasks = {"x": 1, "y": 2, "z": 3}
    with pytest.raises(InputError, match="two is too much"):
        open_packs(tmp_path, tasks, EpisodeBuilder(make_but_two))
    assert not list(tmp_path.glob("pack-*"))
    open_packs(tmp_path, tasks, EpisodeBuilder(make))
    assert made == [1, 2, 3]


def test_a_pack_is_never_half_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """If writing fails, there is no pack, and the same call builds it."""
    tasks = {"x": 1, "y": 2}
    for step in ("write_whole_text", "_read_part"):

        def fail(*_: object) -> None:
            raise KeyboardInterrupt

        with monkeypatch.context() as patch:
            patch.setattr(packs, step, fail)
            with pytest.raises(KeyboardInterrupt):
                open_packs(tmp_path, tasks, EpisodeBuilder(make))
        assert not list(tmp_path.glob("pack-*"))
    (tmp_path / "pack-0123.abcd.part").mkdir()  # of a process that was killed
    (pack,) = open_packs(tmp_path, tasks, EpisodeBuilder(make))
    assert made == [1, 2]
    assert pack.columns["a"].tolist() == [0, 0, 1]


def test_rows_of_different_shapes_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="all frames must give arrays of one shape"):
        open_packs(tmp_path, {"x": 1, "y": 2}, EpisodeBuilder(make_other_shapes))
    assert not list(tmp_path.glob("pack-*"))


def test_broken_pack_raises_input_error(tmp_path: Path) -> None:
    (pack,) = open_packs(tmp_path, {"x": 3}, EpisodeBuilder(make))
    file = pack.folder / "a.npy"
    whole = file.read_bytes()
    for broken in (whole[:-1], whole[:50], b"", whole.replace(b"(3,)", b"(2,)")):
        file.write_bytes(broken)
        with pytest.raises(InputError, match="Broken pack"):
            open_packs(tmp_path, {"x": 3}, EpisodeBuilder(make))
