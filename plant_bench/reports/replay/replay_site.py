"""Writes the folder of replays: one page, and a data script for each town and episode.

replay.html                     opens replay.html#<id>, or #<id>&<id2> side by side
replays/<run>/<episode>.js      one episode, loaded only when it is opened
replays/index.js                the list of all replays
towns/<town>.js                 the shapes of one town

The scripts call methods of `plantBench`, the page's only global (`web/src/replay/loader.js`).
"""

import hashlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from plant_bench.agents.loading.checksum import agent_checksum
from plant_bench.atomic_files import write_whole_text
from plant_bench.errors import InputError, PlantBenchError
from plant_bench.reports.replay.replay_episode import load_episode, missing_script, replay_script
from plant_bench.reports.replay.replay_page import replay_page
from plant_bench.reports.replay.replay_source import ReplaySource, is_replay_id, town_folders_of
from plant_bench.reports.replay.town_shapes import town_script
from plant_bench.runner.review.expert_braking import EXPERT
from plant_bench.runner.workers.executors import Event, Finished, Lost, run_tasks
from plant_bench.text_escaping import script_json
from plant_bench.untrusted_files import parse_json, read_text
from plant_bench.world.town import load_town, town_checksum

STAMP = "// made from "
INDEX = "replays/index.js"
LEADERBOARD = "leaderboard.html"  # linked by the page if it exists


@dataclass(frozen=True)
class _Task:
    source: ReplaySource
    path: Path
    stamp: str


def write_replays(
    out: Path,
    sources: Sequence[ReplaySource],
    *,
    workers: int,
    progress: Callable[[int, int], None],
) -> None:
    """Write the page, and the replays that do not exist yet.

    A replay that cannot be made does not stop the others: its page shows the error, and it is tried
    again the next time.

    Args:
        out: Folder of the site.
        sources: Episodes to show.
        workers: Number of worker processes; with 1, no process is started.
        progress: Called with the number of finished and of all replays.

    Raises:
        InputError: Two sources have the same id, or the folder cannot be written to.
    """
    doubled = len(sources) - len({source.id for source in sources})
    if doubled:
        message = f"{doubled} replays have the same id as another: expected unique ids."
        raise InputError(message)
    write_script(out / "replay.html", replay_page())
    leaderboard = (out / LEADERBOARD).is_file()
    write_script(out / INDEX, _index(sources, out, leaderboard=leaderboard))
    for town, source in sorted({source.result.town: source for source in sources}.items()):
        _write_town(out, town, town_folders_of(source))
    tasks = [_Task(source, replay_path(out, source.id), _stamp(source)) for source in sources]
    missing = [task for task in tasks if not _is_made(task)]
    done = len(tasks) - len(missing)
    progress(done, len(tasks))
    if workers == 1 or len(missing) < 2:
        for count, task in enumerate(missing, start=done + 1):
            write_replay(task)
            progress(count, len(tasks))
        return
    _write_with(workers, missing, lambda count: progress(done + count, len(tasks)))


def replay_path(out: Path, replay_id: str) -> Path:
    """Return the path of the script of a replay."""
    return out / "replays" / f"{replay_id}.js"


def write_replay(task: _Task, _report: Callable[[float], None] | None = None) -> None:
    """Write one replay, or its error message; called in a worker."""
    try:
        text = f"{STAMP}{task.stamp}\n{replay_script(load_episode(task.source))}"
    except PlantBenchError as error:
        text = missing_script(task.source, _without_folder(str(error), task.source.recording))
    except Exception as error:  # noqa: BLE001  a broken file may raise anything
        text = missing_script(task.source, f"Its recording is broken ({type(error).__name__}).")
    write_script(task.path, text)


def _without_folder(text: str, path: Path) -> str:
    """Return a text without the path's folder, which a published page should not show."""
    return text.replace(str(path), path.name)


def write_script(path: Path, text: str) -> None:
    """Write a file of the site atomically.

    Raises:
        InputError: It cannot be written.
    """
    try:
        write_whole_text(path, text)
    except OSError as error:
        message = f"Cannot write {path}: {error.strerror}. Choose another folder."
        raise InputError(message) from error


def _write_with(workers: int, tasks: list[_Task], progress: Callable[[int], None]) -> None:
    ended = 0

    def listen(event: Event) -> None:
        nonlocal ended
        if isinstance(event, Lost):
            task = tasks[event.task]
            write_script(task.path, missing_script(task.source, event.reason))
        if isinstance(event, Lost | Finished):
            ended += 1
            progress(ended)

    run_tasks(tasks, write_replay, workers=workers, on_event=listen)


def _write_town(out: Path, name: str, folders: tuple[Path, ...]) -> None:
    """Write a town's script if it changed; delete it if the town cannot be loaded."""
    path = out / "towns" / f"{name}.js"
    try:
        checksum = town_checksum(name, folders)
        stamp = f"{STAMP}{checksum} {_code()}\n"
        if not _begins(path, stamp):
            write_script(path, stamp + town_script(load_town(name, folders), checksum))
    except InputError:
        path.unlink(missing_ok=True)


def _index(sources: Sequence[ReplaySource], out: Path, *, leaderboard: bool) -> str:
    """Return the index script: these replays, and earlier ones that still exist."""
    entries: list[dict[str, object]] = [
        {
            "id": source.id,
            "title": source.title,
            "route": source.result.route,
            "repetition": source.result.repetition,
            "scenario": source.result.scenario,
            "status": source.result.status.value,
            "drivingScore": round(source.result.driving_score, 2),
            "infractions": len(source.result.infractions),
        }
        for source in sources
    ]
    if entries:
        entries += _listed_before(out, {source.id for source in sources}, set(entries[0]))
    content = {"leaderboard": leaderboard, "replays": entries}
    return f"plantBench.setIndex({script_json(content)});\n"


def _listed_before(out: Path, new: set[str], keys: set[str]) -> list[dict[str, object]]:
    """Return the entries of the present index for other existing replays; none if it is broken."""
    try:
        text = read_text(out / INDEX)
        listed = parse_json(text[text.index("(") + 1 : text.rindex(")")])["replays"]
        known = [item for item in listed if set(item) == keys and is_replay_id(item["id"])]
    except (OSError, ValueError, TypeError, KeyError):
        return []
    return [
        item for item in known if item["id"] not in new and replay_path(out, item["id"]).is_file()
    ]


def _is_made(task: _Task) -> bool:
    return _begins(task.path, f"{STAMP}{task.stamp}\n")


def _begins(path: Path, text: str) -> bool:
    try:
        with path.open(encoding="utf-8", newline="\n") as file:
            return file.read(len(text)) == text
    except (OSError, UnicodeDecodeError):
        return False


def _stamp(source: ReplaySource) -> str:
    """Return a hash of everything that a replay depends on."""
    digest = hashlib.sha256(f"{_code()}|{source.title}|{source.agent}|{_planner(source)}".encode())
    digest.update(source.result.to_json().encode())
    if source.ask_expert is not None:
        digest.update(f"with the expert {_checksum(EXPERT)}".encode())
    try:
        with source.recording.open("rb") as file:
            digest.update(hashlib.file_digest(file, "sha256").digest())
    except OSError:
        digest.update(b"no recording")
    return digest.hexdigest()


def _planner(source: ReplaySource) -> str:
    """Return the checksum of the planner, or the error message if it cannot be loaded."""
    try:
        return _checksum(source.agent)
    except PlantBenchError as error:
        return str(error)


@cache
def _checksum(agent: str) -> str:
    return agent_checksum(agent)


@cache
def _code() -> str:
    """Return a hash of the code that makes replays."""
    digest = hashlib.sha256()
    for path in sorted(Path(__file__).parent.glob("*.py")):
        digest.update(path.read_bytes())
    return digest.hexdigest()[:16]
