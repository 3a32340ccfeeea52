import pytest

from plant_bench.errors import InputError
from plant_bench.reports.replay import replay_site as site
from plant_bench.reports.replay.replay_page import replay_page
from plant_bench.reports.replay.replay_site import write_replays
from tests.unit.reports.replay.drives import drive
from tests.unit.reports.replay.unpacking import facts_of


def write(out, *sources, workers=1):
    told = []
    write_replays(out, sources, workers=workers, progress=lambda *counts: told.append(counts))
    return told


def text(out, source):
    return (out / "replays" / f"{source.id}.js").read_text(encoding="utf-8")


def test_site_has_a_page_towns_replays_and_an_index(tmp_path, source):
    out = tmp_path / "out"
    other = drive(tmp_path, run="theirs")
    assert write(out, source, other) == [(0, 2), (1, 2), (2, 2)]
    assert facts_of(text(out, source))["id"] == "ours/town01-0_r0_abc"
    assert facts_of((out / "towns" / "town01.js").read_text())["name"] == "town01"
    index = facts_of((out / "replays" / "index.js").read_text())
    assert [item["id"] for item in index["replays"]] == [source.id, other.id]
    assert not index["leaderboard"]
    assert not list(out.rglob("*.part"))


def test_index_links_to_a_leaderboard_beside_it(tmp_path, source):
    (tmp_path / "leaderboard.html").write_text("")
    write(tmp_path, source)
    assert facts_of((tmp_path / "replays" / "index.js").read_text())["leaderboard"]


def test_only_changed_replays_are_rebuilt(tmp_path, source, monkeypatch):
    write(tmp_path, source)
    made = []
    original = site.load_episode
    monkeypatch.setattr(site, "load_episode", lambda item: made.append(item.id) or original(item))
    assert write(tmp_path, source) == [(1, 1)]
    assert made == []
    write(tmp_path, drive(tmp_path, title="renamed"))
    write(tmp_path, drive(tmp_path, title="renamed", seconds=5.0))
    assert len(made) == 2
    monkeypatch.setattr(site, "_code", lambda: "newer")
    write(tmp_path, drive(tmp_path, title="renamed", seconds=5.0))
    assert len(made) == 3


def test_broken_recording_is_skipped_and_retried_next_time(tmp_path, source):
    other = drive(tmp_path, run="theirs")
    whole = source.recording.read_bytes()
    source.recording.write_bytes(b"broken")
    assert write(tmp_path, source, other)[-1] == (2, 2)
    error = facts_of(text(tmp_path, source))["error"]
    assert "Not a recording: town01-0_r0_abc.parquet" in error
    assert str(tmp_path) not in error, "pages are shown to others"
    assert "data" in facts_of(text(tmp_path, other))
    source.recording.write_bytes(whole)
    write(tmp_path, source, other)
    assert "data" in facts_of(text(tmp_path, source))


def test_two_episodes_with_one_id_are_refused(tmp_path, source):
    with pytest.raises(InputError, match="same id as another"):
        write(tmp_path, source, source)


def test_unwritable_folder_is_refused_with_one_message(tmp_path, source):
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="Cannot write"):
        write(tmp_path / "file", source)


def test_workers_write_identical_files(tmp_path, source):
    other = drive(tmp_path, run="theirs")
    write(tmp_path / "one", source, other)
    write(tmp_path / "two", source, other, workers=2)
    for item in (source, other):
        assert text(tmp_path / "one", item) == text(tmp_path / "two", item)


def test_replay_page_loads_nothing_from_the_network():
    page = replay_page()
    assert "{{" not in page
    assert "Content-Security-Policy" in page
    assert "default-src 'none'" in page
    assert "http" not in page.replace("http-equiv", "")
    assert "innerHTML" not in page
    assert len(page) < 150_000


def test_existing_replays_stay_in_the_index(tmp_path, source):
    out = tmp_path / "out"
    other, gone = drive(tmp_path, run="theirs"), drive(tmp_path, run="gone")
    write(out, other, gone)
    (out / "replays" / f"{gone.id}.js").unlink()
    write(out, source)
    index = facts_of((out / "replays" / "index.js").read_text())
    assert [item["id"] for item in index["replays"]] == [source.id, other.id]


@pytest.mark.parametrize("text", ["", "plantBench.setIndex({", 'x({"replays": [1]})', "x([])"])
def test_broken_index_is_rebuilt(tmp_path, source, text):
    (tmp_path / "replays").mkdir()
    (tmp_path / "replays" / "index.js").write_text(text)
    write(tmp_path, source)
    index = facts_of((tmp_path / "replays" / "index.js").read_text())
    assert [item["id"] for item in index["replays"]] == [source.id]
