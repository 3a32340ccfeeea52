"""The model card: what a reader needs to judge the weights, and to make them again."""

import platform
from collections.abc import Sequence
from dataclasses import asdict
from importlib.metadata import version

from plant_bench import __version__
from plant_bench.agents.plant.config import PlanTConfig
from plant_bench.agents.plant.encoder import bert_parameters
from plant_bench.agents.plant.network import PlanTNetwork
from plant_bench.runner.run.provenance import processor_name
from plant_bench.training.batches import Split
from plant_bench.training.logs import COLUMNS
from plant_bench.training.settings import TrainingSettings

_VERSIONS = ("torch", "lightning-fabric", "numpy", "libsumo")
_HOURS = 0.5 / 3600.0  # of driving a sample
_ROWS = 12  # of the table of losses, at most


def model_card(
    name: str,
    network: PlanTNetwork,
    settings: TrainingSettings,
    split: Split,
    history: list[dict[str, float]],
    *,
    chosen: str,
    command: str,
    sources: Sequence[str] = (),
    start: str = "",
) -> str:
    """Return the card as Markdown.

    Args:
        name: Of the model.
        network: As saved.
        settings: How it was trained.
        split: On what.
        history: A row an epoch.
        chosen: Which epoch's weights these are, and why.
        command: What made it.
        sources: Where the data comes from, a text a folder.
        start: Hash of the weights it started from; empty where those were drawn.
    """
    config: PlanTConfig = network.config
    learnt, checked = len(split.training), len(split.validation)
    used = sum(weights.numel() for weights in network.parameters())
    count = learnt + checked + split.left_out
    data = f"{count:,} samples at 2 Hz = {count * _HOURS:.1f} h, {split.episodes} episodes"
    if split.left_out:
        data += f"; {split.left_out:,} of them, in which the ego stands and stays, are left out"
    packages = [f"{package} {version(package)}" for package in _VERSIONS]
    versions = ", ".join([f"Python {platform.python_version()}", *packages])
    return "\n".join(
        [
            f"# {name}",
            "",
            f"PlanT of size {config.size}, trained by imitation of plant-bench's expert. It drives",
            f"with `plant-bench score --agent plant@FOLDER`. {chosen}",
            "",
            "| | |",
            "|---|---|",
            f"| parameters | {used:,}; {bert_parameters(config.encoder):,} as the paper counts |",
            f"| data | {data}, hash {split.fingerprint} |",
            f"| held out | {checked:,} samples of the routes {', '.join(split.held_out) or '-'} |",
            *(f"| data made by | {source} |" for source in sources),
            f"| command | `{command}` |",
            *([f"| started from | weights of hash {start} |"] if start else []),
            f"| processor | {processor_name()} |",
            f"| versions | plant-bench {__version__}, {versions} |",
            "",
            "## To make it again",
            "",
            "The same data (see its hash above), the same command and the same versions.",
            "On one process of one machine the numbers are then the same; on another machine, or",
            "another number of threads, sums are rounded differently.",
            "",
            *_table("Network", _flat(asdict(config))),
            *_table("Training", asdict(settings)),
            *_losses(history),
        ]
    )


def _table(title: str, values: dict[str, object]) -> list[str]:
    rows = [f"| {name} | {value} |" for name, value in values.items()]
    return [f"## {title}", "", "| setting | value |", "|---|---|", *rows, ""]


def _flat(values: dict) -> dict[str, object]:
    tokens = {f"tokens.{name}": value for name, value in values["tokens"].items()}
    return {name: value for name, value in values.items() if name != "tokens"} | tokens


def _losses(history: list[dict[str, float]]) -> list[str]:
    step = max(1, -(-len(history) // _ROWS))
    rows = [
        "| " + " | ".join(f"{row[name]:.5g}" if name in row else "" for name in COLUMNS) + " |"
        for place, row in enumerate(history)
        if place % step == 0 or place == len(history) - 1 or "driving_score" in row
    ]
    head = ["| " + " | ".join(COLUMNS) + " |", "|" + "---|" * len(COLUMNS)]
    note = "Waypoints in metres, x and y added; vehicles in nats, six attributes added."
    return ["## Losses", "", note, "", *head, *rows, ""]
