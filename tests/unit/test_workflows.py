"""What GitHub runs and shows: workflows, issue forms, and the check of a release's tag.

`.ci/check_schemas` holds the same files against GitHub's schemas; here is what no schema knows.
"""

import re
import shlex
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import yaml
from typer.testing import CliRunner

from plant_bench import __version__
from plant_bench.cli import app

ROOT = Path(__file__).parents[2]
WORKFLOWS = sorted((ROOT / ".github" / "workflows").glob("*.yml"))
FORMS = [ROOT / ".github" / "ISSUE_TEMPLATE" / f"{name}.yml" for name in ("bug", "result")]
STATED = ("plant_bench/__init__.py", "CITATION.cff", "CHANGELOG.md")

every_workflow = pytest.mark.parametrize("workflow", WORKFLOWS, ids=lambda path: path.stem)
every_form = pytest.mark.parametrize("form", FORMS, ids=lambda path: path.stem)


def parsed(file: Path) -> dict[Any, Any]:
    return yaml.safe_load(file.read_text(encoding="utf-8"))


def steps_of(workflow: Path) -> Iterator[dict[str, Any]]:
    for job in parsed(workflow)["jobs"].values():
        yield from job.get("steps", ())


def commands_of(workflow: Path) -> list[str]:
    scripts = [step["run"] for step in steps_of(workflow) if "run" in step]
    return [line for script in scripts for line in script.replace("\\\n", " ").splitlines()]


def test_ci_documentation_release_and_slow_tests_have_a_workflow():
    assert [path.stem for path in WORKFLOWS] == ["ci", "docs", "release", "slow"]


def test_ci_calls_the_script_that_contributors_run():
    assert ".ci/run" in commands_of(ROOT / ".github" / "workflows" / "ci.yml")


@every_workflow
def test_files_that_commands_name_exist(workflow):
    text = "\n".join(commands_of(workflow))
    named = set(re.findall(r"(?<![\w/$}])(?:\.ci/\w+(?:\.\w+)?|[\w/]+\.(?:py|sh|toml|txt))", text))

    assert named
    assert [name for name in named if not (ROOT / name).is_file()] == []


@every_workflow
def test_called_workflows_exist(workflow):
    called = [job["uses"] for job in parsed(workflow)["jobs"].values() if "uses" in job]

    assert [path for path in called if not (ROOT / path).is_file()] == []


@every_workflow
def test_actions_are_pinned_by_commit_hash_with_their_version(workflow):
    lines = workflow.read_text(encoding="utf-8").splitlines()
    used = [line.split("uses:")[1].strip() for line in lines if "uses:" in line]
    actions = [action for action in used if not action.startswith("./")]

    assert actions
    pinned = re.compile(r"[\w-]+/[\w-]+@[0-9a-f]{40} # v\d+\.\d+\.\d+")
    assert [action for action in actions if not pinned.fullmatch(action)] == []


@every_workflow
def test_jobs_may_only_read_unless_they_publish(workflow):
    facts = parsed(workflow)
    writing = {
        name: [scope for scope, access in job["permissions"].items() if access == "write"]
        for name, job in facts["jobs"].items()
        if "permissions" in job
    }
    allowed = {
        "ci": {},
        "docs": {"deploy": ["pages", "id-token"]},
        "release": {"publish": ["id-token"], "github-release": ["contents"]},
        "slow": {},
    }

    assert facts["permissions"] == {"contents": "read"}
    assert writing == allowed[workflow.stem]


def test_options_of_plant_bench_in_the_release_exist():
    lines = [
        line.split('bin/plant-bench" ')[1]
        for line in commands_of(ROOT / ".github" / "workflows" / "release.yml")
        if 'bin/plant-bench" score' in line
    ]

    assert lines
    for line in lines:
        done = CliRunner().invoke(app, [*shlex.split(line), "--help"])
        assert done.exit_code == 0, done.output


@every_form
def test_fields_of_a_form_have_unique_ids_and_labels(form):
    fields = [item for item in parsed(form)["body"] if item["type"] != "markdown"]
    ids = [field["id"] for field in fields]
    labels = [field["attributes"]["label"] for field in fields]

    assert len(set(ids)) == len(ids)
    assert len(set(labels)) == len(labels)


def test_a_result_is_submitted_with_what_verify_needs():
    fields = {item.get("id"): item for item in parsed(FORMS[1])["body"]}
    required = {
        name for name, item in fields.items() if item.get("validations", {}).get("required")
    }

    assert required >= {"planner", "run", "protocol", "inputs", "verification"}


@pytest.fixture
def checkout(tmp_path: Path) -> Path:
    """The files of a release of version 1.2.3."""
    (tmp_path / ".ci").mkdir()
    (tmp_path / "plant_bench").mkdir()
    shutil.copy(ROOT / ".ci" / "release_notes.py", tmp_path / ".ci")
    for name in STATED:
        shutil.copy(ROOT / name, tmp_path / name)
    for name in STATED[:2]:
        text = (tmp_path / name).read_text(encoding="utf-8")
        assert __version__ in text
        (tmp_path / name).write_text(text.replace(__version__, "1.2.3"), encoding="utf-8")
    changelog = (
        "# Changelog\n\n## [Unreleased]\n\n## [1.2.3] - 2026-12-01\n\n### Added\n\n- A thing.\n\n"
        "## [1.2.2] - 2026-11-01\n\n- Another.\n\n[1.2.2]: https://example.org\n"
    )
    (tmp_path / "CHANGELOG.md").write_text(changelog, encoding="utf-8")
    return tmp_path


def notes(checkout: Path, tag: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, checkout / ".ci" / "release_notes.py", tag]
    return subprocess.run(command, capture_output=True, text=True, check=False)


def test_release_notes_are_the_section_of_the_version(checkout):
    done = notes(checkout, "v1.2.3")

    assert (done.returncode, done.stdout) == (0, "### Added\n\n- A thing.\n")


def test_release_notes_of_the_last_section_stop_before_the_links(checkout):
    for name in STATED[:2]:
        text = (checkout / name).read_text(encoding="utf-8")
        (checkout / name).write_text(text.replace("1.2.3", "1.2.2"), encoding="utf-8")

    assert notes(checkout, "v1.2.2").stdout == "- Another.\n"


@pytest.mark.parametrize(
    ("tag", "message"),
    [
        ("1.2.3", "expected a tag such as v1.2.3, got '1.2.3'"),
        (
            "v1.2.4",
            "plant_bench/__init__.py: expected version 1.2.4 as in the tag v1.2.4, got 1.2.3",
        ),
    ],
)
def test_a_tag_that_does_not_match_the_version_is_refused(checkout, tag, message):
    done = notes(checkout, tag)

    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == f"Error: {message}\n"


def test_a_release_with_another_version_in_the_citation_is_refused(checkout):
    shutil.copy(ROOT / "CITATION.cff", checkout)
    done = notes(checkout, "v1.2.3")

    assert done.returncode == 2
    assert done.stderr.startswith("Error: CITATION.cff: expected version 1.2.3")


@pytest.mark.parametrize("text", ["## [Unreleased]\n\n- A thing.\n", "## [1.2.3]\n\n## [1.2.2]\n"])
def test_a_release_without_a_section_in_the_changelog_is_refused(checkout, text):
    (checkout / "CHANGELOG.md").write_text(text, encoding="utf-8")
    done = notes(checkout, "v1.2.3")

    assert done.returncode == 2
    assert done.stderr == (
        "Error: CHANGELOG.md: expected a section '## [1.2.3]' with text, found none\n"
    )
