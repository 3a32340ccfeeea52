import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from plant_bench.reports.replay.column_compression import pack, quantised
from plant_bench.text_escaping import script_json
from tests.unit.reports.replay.unpacking import unpack

WHOLE = st.lists(st.integers(-(2**28) + 1, 2**28 - 1), max_size=30)


@given(WHOLE, WHOLE, st.integers(0, 2), st.integers(0, 2))
def test_packed_columns_round_trip_for_every_difference_order(one, other, first, second):
    columns = {"one": (np.array(one, int), first), "other": (np.array(other, int), second)}
    packed = pack(columns)
    assert {width for *_, width in packed.columns} <= {1, 2, 3, 4}, "the page reads 32 bits"
    found = unpack(packed.columns, packed.data)
    assert found["one"].tolist() == one
    assert found["other"].tolist() == other


def test_steady_motion_packs_into_a_few_bytes():
    steady = quantised(np.linspace(0.0, 3000.0, 10_000), 100.0)
    assert len(pack({"x": (steady, 2)}).data) < 3_000


def test_values_too_large_for_the_page_are_refused():
    with pytest.raises(ValueError, match="Column x"):
        pack({"x": (np.array([2**28]), 1)})


def test_quantising_rounds_and_replaces_non_finite_values():
    values = np.array([1.234, -5.678, np.nan, np.inf])
    np.testing.assert_array_equal(quantised(values, 100.0), [123, -568, 0, 0])


@pytest.mark.parametrize(
    "text",
    ["</script><script>alert(1)</script>", "a\u2028b\u2029c", "<!--", "🚗 & Müller", "\ud800"],
)
def test_untrusted_text_in_scripts_is_escaped_and_round_trips(text):
    script = script_json({"title": text})
    assert not set("<>&\u2028\u2029") & set(script)
    assert script.isascii()
    assert json.loads(script) == {"title": text}


def test_non_finite_numbers_are_refused():
    with pytest.raises(ValueError, match="JSON"):
        script_json(float("nan"))
