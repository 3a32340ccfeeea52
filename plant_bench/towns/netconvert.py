"""Converts a street plan to a SUMO network with netconvert, and checks the network with SUMO."""

import os
import re
import subprocess
import tempfile
from pathlib import Path

import numpy as np
import sumo

from plant_bench.errors import InputError
from plant_bench.towns.street_plan import StreetPlan
from plant_bench.towns.town_spec import TownSpec

TIMEOUT_S = 120


def convert(plan: StreetPlan, spec: TownSpec, seed: int) -> str:
    """Return the SUMO network (XML text) of a street plan; equal input gives equal text.

    Raises:
        InputError: netconvert failed or printed a warning.
    """
    with tempfile.TemporaryDirectory() as folder:
        plan.write(Path(folder))
        run = _run("netconvert", _options(spec), folder)
        if run.returncode != 0 or run.stderr.strip():
            raise InputError(
                f"netconvert failed on the street plan of {spec.name} (seed {seed}): "
                f"{run.stderr.strip() or run.returncode}. Change the town's spec or seed."
            )
        text = (Path(folder) / "town.net.xml").read_text(encoding="utf-8")
    return _with_offsets(without_header(text), spec, seed)


def sumo_errors(net: str) -> list[str]:
    """Return SUMO's errors and warnings on loading a network (XML text) and simulating 130 s."""
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "town.net.xml").write_text(net, encoding="utf-8")
        options = ["-n", "town.net.xml", "--end", "130", "--no-step-log", "true"]
        run = _run("sumo", options, folder)
    lines = [line for line in run.stderr.splitlines() if line.strip()]
    return lines or ([f"SUMO failed with exit code {run.returncode}"] if run.returncode else [])


def _run(program: str, options: list[str], folder: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [str(Path(sumo.SUMO_HOME) / "bin" / program), *options],
        cwd=folder,
        env={**os.environ, "SUMO_HOME": sumo.SUMO_HOME, "LC_ALL": "C"},
        capture_output=True,
        text=True,
        check=False,
        timeout=TIMEOUT_S,
    )


def _options(spec: TownSpec) -> list[str]:
    options = {
        "--node-files": "plan.nod.xml",
        "--edge-files": "plan.edg.xml",
        "--connection-files": "plan.con.xml",
        "--output-file": "town.net.xml",
        "--offset.disable-normalization": "true",
        "--junctions.internal-link-detail": "20",
        "--junctions.limit-turn-speed": "3",
        "--default.lanewidth": f"{spec.lane_width:g}",
        "--no-turnarounds": "true",
        "--crossings.guess": "true",
        "--geometry.check-overlap": "0.5",
        "--tls.default-type": spec.signals.program,
        "--tls.yellow.time": f"{spec.signals.yellow:g}",
        "--tls.allred.time": f"{spec.signals.all_red:g}",
        "--tls.cycle.time": f"{spec.signals.cycle:g}",
    }
    return [word for pair in options.items() for word in pair]


def without_header(text: str) -> str:
    """Remove the header comment, which contains the date, from a network (XML text)."""
    return re.sub(r"\s*<!--.*?-->\s*", "\n\n", text, count=1, flags=re.DOTALL)


def _with_offsets(text: str, spec: TownSpec, seed: int) -> str:
    """Set a random offset for the cycle of each fixed-time signal."""
    rng = np.random.default_rng([seed, 7])

    def random_offset(match: re.Match[str]) -> str:
        return f"{match[1]}{rng.integers(0, int(spec.signals.cycle))}.00{match[2]}"

    return re.sub(r'(<tlLogic [^>]*type="static"[^>]*offset=")[\d.]+(")', random_offset, text)
