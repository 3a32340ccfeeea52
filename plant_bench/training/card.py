"""Writes the model card: data, settings and results of a training, and how to reproduce it."""

import platform
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from importlib.metadata import version
from typing import Any

from torch import nn

from plant_bench import __version__
from plant_bench.learner import Learner
from plant_bench.runner.run.provenance import processor_name
from plant_bench.training.batches import Split
from plant_bench.training.history import DRIVING_SCORE, columns_of
from plant_bench.training.settings import TrainingSettings

_VERSIONS = ("torch", "lightning-fabric", "numpy", "libsumo")
_HOURS = 0.5 / 3600.0  # hours of driving per sample
_ROWS = 12  # approximate maximum of rows in the table of losses


@dataclass(frozen=True)
class Origin:
    """Origin of a model's weights.

    Attributes:
        chosen: A sentence that says which epoch's weights these are, and why.
        command: The training's command line.
        sources: Origin of the data, one text per data folder.
        start: Hash of the initial weights; empty if they were random.
    """

    chosen: str
    command: str
    sources: Sequence[str] = ()
    start: str = ""


def model_card(
    name: str,
    learner: Learner,
    network: nn.Module,
    settings: TrainingSettings,
    split: Split,
    history: list[dict[str, float]],
    origin: Origin,
) -> str:
    """Return the card as Markdown.

    Args:
        name: Name of the model.
        learner: The learner.
        network: The trained network.
        settings: The training settings.
        split: The data.
        history: One row per epoch, see `Trainer`.
        origin: Origin of the weights.
    """
    facts = {
        **_weights(learner, network),
        **_data(split),
    }
    made_by = [("data source", source) for source in origin.sources]
    start = f"weights of hash {origin.start}" if origin.start else ""
    rest = {"command": f"`{origin.command}`", "initial weights": start, **_machine()}
    rows = [*facts.items(), *made_by, *((key, text) for key, text in rest.items() if text)]
    return "\n".join(
        [
            f"# {name}",
            "",
            f"{learner.title}, trained by imitation of plant-bench's expert. It drives",
            f"with `plant-bench score --agent {learner.agent}@FOLDER`. {origin.chosen}",
            "",
            "| | |",
            "|---|---|",
            *(f"| {key} | {text} |" for key, text in rows),
            "",
            "## Reproduction",
            "",
            "Use the same data (see its hash above), command and versions. The weights are then",
            "identical on the same machine with the same number of threads and one process;",
            "otherwise rounding errors of sums differ.",
            "",
            *_table("Learner", dict(_flat(learner.recipe))),
            *_table("Training", asdict(settings)),
            *_losses(history),
        ]
    )


def _weights(learner: Learner, network: nn.Module) -> dict[str, str]:
    used = sum(weights.numel() for weights in network.parameters())
    return {"parameters": f"{used:,}", **learner.facts(network)}


def _data(split: Split) -> dict[str, str]:
    training, validation = len(split.training), len(split.validation)
    count = training + validation + split.left_out
    data = f"{count:,} samples at 2 Hz = {count * _HOURS:.1f} h, {split.episodes} episodes"
    if split.left_out:
        data += f"; {split.left_out:,} of them are dropped (the ego is and stays stationary)"
    return {
        "data": f"{data}, hash {split.fingerprint}",
        "held out": f"{validation:,} samples of the routes {', '.join(split.held_out) or '-'}",
    }


def _machine() -> dict[str, str]:
    packages = [f"{package} {version(package)}" for package in _VERSIONS]
    versions = ", ".join([f"Python {platform.python_version()}", *packages])
    return {"processor": processor_name(), "versions": f"plant-bench {__version__}, {versions}"}


def _table(title: str, values: Mapping[str, object]) -> list[str]:
    rows = [f"| {name} | {value} |" for name, value in values.items()]
    return [f"## {title}", "", "| setting | value |", "|---|---|", *rows, ""]


def _flat(values: Mapping[str, Any], before: str = "") -> Iterator[tuple[str, object]]:
    for name, value in values.items():
        if isinstance(value, Mapping):
            yield from _flat(value, f"{before}{name}.")
        else:
            yield f"{before}{name}", value


def _losses(history: list[dict[str, float]]) -> list[str]:
    columns = columns_of(history)
    step = max(1, -(-len(history) // _ROWS))
    rows = [
        "| " + " | ".join(f"{row[name]:.5g}" if name in row else "" for name in columns) + " |"
        for place, row in enumerate(history)
        if place % step == 0 or place == len(history) - 1 or DRIVING_SCORE in row
    ]
    head = ["| " + " | ".join(columns) + " |", "|" + "---|" * len(columns)]
    return ["## Losses", "", *head, *rows, ""]
