"""Untrusted text and JSON: refused with an error that callers catch, never endless."""

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
def test_invalid_json_raises_value_error(text: str) -> None:
    with pytest.raises(ValueError, match=r"."):
        parse_json(text)


def test_surrogate_pair_in_json_is_read() -> None:
    assert parse_json(r'["\ud83d\ude00"]') == ["😀"]


def test_named_pipe_is_refused_without_waiting(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")

    with pytest.raises(ValueError, match="not a regular file"):
        read_text(tmp_path / "pipe")


def test_oversized_file_is_refused(tmp_path: Path) -> None:
    (tmp_path / "a").write_text("12345")

    with pytest.raises(ValueError, match="at most 4 bytes, got 5"):
        read_text(tmp_path / "a", largest=4)


def test_bytes_that_are_not_utf_8_raise_value_error(tmp_path: Path) -> None:
    (tmp_path / "a").write_bytes(b"\xff\xfe\x00")

    with pytest.raises(ValueError, match="utf-8"):
        read_text(tmp_path / "a")
