"""Atomic file writes: the order of operations, and what remains after a failure."""

import os
from pathlib import Path

import pytest

from plant_bench.atomic_files import move_whole, write_whole, write_whole_text


@pytest.fixture
def said(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """The operations on the disk, in order."""
    found: list[str] = []
    sync, replace = os.fsync, Path.replace

    def told_sync(descriptor: int) -> None:
        place = Path(f"/proc/self/fd/{descriptor}").readlink()
        found.append("folder synced" if place.is_dir() else "content synced")
        sync(descriptor)

    def told_replace(self: Path, target: Path) -> Path:
        found.append("renamed")
        return replace(self, target)

    monkeypatch.setattr(os, "fsync", told_sync)
    monkeypatch.setattr(Path, "replace", told_replace)
    return found


def test_content_is_synced_before_the_rename_and_the_folder_after(
    tmp_path: Path, said: list[str]
) -> None:
    write_whole_text(tmp_path / "new" / "a.json", "text\n")

    assert said == ["content synced", "renamed", "folder synced"]
    assert (tmp_path / "new" / "a.json").read_bytes() == b"text\n"


def test_moved_file_is_synced_in_its_new_folder(tmp_path: Path, said: list[str]) -> None:
    (tmp_path / "a").touch()

    move_whole(tmp_path / "a", tmp_path / "b")

    assert said == ["renamed", "folder synced"]


def test_failed_write_keeps_the_old_file_only(tmp_path: Path) -> None:
    write_whole_text(tmp_path / "a", "old")

    with pytest.raises(OSError, match="full"):
        write_whole(tmp_path / "a", half_of_it)

    assert [path.name for path in tmp_path.iterdir()] == ["a"]
    assert (tmp_path / "a").read_text() == "old"


def half_of_it(part: Path) -> None:
    part.write_text("half of the ne")
    raise OSError(28, "full")


def test_symlink_at_the_target_is_replaced_and_not_followed(tmp_path: Path) -> None:
    (tmp_path / "victim").write_text("mine")
    (tmp_path / "a").symlink_to(tmp_path / "victim")

    write_whole_text(tmp_path / "a", "theirs")

    assert (tmp_path / "victim").read_text() == "mine"
