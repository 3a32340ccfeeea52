from pathlib import Path

import pytest

from plant_bench.reports.replay.replay_source import ReplaySource
from tests.unit.reports.replay.drives import drive


@pytest.fixture
def source(tmp_path: Path) -> ReplaySource:
    return drive(tmp_path)
