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
def test_columns_come_back_whatever_the_order_of_differences(one, other, first, second):
    columns = {"one": (np.array(one, int), first), "other": (np.array(other, int), second)}
    packed = pack(columns)
    assert {width for *_, width in packed.columns} <= {1, 2, 3, 4}, "the page reads 32 bits"
    found = unpack(packed.columns, packed.data)
    assert found["one"].tolist() == one
    assert found["other"].tolist() == other


def test_steady_motion_takes_next_to_nothing():
    steady = quantised(np.linspace(0.0, 3000.0, 10_000), 100.0)
    assert len(pack({"x": (steady, 2)}).data) < 3_000


def test_values_too_large_for_the_page_are_refused():
    with pytest.raises(ValueError, match="Column x"):
        pack({"x": (np.array([2**28]), 1)})


def test_quantising_keeps_half_a_step_and_drops_what_is_not_finite():
    values = np.array([1.234, -5.678, np.nan, np.inf])
    np.testing.assert_array_equal(quantised(values, 100.0), [123, -568, 0, 0])


@pytest.mark.parametrize(
    "text",
    ["</script><script>alert(1)</script>", "a\u2028b\u2029c", "<!--", "🚗 & Müller", "\ud800"],
)
def test_hostile_texts_cannot_leave_the_script_and_come_back_equal(text):
    script = script_json({"title": text})
    assert not set("<>&\u2028\u2029") & set(script)
    assert script.isascii()
    assert json.loads(script) == {"title": text}


def test_numbers_that_json_does_not_know_are_refused():
    with pytest.raises(ValueError, match="JSON"):
        script_json(float("nan"))
