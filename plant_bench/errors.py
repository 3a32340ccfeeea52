"""Every error that plant-bench raises on purpose.

PlantBenchError
├── InputError        what the user gave cannot be used; the command line exits with code 2
├── AgentError        a planner raised, or returned something that is not a plan or a control
└── SimulationError   SUMO failed in a way that no input explains
"""

import difflib
from collections.abc import Iterable

from plant_bench.text_escaping import shortened, spelt_out

LONGEST = 200  # characters of another error's text
LONGEST_MESSAGE = 2000  # characters of one of ours


class PlantBenchError(Exception):
    """Base of all errors raised by plant-bench."""


class InputError(PlantBenchError):
    """Raised when input is unusable: says what was found, what was wanted and what to do."""

    def __str__(self) -> str:
        r"""Return the message as one line that is safe to print, whatever it quotes of a file.

        >>> str(InputError("There is no town 'a\n\x1b[31mb'."))
        "There is no town 'a \\x1b[31mb'."
        """
        line = " ".join(super().__str__().splitlines())
        return shortened(spelt_out(line), LONGEST_MESSAGE)


class AgentError(PlantBenchError):
    """Raised when a planner fails; it ends that planner's episode and nothing else."""


class SimulationError(PlantBenchError):
    """Raised when the simulator fails or loses the ego vehicle."""


def in_one_line(error: Exception) -> str:
    r"""Return what an error says as one line, cut where it is long, without links to read on.

    >>> in_one_line(ValueError("not JSON:\n  line 2\n    For further information visit x"))
    'not JSON: line 2'
    """
    lines = [line.strip() for line in str(error).splitlines()]
    text = " ".join(line for line in lines if line and not line.startswith("For further "))
    return shortened(text, LONGEST)


def did_you_mean(word: str, known: Iterable[str], *, cutoff: float = 0.6, quote: str = "") -> str:
    """Return a question to end a message with, empty where no known word is like the one given.

    Args:
        word: What was given.
        known: What could have been.
        cutoff: How like they must be, 0 to 1.
        quote: Stands around the word.

    >>> did_you_mean("exprt", ["expert", "idm"], quote="'"), did_you_mean("x", ["expert"])
    (" Did you mean 'expert'?", '')
    """
    near = difflib.get_close_matches(word, known, n=1, cutoff=cutoff)
    return f" Did you mean {quote}{near[0]}{quote}?" if near else ""
