"""Options that `train plant` and `ablate` have in common, with one meaning and one help text."""

from pathlib import Path
from typing import Annotated, Literal

import typer

DataOption = Annotated[
    list[Path], typer.Option(help="Folder with routes/ and episodes/; give it again for more.")
]
ShareOption = Annotated[
    float, typer.Option(help="Of each folder's episodes, the first.", min=0.001, max=1.0)
]
EpochsOption = Annotated[int, typer.Option(help="Passes over the data.", min=1)]
BatchOption = Annotated[int, typer.Option(help="Samples a step, over all devices.", min=1)]
RateOption = Annotated[float, typer.Option(help="Learning rate.")]
RestingOption = Annotated[
    float,
    typer.Option(help="Share kept of samples in which one stands and stays.", min=0.0, max=1.0),
]
TargetsOption = Annotated[
    Literal["future", "answer"],
    typer.Option(help="Learn where the ego went, or where the expert's acceleration leads."),
]
AcceleratorOption = Annotated[str, typer.Option(help="cpu, cuda, mps or auto.")]
ThreadsOption = Annotated[
    int, typer.Option(help="Of each training process; 0 for one a core.", min=0)
]
