"""Reads untrusted text and JSON files, with limits on type, size and nesting.

Faults are raised as OSError or ValueError, whose text the caller puts into an `InputError`.
"""

import json
import re
import stat
from pathlib import Path
from typing import Any, NoReturn

LARGEST_TEXT = 64_000_000  # bytes; the largest town here has 0.3 million
_SURROGATE = re.compile(r"\\u[dD][89a-fA-F]")  # a letter beyond the first 65,536, or half of one
_DIGITS = 19  # of a whole number; no field needs more


def read_text(path: Path, *, largest: int = LARGEST_TEXT) -> str:
    """Read a text file.

    Args:
        path: Of an ordinary file: a pipe or a device would never end.
        largest: Bytes it may have.

    Raises:
        OSError: It cannot be read.
        ValueError: It is no ordinary file, is too large, or is not UTF-8.
    """
    check_file(path, largest=largest)
    with path.open("rb") as file:
        return file.read(largest + 1).decode("utf-8")


def check_file(path: Path, *, largest: int) -> None:
    """Check that a path is of an ordinary file that is not too large.

    Raises:
        OSError: There is none.
        ValueError: It is another thing, or too large.
    """
    facts = path.stat()
    if not stat.S_ISREG(facts.st_mode):
        message = "it is no ordinary file"
        raise ValueError(message)
    if facts.st_size > largest:
        message = f"it has {facts.st_size:,} bytes, at most {largest:,} are read"
        raise ValueError(message)


def parse_json(text: str) -> Any:
    """Return the values of JSON.

    Raises:
        ValueError: It is no JSON, is nested too deeply, or has numbers or letters that are none.
    """
    try:
        value = json.loads(text, parse_constant=_no_number, parse_int=_whole_number)
        if _SURROGATE.search(text):
            json.dumps(value, ensure_ascii=False).encode()
    except RecursionError:
        message = "it is nested too deeply"
        raise ValueError(message) from None
    except UnicodeEncodeError:
        message = "it has half of a character, which no file can hold"
        raise ValueError(message) from None
    return value


def read_json(path: Path, *, largest: int = LARGEST_TEXT) -> Any:
    """Read a JSON file; as `read_text` and `parse_json`.

    Raises:
        OSError: It cannot be read.
        ValueError: It is not what is wanted.
    """
    return parse_json(read_text(path, largest=largest))


def _no_number(name: str) -> NoReturn:
    message = f"{name} is no number"
    raise ValueError(message)


def _whole_number(digits: str) -> int:
    if len(digits) > _DIGITS:
        message = f"a whole number of {len(digits)} digits"
        raise ValueError(message)
    return int(digits)
