"""An episode's key covers everything that can change the episode, and nothing else."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from plant_bench import source_code
from plant_bench.agents.loading import checksum
from plant_bench.agents.loading.checksum import agent_checksum, agent_files
from plant_bench.agents.loading.planner_spec import AGENTS
from plant_bench.runner.episode import keys
from plant_bench.source_code import is_part, module_file, module_name

ADDED = b"\n_ADDED = 1\n"


@pytest.fixture
def edited(monkeypatch):
    """Return a function that makes one module's file appear edited."""

    def edit(module, change):
        real, path = source_code.source_of, module_file(module)
        other = source_code.source_in(change(path.read_bytes()))
        monkeypatch.setattr(
            source_code, "source_of", lambda file: other if file == path else real(file)
        )

    return edit


def rules():
    return keys.rules_checksum.__wrapped__()


@pytest.mark.parametrize("module", sorted(keys.rules_modules()))
def test_change_in_any_rules_module_changes_the_rules_key(module, edited):
    before = rules()

    edited(module, lambda content: content + ADDED)

    assert rules() != before


@pytest.mark.parametrize(
    "module",
    [
        "plant_bench.scoring.metrics",
        "plant_bench.scoring.comparison",
        "plant_bench.reports.tables",
        "plant_bench.runner.run.summary_files",
        "plant_bench.agents.cruise",
        "plant_bench.agents.loading.planner_spec",
        "plant_bench.training.trainer",
    ],
)
def test_rules_key_excludes_statistics_reports_and_planners(module, edited):
    before = rules()

    edited(module, lambda content: content + ADDED)

    assert rules() == before


def test_hash_ignores_comments_docstrings_and_line_breaks():
    plain = b"def half(x):\n    return x / 2\n"
    wordy = (
        b'"""Words."""\n\n\ndef half(x):  # halves\n    """Return half."""\n'
        b"    return (\n        x / 2\n    )\n"
    )

    assert source_code.source_in(plain).hash == source_code.source_in(wordy).hash
    assert (
        source_code.source_in(plain.replace(b"2", b"3")).hash != source_code.source_in(plain).hash
    )


@pytest.mark.parametrize("package", ["libsumo", "numpy", "shapely"])
def test_rules_key_depends_on_versions_of_numeric_libraries(package, monkeypatch):
    before = rules()
    real = source_code.version

    monkeypatch.setattr(
        source_code, "version", lambda name: "0.0" if name == package else real(name)
    )

    assert rules() != before


@pytest.mark.parametrize("name", ["cruise", "plant", "expert-filtered@distance"])
def test_adding_a_planner_changes_no_planner_checksum(name, edited):
    before = agent_checksum(name)

    edited("plant_bench.agents.loading.planner_spec", lambda content: content + ADDED)

    assert agent_checksum(name) == before


@pytest.mark.parametrize(
    ("name", "module", "changes"),
    [
        ("cruise", "plant_bench.agents.cruise", True),
        ("cruise", "plant_bench.agents.rule_based", False),
        ("cruise", "plant_bench.features.tokens", False),
        ("rule-based", "plant_bench.agents.careful.driver", True),
        ("rule-based", "plant_bench.agents.plant.agent", False),
        ("plant", "plant_bench.features.tokens", True),
        ("plant", "plant_bench.agents.guarded", True),
        ("plant", "plant_bench.agents.cruise", False),
        ("plant-unguarded", "plant_bench.agents.guarded", False),
        ("expert-filtered@attention:plant", "plant_bench.agents.plant.agent", True),
        ("expert-filtered@distance", "plant_bench.agents.plant.agent", False),
    ],
)
def test_planner_checksum_covers_only_its_imports(name, module, changes, edited):
    before = agent_checksum(name)

    edited(module, lambda content: content + ADDED)

    assert (agent_checksum(name) != before) is changes


def test_onnx_planner_checksum_depends_on_onnxruntime_not_torch(monkeypatch):
    before = agent_checksum("plant")
    real = source_code.version

    def other(package):
        return lambda name: "0.0" if name == package else real(name)

    monkeypatch.setattr(source_code, "version", other("torch"))
    assert agent_checksum("plant") == before
    monkeypatch.setattr(source_code, "version", other("onnxruntime"))
    assert agent_checksum("plant") != before


def test_planner_file_checksum_covers_imported_plant_bench_modules(tmp_path, edited):
    (tmp_path / "mine.py").write_text(
        "from plant_bench.agents.cruise import Cruise\nclass Mine(Cruise):\n    pass\n"
    )
    spec = f"{tmp_path / 'mine.py'}:Mine"
    before = agent_checksum(spec)

    edited("plant_bench.agents.cruise", lambda content: content + ADDED)

    assert agent_checksum(spec) != before


@pytest.mark.parametrize("table", [keys.HARMLESS, checksum.HARMLESS])
def test_every_unkeyed_module_exists_and_has_a_reason(table):
    for module, reason in table.items():
        assert module_file(module).is_file()
        assert len(reason.split()) >= 3


@pytest.mark.sumo
def test_every_module_an_episode_loads_is_keyed_or_listed(tmp_path):
    code = (
        "import json, sys\n"
        "from plant_bench.runner.episode.loop import run_episode\n"
        "from plant_bench.runner.episode.jobs import make_jobs\n"
        "from plant_bench.world.route import load_suite\n"
        "route = min(load_suite('longest6'), key=lambda route: route.length)\n"
        "jobs = make_jobs('rule-based', '', [route], repetitions=1, seed=0, density='empty')\n"
        "run_episode(jobs[0])\n"
        "print(json.dumps([n for n in sys.modules if n.startswith('plant_bench.')]))\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, cwd=tmp_path, check=True
    )
    loaded = set(json.loads(done.stdout.splitlines()[-1]))
    keyed = keys.rules_modules() | {module_name(path) for path in agent_files("rule-based")}

    assert "plant_bench.sim.simulation" in loaded
    assert [
        name
        for name in sorted(loaded - keyed)
        if not is_part(name, keys.HARMLESS) and not is_part(name, checksum.HARMLESS)
    ] == []


def test_files_of_built_in_planners_include_their_module():
    for name, target in AGENTS.items():
        if name != "expert-filtered":
            assert module_file(target.partition(":")[0]) in agent_files(name)


def test_cached_file_hash_is_not_used_after_a_change(tmp_path):
    path = tmp_path / "mine.py"
    path.write_text("x = 1\n")
    first = source_code.file_hash(path)
    path.write_text("x = 2\n")

    assert source_code.file_hash(path) != first
    assert source_code.file_hash(Path(path)) == source_code.file_hash(path)
