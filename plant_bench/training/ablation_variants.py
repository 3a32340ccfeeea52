"""Defines the variants of an ablation study: a base recipe with one setting changed.

The ablations are those of the learner (`Learner.ablations`), and "data": the share of the episodes.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

from plant_bench.errors import InputError, did_you_mean
from plant_bench.training.learners import LearnerSpec, learner_class
from plant_bench.training.settings import TrainingSettings

BASE = "base"
DATA = "data"


@dataclass(frozen=True)
class Recipe:
    """Everything that determines a trained network, apart from the data.

    Attributes:
        learner: The learner and its options.
        settings: The training settings.
        share: Share of the episodes to train on, see `load_frames`.
    """

    learner: LearnerSpec
    settings: TrainingSettings
    share: float = 1.0


Change = Callable[[Recipe], Recipe]


@dataclass(frozen=True)
class Variant:
    """One variant of an ablation.

    Attributes:
        ablation: Name of the ablation.
        name: Name of the variant.
        training: Name of the training; variants equal to the base share the base's training.
        recipe: The recipe.
        paper: Driving score (DS) in the paper.
    """

    ablation: str
    name: str
    training: str
    recipe: Recipe
    paper: str


@dataclass(frozen=True)
class _Choice:
    name: str
    change: Change
    paper: str = "-"


def variants_of(names: Sequence[str], base: Recipe) -> list[Variant]:
    """Return the base and the selected variants.

    Args:
        names: Names of ablations or of single variants; empty for all.
        base: The recipe that the variants change.

    Raises:
        InputError: There is no such ablation.
    """
    table = _table(base.learner.name)
    check_names(names, base.learner.name)
    found = [Variant(BASE, BASE, BASE, base, "-")]
    selected = set(names or table)
    for name, choices in table.items():
        for choice in choices:
            if selected.isdisjoint((name, choice.name)):
                continue
            recipe = choice.change(base)
            training = BASE if recipe == base else choice.name
            found.append(Variant(name, choice.name, training, recipe, choice.paper))
    return found


def check_names(names: Sequence[str], learner: str) -> None:
    """Check that each name is an ablation or a variant of the learner.

    Raises:
        InputError: A name is unknown.
    """
    table = _table(learner)
    variants = {choice.name for choices in table.values() for choice in choices}
    for name in names:
        if name not in table and name not in variants:
            hint = did_you_mean(name, [*table, *sorted(variants)])
            message = f"There is no ablation '{name}'. Known ones: {', '.join(table)}.{hint}"
            raise InputError(message)


def trainings_of(variants: Sequence[Variant]) -> dict[str, Recipe]:
    """Return the recipe of each distinct training, by its name."""
    return {variant.training: variant.recipe for variant in variants}


def _table(learner: str) -> Mapping[str, tuple[_Choice, ...]]:
    kind = learner_class(learner)
    return _data_ablation(kind.paper) | {
        name: tuple(
            _Choice(choice.name, _change_options(choice.change), choice.paper) for choice in choices
        )
        for name, choices in kind.ablations.items()
    }


def _change_options(change: Callable[[object], object]) -> Change:
    def change_recipe(base: Recipe) -> Recipe:
        learner = replace(base.learner, options=change(base.learner.options))
        return replace(base, learner=learner)

    return change_recipe


def _data_share(thirds: int) -> Change:
    return lambda base: replace(base, share=base.share * (thirds / 3))


def _data_ablation(whole: str) -> dict[str, tuple[_Choice, ...]]:
    names = ("data-1of3", "data-2of3", "data-3of3")
    papers = ("-", "-", whole)
    rows = enumerate(zip(names, papers, strict=True), 1)
    return {
        DATA: tuple(_Choice(name, _data_share(thirds), paper) for thirds, (name, paper) in rows)
    }
