import json
import os
import subprocess
import sys
from dataclasses import asdict, replace
from pathlib import Path

import pytest

from plant_bench.errors import InputError
from plant_bench.runner.run import run_lock as claims
from plant_bench.runner.run.run_lock import LockInfo, Shard, locked


@pytest.fixture
def held(tmp_path):
    """Write the lock of another process into the folder."""

    def hold(**facts) -> Path:
        usual = LockInfo("whole", "v", "elsewhere", 7, 1, "2026-01-01 10:00:00", "t")
        path = tmp_path / "claims" / f"{facts.get('what', 'whole')}.json"
        path.parent.mkdir(exist_ok=True)
        path.write_text(json.dumps(asdict(replace(usual, **facts))))
        return path

    return hold


def test_second_run_in_a_folder_is_refused_with_the_lock_owner(tmp_path):
    with (
        locked(tmp_path, None, "v"),
        pytest.raises(InputError, match=rf"A run \(host .*, process {os.getpid()}, since 20"),
        locked(tmp_path, None, "v"),
    ):
        pass


def test_lock_is_released_when_the_run_ends(tmp_path):
    for _ in range(2):
        with locked(tmp_path, None, "v"):
            assert (tmp_path / "claims").is_dir()
    assert not list(tmp_path.iterdir())


def test_shards_of_one_division_run_concurrently(tmp_path):
    with locked(tmp_path, Shard(1, 3), "v"), locked(tmp_path, Shard(3, 3), "v"):
        assert len(list((tmp_path / "claims").iterdir())) == 2


@pytest.mark.parametrize(
    ("what", "version"),
    [("whole", "v"), ("1of3", "v"), ("1of2", "v"), ("2of3", "another agent")],
)
def test_shard_that_may_overlap_with_another_run_is_refused(tmp_path, held, what, version):
    held(what=what, version=version)

    with pytest.raises(InputError, match="is writing to"), locked(tmp_path, Shard(1, 3), "v"):
        pass
    assert len(list((tmp_path / "claims").iterdir())) == 1


def test_whole_run_is_refused_while_shards_run(tmp_path):
    with (
        locked(tmp_path, Shard(2, 3), "v"),
        pytest.raises(InputError, match="Shard 2/3"),
        locked(tmp_path, None, "v"),
    ):
        pass


def test_lock_of_a_dead_local_process_is_taken_over(tmp_path):
    code = f"""
import os
from pathlib import Path
from plant_bench.runner.run.run_lock import Shard, locked
here = Path({str(tmp_path)!r})
with locked(here, None, "v"), locked(here / "b", Shard(1, 2), "v"):
    os._exit(9)
"""
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 9
    assert (tmp_path / "claims" / "whole.json").is_file()

    with locked(tmp_path, None, "v"), locked(tmp_path / "b", None, "v"):
        pass


def test_lock_of_a_reused_process_id_is_taken_over(tmp_path, held):
    path = held(host=claims.socket.gethostname(), pid=os.getpid(), born=1)
    before = path.read_text()

    with locked(tmp_path, None, "v"):
        assert path.read_text() != before


def test_lock_of_another_host_expires_without_a_heartbeat(tmp_path, held):
    path = held()
    with pytest.raises(InputError, match="host elsewhere, process 7"), locked(tmp_path, None, "v"):
        pass

    old = path.stat().st_mtime - claims.EXPIRY - 10
    os.utime(path, (old, old))
    with locked(tmp_path, None, "v"):
        pass


def test_held_lock_updates_its_heartbeat(tmp_path, monkeypatch):
    monkeypatch.setattr(claims, "HEARTBEAT", 0.01)
    with locked(tmp_path, None, "v"):
        path = tmp_path / "claims" / "whole.json"
        os.utime(path, (1, 1))
        for _ in range(500):
            if path.stat().st_mtime > 1:
                break
            claims.time.sleep(0.01)
        assert path.stat().st_mtime > 1


def test_removed_lock_folder_is_created_again(tmp_path, monkeypatch):
    make = Path.mkdir

    def made_and_removed(path, **settings):
        make(path, **settings)
        monkeypatch.undo()
        path.rmdir()  # as whoever held the last claim does

    monkeypatch.setattr(Path, "mkdir", made_and_removed)

    with locked(tmp_path, None, "v"):
        assert (tmp_path / "claims" / "whole.json").is_file()


def test_half_written_lock_expires_only_after_a_while(tmp_path):
    (tmp_path / "claims").mkdir()
    path = tmp_path / "claims" / "whole.json"
    path.write_text('{"what"')

    with pytest.raises(InputError, match="host unknown"), locked(tmp_path, None, "v"):
        pass
    os.utime(path, (1, 1))
    with locked(tmp_path, None, "v"):
        pass


def test_shards_split_all_episodes_evenly_without_overlap():
    lengths = [900.0, 100.0, 120.0, 500.0, 800.0, 420.0, 300.0]
    parts = [Shard(number, 3).of(range(7), lengths) for number in (1, 2, 3)]

    assert sorted(place for part in parts for place in part) == list(range(7))
    loads = [sum(lengths[place] for place in part) for part in parts]
    assert max(loads) - min(loads) <= 120.0


@pytest.mark.parametrize("text", ["0/3", "4/3", "1", "a/b", "1/0", "-1/3"])
def test_invalid_shard_is_refused(text):
    with pytest.raises(InputError, match="expected I/N"):
        Shard.parse(text)
    assert str(Shard.parse("2/3")) == "2/3"


@pytest.mark.parametrize(
    "text",
    [
        "[" * 100_000,
        '{"what": "whole"}',
        json.dumps(asdict(LockInfo("2", "v", "elsewhere", 7, 1, "x", "t"))),
        json.dumps(asdict(LockInfo("1of2", "v", "elsewhere", 7, 1, "x", "t")) | {"what": 5}),
        json.dumps(asdict(LockInfo("1of2", "v", "elsewhere", 7, 1, "x", "t")) | {"pid": "../self"}),
        json.dumps(asdict(LockInfo("1of2", "v", "elsewhere", 7, 1, "x", "t")) | {"pid": 10**30}),
    ],
)
def test_unreadable_lock_counts_as_held(tmp_path, text):
    (tmp_path / "claims").mkdir()
    (tmp_path / "claims" / "2of2.json").write_text(text)

    with (
        pytest.raises(InputError, match="host unknown"),
        locked(tmp_path, Shard(1, 2), "v"),
    ):
        pass
