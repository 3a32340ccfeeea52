"""What a Parquet file says of itself, also where arrow would end the process over it."""

import random

import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from plant_bench.data.parquet_footer import value_counts
from plant_bench.data.recording import Recording
from plant_bench.errors import InputError

TABLE = pa.table(
    {"a": [[1.0, 2.0], [], None, [3.0]], "b": [1, 2, None, 4], "c": ["x", "y", "z", ""]}
)
OPTIONAL = b"\x15\x0a\x25\x02\x18\x07element"  # a column of float64, in the footer's schema
REQUIRED = b"\x15\x0a\x25\x00\x18\x07element"


@pytest.fixture
def path(tmp_path):
    pq.write_table(TABLE, tmp_path / "t.parquet", row_group_size=3)
    return tmp_path / "t.parquet"


def test_counts_are_those_that_arrow_tells(path):
    facts = pq.ParquetFile(path).metadata
    groups = [facts.row_group(place) for place in range(facts.num_row_groups)]

    assert value_counts(path) == [g.column(place).num_values for g in groups for place in range(3)]
    assert value_counts(path) == [4, 3, 3, 1, 1, 1]


def test_a_file_that_contradicts_itself_is_refused_and_ends_nothing(path):
    content = path.read_bytes()
    assert OPTIONAL in content
    path.write_bytes(content.replace(OPTIONAL, REQUIRED))  # its sizes tell of optional ones

    with pytest.raises(InputError, match="Not a recording"):
        Recording.load(path)


def test_a_broken_footer_is_a_value_error(path):
    content, chance = path.read_bytes(), random.Random(1)
    (length,) = (int.from_bytes(content[-8:-4], "little"),)
    refused = 0
    for _ in range(300):
        broken = bytearray(content)
        broken[len(content) - 8 - chance.randrange(length)] = chance.randrange(256)
        path.write_bytes(broken)
        try:
            counts = value_counts(path)
            assert all(isinstance(count, int) for count in counts)
        except ValueError:
            refused += 1
    assert refused > 50


@pytest.mark.parametrize("content", [b"", b"PAR1", b"\xff" * 12, b"\x7f\0\0\0PAR1", b"a" * 99])
def test_what_is_no_parquet_file_is_a_value_error(tmp_path, content):
    (tmp_path / "x").write_bytes(content)

    with pytest.raises(ValueError, match="footer"):
        value_counts(tmp_path / "x")


def test_structs_inside_structs_without_end_are_refused(tmp_path):
    footer = b"\x1c" * 100_000
    (tmp_path / "x").write_bytes(footer + len(footer).to_bytes(4, "little") + b"PAR1")

    with pytest.raises(ValueError, match="footer"):
        value_counts(tmp_path / "x")
