"""What is changed, one thing at a time, to see what it is good for: the paper's ablations, ours."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from plant_bench.agents.plant.config import PlanTConfig, SizeName
from plant_bench.errors import InputError, did_you_mean
from plant_bench.training.settings import TrainingSettings

BASE = "base"
PAPER_WHOLE = "81.36 ± 6.54"  # DS of PlanT MEDIUM on 3x data (PlanT, table 2)


@dataclass(frozen=True)
class Recipe:
    """What decides a trained network, apart from the data.

    Attributes:
        config: Of the network.
        settings: How to train.
        share: Of the episodes that are learnt from, see `load_shards`.
    """

    config: PlanTConfig
    settings: TrainingSettings
    share: float = 1.0


Change = Callable[[Recipe], Recipe]


@dataclass(frozen=True)
class Choice:
    """One of the things that an ablation compares.

    Attributes:
        name: Of the choice.
        change: Makes it from the base.
        paper: DS in the paper.
    """

    name: str
    change: Change
    paper: str = "-"


@dataclass(frozen=True)
class Variant:
    """A choice, made from a base.

    Attributes:
        ablation: To which it belongs.
        name: Of the choice.
        training: Names the training; choices that are the base share its.
        recipe: What is trained.
        paper: DS in the paper.
    """

    ablation: str
    name: str
    training: str
    recipe: Recipe
    paper: str


def variants_of(names: Sequence[str], base: Recipe) -> list[Variant]:
    """Return the base, and all choices of the named ablations; of all of them without a name.

    Args:
        names: Of ablations, or of single choices.
        base: What is changed.

    Raises:
        InputError: There is no such ablation.
    """
    alone = {choice.name for choices in ABLATIONS.values() for choice in choices}
    for name in names:
        if name not in ABLATIONS and name not in alone:
            hint = did_you_mean(name, [*ABLATIONS, *alone])
            message = f"There is no ablation '{name}': {', '.join(ABLATIONS)} are known.{hint}"
            raise InputError(message)
    found = [Variant(BASE, BASE, BASE, base, "-")]
    wanted = set(names or ABLATIONS)
    for name, choices in ABLATIONS.items():
        for choice in choices:
            if wanted.isdisjoint((name, choice.name)):
                continue
            recipe = choice.change(base)
            training = BASE if recipe == base else choice.name
            found.append(Variant(name, choice.name, training, recipe, choice.paper))
    return found


def trainings_of(variants: Sequence[Variant]) -> dict[str, Recipe]:
    """Return each training that the variants need, once."""
    return {variant.training: variant.recipe for variant in variants}


def _network(**changes: object) -> Change:
    return lambda base: replace(base, config=replace(base.config, **changes))


def _tokens(**changes: object) -> Change:
    def change(base: Recipe) -> Recipe:
        tokens = replace(base.config.tokens, **changes)
        return replace(base, config=replace(base.config, tokens=tokens))

    return change


def _auxiliary(weight: float) -> Change:
    return lambda base: replace(base, settings=replace(base.settings, auxiliary=weight))


def _data(thirds: int) -> Change:
    return lambda base: replace(base, share=base.share * (thirds / 3))


def _size(name: SizeName, paper: str = "-") -> Choice:
    return Choice(name, _network(size=name), paper)


def _told(name: str, change: Callable[[bool], Change]) -> tuple[Choice, ...]:
    return Choice(f"no-{name}", change(False)), Choice(name, change(True))


ABLATIONS: dict[str, tuple[Choice, ...]] = {
    # the paper's
    "rear": (
        Choice("no-rear", _tokens(rear=False), "72.86 ± 5.56"),
        Choice("rear", _tokens(rear=True), PAPER_WHOLE),
    ),
    "speeds": (
        # Nor anything that follows from the speeds of others.
        Choice(
            "no-speeds",
            _tokens(speed=False, meetings=False, tracks=False, foresight=0.0),
            "72.34 ± 3.30",
        ),
        Choice("speeds", _tokens(speed=True), PAPER_WHOLE),
    ),
    "auxiliary": (
        Choice("no-auxiliary", _auxiliary(0.0)),
        Choice("auxiliary", _auxiliary(TrainingSettings.auxiliary)),
    ),
    "data": (
        Choice("data-1of3", _data(1)),
        Choice("data-2of3", _data(2)),
        Choice("data-3of3", _data(3), PAPER_WHOLE),
    ),
    "size": (_size("mini"), _size("small"), _size("medium", PAPER_WHOLE)),
    # ours
    "stop-line": _told("stop-line", lambda told: _tokens(stop_line=told)),
    "vulnerable": _told("vulnerable", lambda told: _tokens(vulnerable=told)),
    "limit-input": _told("limit-input", lambda told: _network(limit_input=told)),
    "speed-input": _told("speed-input", lambda told: _network(speed_input=told)),
    "meetings": _told("meetings", lambda told: _tokens(meetings=told)),
    "tracks": _told("tracks", lambda told: _tokens(tracks=told)),
    "foresight": (
        Choice("no-foresight", _tokens(foresight=0.0)),
        Choice("foresight-5s", _tokens(foresight=5.0)),
    ),
    "reach": (Choice("reach-30", _tokens(reach=30.0)), Choice("reach-50", _tokens(reach=50.0))),
}
