"""Parquet footers, including those that make arrow abort the process."""

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


def test_footer_counts_equal_those_of_arrow(path):
    facts = pq.ParquetFile(path).metadata
    groups = [facts.row_group(place) for place in range(facts.num_row_groups)]

    assert value_counts(path) == [g.column(place).num_values for g in groups for place in range(3)]
    assert value_counts(path) == [4, 3, 3, 1, 1, 1]


def test_contradictory_parquet_file_is_refused_without_a_crash(path):
    content = path.read_bytes()
    assert OPTIONAL in content
    path.write_bytes(content.replace(OPTIONAL, REQUIRED))  # its sizes tell of optional ones

    with pytest.raises(InputError, match="Not a recording"):
        Recording.load(path)


def test_broken_footer_raises_value_error(path):
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
def test_file_that_is_not_parquet_raises_value_error(tmp_path, content):
    (tmp_path / "x").write_bytes(content)

    with pytest.raises(ValueError, match="footer"):
        value_counts(tmp_path / "x")


def test_deeply_nested_structs_are_refused(tmp_path):
    footer = b"\x1c" * 100_000
    (tmp_path / "x").write_bytes(footer + len(footer).to_bytes(4, "little") + b"PAR1")

    with pytest.raises(ValueError, match="footer"):
        value_counts(tmp_path / "x")
