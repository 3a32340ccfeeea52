"""Records written by older versions still load, with unchanged meaning."""

from pathlib import Path

import pytest

from plant_bench.scoring.infractions import InfractionKind, Status
from plant_bench.scoring.penalties import PenaltyScheme
from plant_bench.scoring.results import EpisodeResult

RECORDS = Path(__file__).parent / "records"


@pytest.mark.parametrize("path", sorted(RECORDS.glob("*.json")), ids=lambda path: path.stem)
def test_old_records_load_and_are_written_unchanged(path):
    assert EpisodeResult.load(path).to_json() == path.read_text(encoding="utf-8")


def test_format_1_record_has_the_expected_fields():
    result = EpisodeResult.load(RECORDS / "format_1.json")
    assert result.status is Status.BLOCKED
    assert result.route_completion == pytest.approx(62.5)
    assert [item.kind for item in result.infractions] == [
        InfractionKind.COLLISION_VEHICLE,
        InfractionKind.RED_LIGHT,
        InfractionKind.BLOCKED,
        InfractionKind.OUTSIDE_LANES,
    ]
    assert result.infraction_score == pytest.approx(0.6 * 0.7 * 0.95)
    assert result.driving_score == pytest.approx(62.5 * 0.6 * 0.7 * 0.95)
    assert result.infraction_score_by(PenaltyScheme.LB2_1) == pytest.approx(
        0.95 / (1.0 + 0.7 + 0.4)
    )
    assert result.measures is None


def test_format_2_record_has_the_expected_fields():
    result = EpisodeResult.load(RECORDS / "format_2.json")
    assert result.measures is not None
    assert (result.measures["ttc_vehicle"], result.measures["ttc_vulnerable"]) == (1.7, None)
    assert result.measures["hard_brakes"] == 4
