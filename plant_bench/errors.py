"""The exceptions that plant-bench raises.

PlantBenchError
├── InputError        the user's input is invalid; the command line exits with code 2
│   └── UserCodeError   the code of a user's planner raised an exception while it was loaded
├── AgentError        a planner raised an exception or returned an invalid action
└── SimulationError   SUMO failed, and the input is not the cause
"""

import difflib
from collections.abc import Iterable

from plant_bench.text_escaping import shortened, spelt_out

LONGEST = 200  # characters of another error's text
LONGEST_MESSAGE = 2000  # characters of a message of plant-bench


class PlantBenchError(Exception):
    """Base of all errors raised by plant-bench."""


class InputError(PlantBenchError):
    """Raised for invalid input; the message says what was found, expected, and how to fix it."""

    def __str__(self) -> str:
        r"""Return the message as one line that is safe to print, even if it quotes untrusted text.

        >>> str(InputError("There is no town 'a\n\x1b[31mb'."))
        "There is no town 'a \\x1b[31mb'."
        """
        line = " ".join(super().__str__().splitlines())
        return shortened(spelt_out(line), LONGEST_MESSAGE)


class UserCodeError(InputError):
    """Raised when a planner's own code raises an exception while it is loaded or created.

    Its cause is that exception, whose traceback has been logged (`user_code.log_traceback`).
    """


class AgentError(PlantBenchError):
    """Raised when a planner fails; it ends that planner's episode and nothing else."""


class SimulationError(PlantBenchError):
    """Raised when the simulator fails or loses the ego vehicle."""


def in_one_line(error: Exception) -> str:
    r"""Return an error's message as one line of bounded length, without links to documentation.

    >>> in_one_line(ValueError("not JSON:\n  line 2\n    For further information visit x"))
    'not JSON: line 2'
    """
    lines = [line.strip() for line in str(error).splitlines()]
    text = " ".join(line for line in lines if line and not line.startswith("For further "))
    return shortened(text, LONGEST)


def did_you_mean(word: str, known: Iterable[str], *, cutoff: float = 0.6, quote: str = "") -> str:
    """Return a suggestion to append to a message; empty if no known word is similar.

    Args:
        word: The unknown word.
        known: The known words.
        cutoff: Minimum similarity, 0 to 1.
        quote: Quotation mark around the suggested word.

    >>> did_you_mean("exprt", ["expert", "idm"], quote="'"), did_you_mean("x", ["expert"])
    (" Did you mean 'expert'?", '')
    """
    near = difflib.get_close_matches(word, known, n=1, cutoff=cutoff)
    return f" Did you mean {quote}{near[0]}{quote}?" if near else ""
