"""PlanT's ablations: the variants of the paper and those of plant-bench's extensions."""

from collections.abc import Callable, Mapping
from dataclasses import replace

from plant_bench.agents.plant.config import SizeName
from plant_bench.agents.plant.training_options import PlanTOptions
from plant_bench.learner import Choice

PAPER_FULL = "81.36 ± 6.54"  # DS of PlanT MEDIUM on 3x data (PlanT, table 2)

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


def _off_on(name: str, change: Callable[[bool], Change]) -> tuple[Choice, ...]:
    return Choice(f"no-{name}", change(False)), Choice(name, change(True))


ABLATIONS: Mapping[str, tuple[Choice, ...]] = {
    # in the paper
    "rear": (
        Choice("no-rear", _tokens(rear=False), "72.86 ± 5.56"),
        Choice("rear", _tokens(rear=True), PAPER_FULL),
    ),
    "speeds": (
        # Without the speeds, nothing that is computed from them either.
        Choice(
            "no-speeds",
            _tokens(speed=False, conflicts=False, motion=False, horizon=0.0),
            "72.34 ± 3.30",
        ),
        Choice("speeds", _tokens(speed=True), PAPER_FULL),
    ),
    "auxiliary": (
        Choice("no-auxiliary", _auxiliary(0.0)),
        Choice("auxiliary", _auxiliary(PlanTOptions.auxiliary)),
    ),
    "size": (_size("mini"), _size("small"), _size("medium", PAPER_FULL)),
    # plant-bench's extensions
    "stop-line": _off_on("stop-line", lambda on: _tokens(stop_line=on)),
    "vulnerable": _off_on("vulnerable", lambda on: _tokens(vulnerable=on)),
    "limit-input": _off_on("limit-input", lambda on: _network(limit_input=on)),
    "speed-input": _off_on("speed-input", lambda on: _network(speed_input=on)),
    "conflicts": _off_on("conflicts", lambda on: _tokens(conflicts=on)),
    "motion": _off_on("motion", lambda on: _tokens(motion=on)),
    "horizon": (
        Choice("no-horizon", _tokens(horizon=0.0)),
        Choice("horizon-5s", _tokens(horizon=5.0)),
    ),
    "reach": (Choice("reach-30", _tokens(reach=30.0)), Choice("reach-50", _tokens(reach=50.0))),
}
