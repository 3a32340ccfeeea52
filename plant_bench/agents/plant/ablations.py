"""What is changed of PlanT, one thing at a time, to see what it is good for: the paper's, ours."""

from collections.abc import Callable, Mapping
from dataclasses import replace

from plant_bench.agents.plant.config import SizeName
from plant_bench.agents.plant.training_options import PlanTOptions
from plant_bench.learner import Choice

PAPER_WHOLE = "81.36 ± 6.54"  # DS of PlanT MEDIUM on 3x data (PlanT, table 2)

Change = Callable[[PlanTOptions], PlanTOptions]


def _network(**changes: object) -> Change:
    return lambda base: replace(base, network=replace(base.network, **changes))


def _tokens(**changes: object) -> Change:
    def change(base: PlanTOptions) -> PlanTOptions:
        tokens = replace(base.network.tokens, **changes)
        return replace(base, network=replace(base.network, tokens=tokens))

    return change


def _auxiliary(weight: float) -> Change:
    return lambda base: replace(base, auxiliary=weight)


def _size(name: SizeName, paper: str = "-") -> Choice:
    return Choice(name, _network(size=name), paper)


def _told(name: str, change: Callable[[bool], Change]) -> tuple[Choice, ...]:
    return Choice(f"no-{name}", change(False)), Choice(name, change(True))


ABLATIONS: Mapping[str, tuple[Choice, ...]] = {
    # the paper's
    "rear": (
        Choice("no-rear", _tokens(rear=False), "72.86 ± 5.56"),
        Choice("rear", _tokens(rear=True), PAPER_WHOLE),
    ),
    "speeds": (
        # Nor anything that follows from the speeds of others.
        Choice(
            "no-speeds",
            _tokens(speed=False, conflicts=False, motion=False, horizon=0.0),
            "72.34 ± 3.30",
        ),
        Choice("speeds", _tokens(speed=True), PAPER_WHOLE),
    ),
    "auxiliary": (
        Choice("no-auxiliary", _auxiliary(0.0)),
        Choice("auxiliary", _auxiliary(PlanTOptions.auxiliary)),
    ),
    "size": (_size("mini"), _size("small"), _size("medium", PAPER_WHOLE)),
    # ours
    "stop-line": _told("stop-line", lambda told: _tokens(stop_line=told)),
    "vulnerable": _told("vulnerable", lambda told: _tokens(vulnerable=told)),
    "limit-input": _told("limit-input", lambda told: _network(limit_input=told)),
    "speed-input": _told("speed-input", lambda told: _network(speed_input=told)),
    "conflicts": _told("conflicts", lambda told: _tokens(conflicts=told)),
    "motion": _told("motion", lambda told: _tokens(motion=told)),
    "horizon": (
        Choice("no-horizon", _tokens(horizon=0.0)),
        Choice("horizon-5s", _tokens(horizon=5.0)),
    ),
    "reach": (Choice("reach-30", _tokens(reach=30.0)), Choice("reach-50", _tokens(reach=50.0))),
}
