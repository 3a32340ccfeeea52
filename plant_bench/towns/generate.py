"""Generates a town from its spec and seed, and writes `town.net.xml` and `town.json`."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from plant_bench.atomic_files import write_whole_text
from plant_bench.data_files import networks_dir
from plant_bench.errors import InputError
from plant_bench.towns.characters import CHARACTERS
from plant_bench.towns.extract import extract_town
from plant_bench.towns.netconvert import convert, sumo_errors
from plant_bench.towns.town_checks import find_faults
from plant_bench.towns.town_image import save_picture
from plant_bench.towns.town_spec import TownSpec, read_spec
from plant_bench.towns.unseen_towns import UNSEEN
from plant_bench.world.town import Life, Town

SPEC_FILE, NET_FILE, TOWN_FILE, PICTURE_FILE = (
    "spec.toml",
    "town.net.xml",
    "town.json",
    "picture.png",
)
ATTEMPTS = 12


def town_names() -> list[str]:
    """Return the names of the benchmark's towns, sorted."""
    return sorted(path.parent.name for path in networks_dir().glob(f"*/{SPEC_FILE}"))


def stored_towns() -> list[str]:
    """Return the names of the towns in `networks/`: the benchmark's, then the unseen ones."""
    return [*town_names(), *UNSEEN]


def town_spec(name: str) -> TownSpec:
    """Return the spec of a stored town.

    Raises:
        InputError: There is no such town.
    """
    if name not in stored_towns():
        raise InputError(f"There is no town {name!r}. Known towns: {', '.join(stored_towns())}.")
    if name not in UNSEEN:
        return read_spec(networks_dir() / name / SPEC_FILE)
    unseen = UNSEEN[name]
    return town_spec(unseen.base).model_copy(update={"name": name, "seed": unseen.seed})


def make_town(spec: TownSpec, seed: int) -> tuple[str, Town]:
    """Generate layouts from the seed until one passes all checks.

    Returns:
        The SUMO network (XML text) and the town.

    Raises:
        InputError: No attempt passed; the message lists the faults of the last one.
    """
    faults: list[str] = []
    for attempt in range(ATTEMPTS):
        rng = np.random.default_rng([seed, attempt])
        plan = CHARACTERS[spec.layout.character](spec, rng)
        try:
            net = convert(plan, spec, seed)
        except InputError as error:
            faults = [str(error)]
            continue
        town = replace(extract_town(net, spec.name), life=life_of(spec))
        faults = [*find_faults(town, spec.requires), *sumo_errors(net)]
        if not faults:
            return net, town
    raise InputError(
        f"No valid layout of {spec.name} with seed {seed} in {ATTEMPTS} attempts. Faults of the "
        f"last one: {'; '.join(faults[:8])}. Try another seed or change the spec."
    )


def life_of(spec: TownSpec) -> Life:
    """Convert a spec's traffic mix, pedestrians and parked cars to a town's `Life`."""
    return Life(spec.life.mix, spec.life.walkers_per_km, spec.life.parking)


def build_town(name: str, *, seed: int | None = None, out: Path | None = None) -> Path:
    """Generate a town and its picture, and return its folder.

    Args:
        name: A town of `stored_towns()`.
        seed: Seed of the layout; the spec's by default.
        out: Output folder; by default the town's own in `networks/`.

    Raises:
        InputError: There is no such town, or the seed gives no valid layout; nothing is written.
    """
    spec = town_spec(name)
    folder = out if out is not None else networks_dir() / name
    net, town = make_town(spec, spec.seed if seed is None else seed)
    save_picture(town, folder / PICTURE_FILE)
    for file, text in ((NET_FILE, net), (TOWN_FILE, town.to_json())):
        write_whole_text(folder / file, text)
    return folder


def check_town(name: str) -> list[str]:
    """Generate a town again and return how its stored files differ; empty if they do not."""
    spec = town_spec(name)
    net, town = make_town(spec, spec.seed)
    differences = []
    for file, text in ((NET_FILE, net), (TOWN_FILE, town.to_json())):
        stored = networks_dir() / name / file
        if not stored.is_file():
            differences.append(f"{file} is missing: build the town.")
        elif stored.read_bytes() != text.encode():
            differences.append(f"{file} differs from what the town's spec and seed give.")
    return differences
