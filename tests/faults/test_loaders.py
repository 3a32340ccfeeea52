"""Broken files: each loader returns the object or refuses with one line, for mutated files."""

import importlib
import pickle
import random
import resource
import subprocess
import sys
from pathlib import Path

import pytest

from plant_bench.agents.plant.config import SIZES
from plant_bench.errors import InputError, PlantBenchError

ROOT = Path(__file__).parents[2]
QUICK = (
    "routes", "town", "record", "timing", "rfds", "carla", "recording", "collect", "visits",
    "claim", "answer", "carlaroutes", "townnet", "osm", "drive", "report",
)  # fmt: skip
CASES = dict.fromkeys(QUICK, 60) | {
    "carlaroutes": 25, "townnet": 25, "osm": 5, "drive": 15, "report": 15,
}  # fmt: skip
FUZZ = """
import argparse, os, subprocess, sys
from pathlib import Path
sys.path.insert(0, {folder!r})
import fuzz
from fuzzing.form import Format
from plant_bench.errors import InputError

ONCE = Path({elsewhere!r}).with_name("died")

def refuses(box):
    raise InputError("two\\nlines are one line")

WAYS = dict(
    refuses=refuses,
    reads=lambda box: (box / "f").read_bytes(),
    raises=lambda box: (box / "f").read_bytes()[99],
    writes=lambda box: Path({elsewhere!r}).write_text("x"),
    leaves=lambda box: Path("../fuzz-escaped").write_text("x"),
    starts=lambda box: subprocess.run(["true"]),
    starts_netconvert=lambda box: subprocess.run(["netconvert", "--version"]),
    dies=lambda box: ONCE.exists() or (ONCE.touch(), os._exit(3)),
)
for name, load in WAYS.items():
    met = lambda box, load=load: (box / "f").read_bytes() == b"[]" or load(box)
    target = Format(name, "json", "f", lambda: [b"[]"], met, programs=frozenset({{"netconvert"}}))
    given = argparse.Namespace(minutes=0.2, cases=20, seed=1, keep=Path({elsewhere!r}).parent)
    print(name, fuzz.fuzz(target, given).failed > 0)
"""


@pytest.fixture(scope="module")
def fuzzing():
    sys.path.insert(0, str(ROOT / "benchmarks"))
    yield importlib.import_module("fuzzing.formats"), importlib.import_module("fuzzing.mutations")
    sys.path.remove(str(ROOT / "benchmarks"))


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
@pytest.mark.parametrize("name", QUICK)
def test_mutated_file_is_used_or_refused_with_one_line(tmp_path: Path, fuzzing, name: str) -> None:
    formats, mutations = fuzzing
    target, chance = formats.FORMATS[name], random.Random(5)
    seeds = target.seeds()
    file = tmp_path / target.file
    file.parent.mkdir(parents=True, exist_ok=True)
    target.prepare(tmp_path)
    file.write_bytes(seeds[0])
    target.load(tmp_path)  # a whole file loads

    refusals = []
    for _ in range(CASES[name]):
        file.write_bytes(mutations.mutated(chance, seeds, target.kind))
        try:
            target.load(tmp_path)
        except PlantBenchError as error:
            refusals.append(str(error))

    assert len(refusals) > CASES[name] // 5 or name == "timing"  # a broken timing is left out
    assert not any("\n" in text for text in refusals)


def test_fuzzer_detects_each_kind_of_failure(tmp_path: Path) -> None:
    script = FUZZ.format(folder=str(ROOT / "benchmarks"), elsewhere=str(tmp_path / "x" / "written"))
    (tmp_path / "x").mkdir()

    done = subprocess.run(
        [sys.executable, "-c", script], cwd=tmp_path, capture_output=True, text=True, check=True
    )

    seen = dict(line.split() for line in done.stdout.splitlines())
    bad = {"raises", "writes", "leaves", "starts", "starts_netconvert", "dies"}
    assert {name for name, failed in seen.items() if failed == "True"} == bad
    assert set(seen) == bad | {"refuses", "reads"}


class Trap:
    """A class whose unpickling has a side effect."""

    def __reduce__(self):
        return (Path.touch, (Path("sprung"),))


@pytest.mark.parametrize("what", ["weights", "checkpoint"])
def test_pickle_named_safetensors_is_refused_and_not_executed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, fuzzing, what: str
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setitem(SIZES, "mini", SIZES["mini"])  # what the format makes smaller comes back
    target = fuzzing[0].FORMATS[what]
    (tmp_path / target.file).parent.mkdir(parents=True, exist_ok=True)
    target.prepare(tmp_path)
    (tmp_path / target.file).write_bytes(pickle.dumps(Trap()))

    with pytest.raises(InputError):
        target.load(tmp_path)

    assert not (tmp_path / "sprung").exists()


def test_checkpoint_of_an_earlier_version_is_not_unpickled(tmp_path: Path) -> None:
    from plant_bench.training.checkpoint import load_checkpoint

    (tmp_path / "checkpoint.pt").write_bytes(pickle.dumps(Trap()))

    with pytest.raises(InputError, match="a pickle of an earlier version"):
        load_checkpoint(tmp_path, {})


def test_onnx_graph_with_external_data_is_refused(tmp_path: Path) -> None:
    onnx = pytest.importorskip("onnx")
    from plant_bench.agents.plant.onnx_network import GraphPredictor

    tensor = onnx.TensorProto(
        name="w", data_type=1, dims=[1], data_location=onnx.TensorProto.EXTERNAL
    )
    tensor.external_data.add(key="location", value="../../etc/passwd")
    node = onnx.helper.make_node("Constant", [], ["y"], value=tensor)
    output = onnx.helper.make_tensor_value_info("y", 1, [1])
    graph = onnx.helper.make_graph([node], "g", [], [output])
    (tmp_path / "network.onnx").write_bytes(onnx.helper.make_model(graph).SerializeToString())

    with pytest.raises(InputError, match="in another file, which is not allowed"):
        GraphPredictor(tmp_path / "network.onnx")


def test_full_disk_while_saving_weights_is_reported_as_a_disk_error(tmp_path: Path) -> None:
    import torch

    from plant_bench.model_folder import save_tensors

    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (1000, before[1]))
    try:
        with pytest.raises(OSError, match=r".") as caught:
            save_tensors({"a": torch.zeros(10_000)}, tmp_path / "weights.safetensors")
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)

    assert "\n" not in str(caught.value.strerror)
