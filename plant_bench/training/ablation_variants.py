"""Defines the variants of an ablation study: a base recipe with one setting changed.

The ablations are those of the learner (`Learner.ablations`), and the share of the data.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

from plant_bench.errors import InputError, did_you_mean
from plant_bench.training.learners import Student, learner_class
from plant_bench.training.settings import TrainingSettings

BASE = "base"
DATA = "data"


@dataclass(frozen=True)
class Recipe:
    """Everything that determines a trained network, apart from the data.

    Attributes:
        student: The learner and its options.
        settings: The training settings.
        share: Share of the episodes to train on, see `load_frames`.
    """

    student: Student
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
        paper: DS in the paper.
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
    """Return the base, and all choices of the named ablations; of all of them without a name.

    Args:
        names: Of ablations, or of single choices.
        base: What is changed.

    Raises:
        InputError: There is no such ablation.
    """
    table = _table(base.student.spec)
    check_names(names, base.student.spec)
    found = [Variant(BASE, BASE, BASE, base, "-")]
    wanted = set(names or table)
    for name, choices in table.items():
        for choice in choices:
            if wanted.isdisjoint((name, choice.name)):
                continue
            recipe = choice.change(base)
            training = BASE if recipe == base else choice.name
            found.append(Variant(name, choice.name, training, recipe, choice.paper))
    return found


def check_names(names: Sequence[str], learner: str) -> None:
    """Check that there are such ablations, or choices, of a learner.

    Raises:
        InputError: There are none.
    """
    table = _table(learner)
    alone = {choice.name for choices in table.values() for choice in choices}
    for name in names:
        if name not in table and name not in alone:
            hint = did_you_mean(name, [*table, *sorted(alone)])
            message = f"There is no ablation '{name}': {', '.join(table)} are known.{hint}"
            raise InputError(message)


def trainings_of(variants: Sequence[Variant]) -> dict[str, Recipe]:
    """Return each training that the variants need, once."""
    return {variant.training: variant.recipe for variant in variants}


def _table(learner: str) -> Mapping[str, tuple[_Choice, ...]]:
    kind = learner_class(learner)
    return _shares(kind.paper) | {
        name: tuple(
            _Choice(choice.name, _of_options(choice.change), choice.paper) for choice in choices
        )
        for name, choices in kind.ablations.items()
    }


def _of_options(change: Callable[[object], object]) -> Change:
    def of_recipe(base: Recipe) -> Recipe:
        student = replace(base.student, options=change(base.student.options))
        return replace(base, student=student)

    return of_recipe


def _data(thirds: int) -> Change:
    return lambda base: replace(base, share=base.share * (thirds / 3))


def _shares(whole: str) -> dict[str, tuple[_Choice, ...]]:
    names = ("data-1of3", "data-2of3", "data-3of3")
    papers = ("-", "-", whole)
    rows = enumerate(zip(names, papers, strict=True), 1)
    return {DATA: tuple(_Choice(name, _data(thirds), paper) for thirds, (name, paper) in rows)}
