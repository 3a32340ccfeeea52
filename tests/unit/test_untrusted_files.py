"""Text and JSON of strangers: refused in a way that callers catch, never endless."""

import os
from pathlib import Path

import pytest

from plant_bench.untrusted_files import parse_json, read_text


@pytest.mark.parametrize(
    "text",
    [
        "NaN",
        "[Infinity]",
        "[" * 100_000,
        '{"a": ' + "9" * 5000 + "}",
        "",
        "{'a': 1}",
        r'["\ud800"]',
    ],
)
def test_what_is_no_json_is_a_value_error(text: str) -> None:
    with pytest.raises(ValueError, match=r"."):
        parse_json(text)


def test_a_letter_of_two_halves_is_read() -> None:
    assert parse_json(r'["\ud83d\ude00"]') == ["😀"]


def test_a_pipe_is_not_waited_for(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")

    with pytest.raises(ValueError, match="no ordinary file"):
        read_text(tmp_path / "pipe")


def test_a_file_that_is_too_large_is_not_read(tmp_path: Path) -> None:
    (tmp_path / "a").write_text("12345")

    with pytest.raises(ValueError, match="at most 4 are read"):
        read_text(tmp_path / "a", largest=4)


def test_bytes_that_are_no_text_are_a_value_error(tmp_path: Path) -> None:
    (tmp_path / "a").write_bytes(b"\xff\xfe\x00")

    with pytest.raises(ValueError, match="utf-8"):
        read_text(tmp_path / "a")
