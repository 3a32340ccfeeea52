"""Every numeric option of every command refuses what is no finite number in its range."""

import typing
from collections.abc import Iterator

import pytest
import typer

from plant_bench.cli import app
from plant_bench.cli.commands.ablate import AblateCommand
from plant_bench.training.learners import known_learners

NO_NUMBERS = ("nan", "inf", "-1e30", "1e30", f"1{30 * '0'}")
# Arguments with which a command would start its work:
ARGUMENTS = {
    "compare": ["a", "b"], "data": ["a"], "export": ["run", "--out", "file"],
    "import": ["map.osm", "--name", "x"],
    "import-routes": ["routes.xml", "--town-map", "Town01=x", "--out", "x"],
    "replay": ["run", "0", "--png", "a.png"], "rescore": ["run"], "report": ["run"],
    "score": ["--agent", "cruise"], "rfds": ["--agent", "plant"], "collect": ["--out", "x"],
    "serve": ["x"], "train": ["--data", "x", "--out", "y"], "ablate": ["--data", "x"],
    "verify": ["run"], "why": ["run", "0"], "towns": ["--check"], "routes": ["--check"],
}  # fmt: skip


def commands(command: typing.Any, path: tuple[str, ...] = ()) -> Iterator[tuple[tuple, typing.Any]]:
    names = command.list_commands(None) if hasattr(command, "list_commands") else []
    for name in names:
        yield from commands(command.get_command(None, name), (*path, name))
    if not names:
        yield path, command


def numeric_options() -> Iterator[tuple[str, ...]]:
    """The command line up to the option's value, for every numeric option."""
    for path, command in commands(typer.main.get_command(app)):
        if isinstance(command, AblateCommand):
            command = command.make_context("ablate", ["--data", "x"]).command
        for parameter in command.params:
            kind = parameter.type_descriptor.annotation
            parts = typing.get_args(kind) or (kind,)
            if int in parts or float in parts:
                yield (*path, parameter.opts[0], str(len(parts)))


OPTIONS = list(numeric_options())


def test_numeric_options_are_found() -> None:
    found = {(*path, option) for *path, option, _ in OPTIONS}

    assert found >= {
        ("train", "plant", "--rate"), ("train", "plant", "--reach"), ("ablate", "--betas"),
        ("train", "plant", "--overshoot-weight"), ("score", "--repetitions"),
        ("import-routes", "--limit-distance"), ("replay", "--from"), ("collect", "--units"),
    }  # fmt: skip
    assert {path[1] for path in found if path[0] == "train"} == set(known_learners())


@pytest.mark.parametrize("option", OPTIONS, ids=" ".join)
def test_numeric_option_refuses_no_numbers_before_any_work(
    option, tmp_path, monkeypatch, capsys
) -> None:
    *path, name, parts = option
    monkeypatch.chdir(tmp_path)
    for value in NO_NUMBERS:
        line = [*path, *ARGUMENTS.get(path[0], []), name, *[value] * int(parts)]
        with pytest.raises(SystemExit) as ended:
            app(line, prog_name="plant-bench")

        said = capsys.readouterr().err
        assert (ended.value.code, name in said) == (2, True), (value, said)
        assert "Traceback" not in said
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    "line",
    [
        ["score", "--agent", "cruise", "--repetitions", "10001"],
        ["score", "--agent", "cruise", "--seed", "-1"],
        ["train", "plant", "--data", "x", "--out", "y", "--rate", "1e30"],
        ["train", "plant", "--data", "x", "--out", "y", "--rate", "-1"],
        ["train", "plant", "--data", "x", "--out", "y", "--reach", "0"],
        ["train", "plant", "--data", "x", "--out", "y", "--betas", "0.9", "1.5"],
        ["import-routes", "a.xml", "--town-map", "A=b", "--out", "x", "--limit-distance", "1e9"],
    ],
    ids=" ".join,
)
def test_numbers_out_of_range_are_refused(line, tmp_path, monkeypatch, capsys) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SystemExit) as ended:
        app(line, prog_name="plant-bench")

    assert ended.value.code == 2
    assert "Traceback" not in capsys.readouterr().err
    assert not list(tmp_path.iterdir())
