import pytest

from tests.unit.reports.replay.drives import drive


@pytest.fixture
def source(tmp_path):
    return drive(tmp_path)
