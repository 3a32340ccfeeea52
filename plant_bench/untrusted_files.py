"""Reads untrusted text and JSON files, with limits on type, size and nesting.

Errors are raised as OSError or ValueError; the caller puts their text into an `InputError`.
"""

import json
import re
import stat
import zlib
from pathlib import Path
from typing import Any, NoReturn

LARGEST_TEXT = 64_000_000  # bytes; the largest built-in town has 0.3 million
_GZIP = b"\x1f\x8b"
_SURROGATE = re.compile(r"\\u[dD][89a-fA-F]")  # escape of a surrogate, paired or not
_DIGITS = 19  # maximum digits of an integer; no field needs more


def read_text(path: Path, *, largest: int = LARGEST_TEXT) -> str:
    """Read a text file, also one compressed with gzip.

    Args:
        path: A regular file; reading a pipe or a device might never end.
        largest: Maximum size, bytes.

    Raises:
        OSError: The file cannot be read.
        ValueError: It is not a regular file, is too large, or is not UTF-8.
    """
    check_file(path, largest=largest)
    with path.open("rb") as file:
        content = file.read(largest + 1)
    if content.startswith(_GZIP):
        content = _decompressed(content, largest)
    return content.decode("utf-8")


def _decompressed(content: bytes, largest: int) -> bytes:
    unpacker = zlib.decompressobj(wbits=31)
    try:
        text = unpacker.decompress(content, largest + 1)
    except zlib.error as error:
        message = f"it is a damaged gzip file ({error})"
        raise ValueError(message) from error
    if len(text) > largest or not unpacker.eof:
        message = f"it is truncated, or has more than {largest:,} bytes when decompressed"
        raise ValueError(message)
    return text


def check_file(path: Path, *, largest: int) -> None:
    """Check that a path is a regular file that is not too large.

    Raises:
        OSError: The file does not exist.
        ValueError: It is not a regular file, or is too large.
    """
    facts = path.stat()
    if not stat.S_ISREG(facts.st_mode):
        message = "it is not a regular file"
        raise ValueError(message)
    if facts.st_size > largest:
        message = f"expected at most {largest:,} bytes, got {facts.st_size:,}"
        raise ValueError(message)


def parse_json(text: str) -> Any:
    """Return the parsed value of JSON text.

    Raises:
        ValueError: It is not valid JSON, is nested too deeply, or contains NaN, infinity, very long
            integers or unpaired surrogates.
    """
    try:
        value = json.loads(text, parse_constant=_no_number, parse_int=_whole_number)
        if _SURROGATE.search(text):
            json.dumps(value, ensure_ascii=False).encode()
    except RecursionError:
        message = "it is nested too deeply"
        raise ValueError(message) from None
    except UnicodeEncodeError:
        message = "it contains an unpaired surrogate, which is not valid Unicode"
        raise ValueError(message) from None
    return value


def read_json(path: Path, *, largest: int = LARGEST_TEXT) -> Any:
    """Read a JSON file; see `read_text` and `parse_json`.

    Raises:
        OSError: The file cannot be read.
        ValueError: It is not a regular file, is too large, or is not valid JSON.
    """
    return parse_json(read_text(path, largest=largest))


def _no_number(name: str) -> NoReturn:
    message = f"expected finite numbers, got {name}"
    raise ValueError(message)


def _whole_number(digits: str) -> int:
    if len(digits) > _DIGITS:
        message = f"expected integers of at most {_DIGITS} digits, got one of {len(digits)}"
        raise ValueError(message)
    return int(digits)
