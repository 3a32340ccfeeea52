"""Broken files: each loader gives the object or one line, for a few hundred mutations a format."""

import importlib
import pickle
import random
import resource
import sys
from pathlib import Path

import pytest

from plant_bench.agents.plant.config import SIZES
from plant_bench.errors import InputError, PlantBenchError

ROOT = Path(__file__).parents[2]
QUICK = ("routes", "town", "record", "timing", "rfds", "carla", "recording", "collect", "visits")
CASES = 60


@pytest.fixture(scope="module")
def fuzzing():
    sys.path.insert(0, str(ROOT / "benchmarks"))
    yield importlib.import_module("fuzzing.formats"), importlib.import_module("fuzzing.mutations")
    sys.path.remove(str(ROOT / "benchmarks"))


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
@pytest.mark.parametrize("name", QUICK)
def test_a_broken_file_is_used_or_refused_in_one_line(tmp_path: Path, fuzzing, name: str) -> None:
    formats, mutations = fuzzing
    target, chance = formats.FORMATS[name], random.Random(5)
    seeds = target.seeds()
    file = tmp_path / target.file
    file.parent.mkdir(parents=True, exist_ok=True)
    target.prepare(tmp_path)
    file.write_bytes(seeds[0])
    target.load(tmp_path)  # a whole file loads

    refusals = []
    for _ in range(CASES):
        file.write_bytes(mutations.mutated(chance, seeds, target.kind))
        try:
            target.load(tmp_path)
        except PlantBenchError as error:
            refusals.append(str(error))

    assert len(refusals) > CASES // 5 or name == "timing"  # a broken timing is left out
    assert not any("\n" in text for text in refusals)


class Trap:
    """What a pickle would run."""

    def __reduce__(self):
        return (Path.touch, (Path("sprung"),))


@pytest.mark.parametrize("what", ["weights", "checkpoint"])
def test_a_pickle_named_safetensors_is_refused_and_runs_nothing(
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


def test_a_training_of_an_earlier_version_is_not_unpickled(tmp_path: Path) -> None:
    from plant_bench.training.checkpoint import load_checkpoint

    (tmp_path / "checkpoint.pt").write_bytes(pickle.dumps(Trap()))

    with pytest.raises(InputError, match="pickle, which is not read"):
        load_checkpoint(tmp_path, {})


def test_a_graph_whose_values_lie_in_another_file_is_refused(tmp_path: Path) -> None:
    onnx = pytest.importorskip("onnx")
    from plant_bench.agents.plant.graph import GraphPredictor

    tensor = onnx.TensorProto(
        name="w", data_type=1, dims=[1], data_location=onnx.TensorProto.EXTERNAL
    )
    tensor.external_data.add(key="location", value="../../etc/passwd")
    node = onnx.helper.make_node("Constant", [], ["y"], value=tensor)
    output = onnx.helper.make_tensor_value_info("y", 1, [1])
    graph = onnx.helper.make_graph([node], "g", [], [output])
    (tmp_path / "network.onnx").write_bytes(onnx.helper.make_model(graph).SerializeToString())

    with pytest.raises(InputError, match="in another file, which are not read"):
        GraphPredictor(tmp_path / "network.onnx")


def test_weights_on_a_full_disk_are_an_error_of_the_disk(tmp_path: Path) -> None:
    import torch

    from plant_bench.agents.plant.weights import save_tensors

    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (1000, before[1]))
    try:
        with pytest.raises(OSError, match=r".") as caught:
            save_tensors({"a": torch.zeros(10_000)}, tmp_path / "weights.safetensors")
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)

    assert "\n" not in str(caught.value.strerror)
