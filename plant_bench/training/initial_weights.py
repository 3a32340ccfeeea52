"""Loads the initial weights of a training from an earlier model."""

from pathlib import Path
from typing import Any

from torch import Tensor

from plant_bench.learner import Learner
from plant_bench.model_folder import load_state, read_config


def options_in(kind: type[Learner], folder: Path) -> Any:
    """Return the options of a trained model.

    Raises:
        InputError: The folder holds no model of this learner.
    """
    return read_config(folder, kind.name, kind.options_of)


def check_start(learner: Learner, folder: Path) -> None:
    """Check that a training can start from a model; only its configuration is read.

    Raises:
        InputError: It cannot.
    """
    learner.start_from(options_in(type(learner), folder), {})


def state_to_start_from(learner: Learner, folder: Path) -> dict[str, Tensor]:
    """Return the initial weights.

    Raises:
        InputError: The folder holds no weights that fit the learner.
    """
    return dict(learner.start_from(options_in(type(learner), folder), load_state(folder)))
