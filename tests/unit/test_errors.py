"""What errors of others become in a message."""

import pytest

from plant_bench.errors import InputError
from plant_bench.runner.provenance import Provenance
from plant_bench.scoring.results import EpisodeResult


@pytest.mark.parametrize("kind", [EpisodeResult, Provenance])
@pytest.mark.parametrize("text", ["{", "{}", '{"route": 3}'])
def test_a_broken_file_is_told_in_one_line(tmp_path, kind, text):
    path = tmp_path / "file.json"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(InputError) as caught:
        kind.load(path)
    assert "\n" not in str(caught.value)
    assert "http" not in str(caught.value)
