from plant_bench.scoring.hazard_outcomes import hazard_counts
from plant_bench.world.hazard import HazardKind

HIT = {"kind": "collision_vehicle", "x": 0.0, "y": 0.0}


def hazard(phase, at=100.0, time=20.0, kind="cut_in"):
    return {"kind": kind, "at": at, "phase": phase, "time": time}


def counts(episode, hazards, *hits):
    infractions = [{**HIT, "time": time, "progress": progress} for time, progress in hits]
    return hazard_counts([episode(hazards=hazards, infractions=infractions)])


def test_hazards_count_as_met_if_committed_or_done(episode):
    found = counts(episode, [hazard(phase) for phase in ("done", "committed", "void", "dormant")])
    cut_ins = found[HazardKind.CUT_IN]
    assert (cut_ins.placed, cut_ins.met, cut_ins.survived, cut_ins.void) == (4, 2, 2, 1)


def test_collision_near_a_hazard_counts_as_not_survived(episode):
    assert counts(episode, [hazard("done")], (21.0, 110.0))[HazardKind.CUT_IN].survived == 0


def test_collision_before_a_hazard_or_elsewhere_counts_as_survived(episode):
    found = counts(episode, [hazard("done")], (19.0, 95.0), (40.0, 140.0))
    assert found[HazardKind.CUT_IN].survived == 1


def test_kinds_of_hazard_are_counted_separately(episode):
    found = counts(episode, [hazard("done"), hazard("done", at=400.0, kind="crossing")])
    assert {kind: count.met for kind, count in found.items()} == {
        HazardKind.CROSSING: 1,
        HazardKind.CUT_IN: 1,
    }
