"""The data class that describes a file format to the fuzzer."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path


def _nothing(_box: Path) -> None:
    """Need nothing else in the folder."""


@dataclass(frozen=True)
class Format:
    """One format.

    Attributes:
        name: What the command line calls it.
        kind: How it is mutated: "json", "xml", "msgpack", "parquet", "safetensors" or "bytes".
        file: Its path in the case's folder.
        seeds: Makes files that load.
        load: Reads the file of a folder and uses what it gives.
        prepare: Puts what else is needed into the folder.
        programs: Names of SUMO's programs that it may start; none else may be.
        longest: Seconds that a case may take.
    """

    name: str
    kind: str
    file: str
    seeds: Callable[[], list[bytes]]
    load: Callable[[Path], object]
    prepare: Callable[[Path], None] = _nothing
    programs: frozenset[str] = frozenset()
    longest: float = 20.0


def used(*_values: object) -> None:
    """Want values that are worked out when they are asked for."""
