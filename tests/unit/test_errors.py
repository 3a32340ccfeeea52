"""Errors of other libraries in messages."""

import pytest

from plant_bench.errors import InputError
from plant_bench.runner.run.provenance import Provenance
from plant_bench.scoring.results import EpisodeResult


@pytest.mark.parametrize("kind", [EpisodeResult, Provenance])
@pytest.mark.parametrize("text", ["{", "{}", '{"route": 3}'])
def test_broken_file_gives_a_one_line_message(tmp_path, kind, text):
    path = tmp_path / "file.json"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(InputError) as caught:
        kind.load(path)
    assert "\n" not in str(caught.value)
    assert "http" not in str(caught.value)


def test_control_characters_in_messages_are_escaped():
    text = str(InputError("There is no town 'a\r\nb\x1b[2J\ud800' in Zürich."))

    assert text == r"There is no town 'a b\x1b[2J\ud800' in Zürich."


def test_long_quotes_in_messages_are_truncated():
    assert len(str(InputError("x" * 100_000))) < 2100
