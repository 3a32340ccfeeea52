"""Lists and builds the towns for training data: the benchmark's, and further layouts of them."""

import tempfile
from dataclasses import dataclass
from pathlib import Path

from plant_bench.atomic_files import move_whole, write_whole_text
from plant_bench.errors import InputError
from plant_bench.towns.generate import NET_FILE, TOWN_FILE, make_town, town_names, town_spec

LAYOUTS = 2  # further layouts of each benchmark town
FIRST_LAYOUT = 1001  # base of their seeds; the benchmark's own seeds are small
SEED_TRIES = 5  # seeds to try for one layout


@dataclass(frozen=True)
class TrainingTown:
    """A town for data collection.

    Attributes:
        name: "town01" for the benchmark's own, "town01-b" and so on for further layouts.
        base: The benchmark's town with the same spec.
        layout: Number of the further layout, from 1; 0 for the benchmark's own.
    """

    name: str
    base: str
    layout: int


def training_towns() -> list[TrainingTown]:
    """Return the towns in the order of visits: all characters in turn."""
    return [
        TrainingTown(f"{base}-{'abcdefgh'[layout]}" if layout else base, base, layout)
        for layout in range(LAYOUTS + 1)
        for base in town_names()
    ]


def build_training_town(town: TrainingTown, folder: Path) -> None:
    """Build a further layout atomically into a folder of its name, unless it exists.

    Args:
        town: The town; nothing is done for the benchmark's own.
        folder: Parent folder of the towns.

    Raises:
        InputError: No seed gives a valid town.
    """
    if not town.layout or (folder / town.name / TOWN_FILE).is_file():
        return
    spec = town_spec(town.base).model_copy(update={"name": town.name})
    fault: InputError | None = None
    for seed in range(
        FIRST_LAYOUT + 100 * town.layout, SEED_TRIES + FIRST_LAYOUT + 100 * town.layout
    ):
        try:
            net, made = make_town(spec, seed)
        except InputError as error:
            fault = error
            continue
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=folder, prefix=".building-") as work:
            fresh = Path(work) / town.name
            fresh.mkdir()
            for file, text in ((NET_FILE, net), (TOWN_FILE, made.to_json())):
                write_whole_text(fresh / file, text)
            move_whole(fresh, folder / town.name)
        return
    raise fault or InputError(f"No valid layout of {town.name}.")
