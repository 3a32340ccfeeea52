"""Describes the origin of a training's data, for the model card."""

from pathlib import Path

from plant_bench.runner.collect.data_folder import DataFolder, Origin
from plant_bench.runner.collect.request import CollectRequest
from plant_bench.untrusted_files import read_json

_SHOWN = 16  # characters of a checksum


def source_of(data: Path, episodes: int) -> str:
    """Return the origin of a data folder in one line, without paths.

    Args:
        data: The data folder.
        episodes: Number of its episodes that are used.

    Raises:
        InputError: The folder's collect.json is broken.
    """
    folder, name = DataFolder(data), data.resolve().name
    used = f"{episodes} episodes of {name}"
    origin = folder.origin()
    if origin is None:
        return f"{used}, of unknown origin (no collect.json)"
    request = CollectRequest(
        _frames(folder), origin.seed, origin.density, origin.perturb, origin.driver
    )
    drove = f", driver {origin.driver_checksum[:_SHOWN]}" if origin.driver else ""
    return f"{used}: `{request.command(name)}` ({_checksums(origin)}{drove})"


def _checksums(origin: Origin) -> str:
    return f"{origin.agent} {origin.agent_checksum[:_SHOWN]}, rules {origin.rules[:_SHOWN]}"


def _frames(folder: DataFolder) -> int:
    """Return the requested number of frames; the present number if data.json does not state it."""
    try:
        return int(read_json(folder.path / "data.json")["request"]["frames"])
    except (OSError, KeyError, TypeError, ValueError, OverflowError):
        return sum(note.frames for note in folder.notes() if not note.left_out)
