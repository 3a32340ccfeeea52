"""Escapes untrusted text for messages, tables, the terminal and HTML pages."""

import json
from collections.abc import Callable

SHOWN = 80  # maximum length of a quotation in a message, characters
LONGEST_CELL = 60  # maximum length of a table's cell, characters
_UNSAFE = {"<": "\\u003c", ">": "\\u003e", "&": "\\u0026"}  # `json.dumps` escapes non-ASCII ones


def spelt_out(text: str) -> str:
    r"""Return text with its control characters as escape sequences, for quotations in messages.

    >>> print(spelt_out("a\x1b[31mb"))
    a\x1b[31mb
    """
    return _printable(text, lambda letter: letter.encode("unicode_escape").decode())


def one_line(text: str, most: int = SHOWN, *, instead: str = " ") -> str:
    r"""Return text as one line without control characters, truncated if too long.

    Args:
        text: The text.
        most: Maximum length, characters.
        instead: Replacement of each control character.

    >>> one_line("a\x1b[31mb"), one_line("a\nb", instead="?"), one_line("abc", 2)
    ('a [31mb', 'a?b', 'ab...')
    """
    return shortened(_printable(text, lambda _: instead), most)


def table_cell(text: str, most: int = LONGEST_CELL) -> str:
    r"""Return text as one line with single spaces, of at most `most` characters.

    >>> table_cell("a\nb" + "c" * 9, 6)
    'a bcc…'
    """
    plain = " ".join(_printable(text, lambda _: " ").split())
    return plain if len(plain) <= most else f"{plain[: most - 1]}…"


def shortened(text: str, most: int) -> str:
    """Return text; if longer than `most` characters, truncate it and append three dots."""
    return text if len(text) <= most else f"{text[:most]}..."


def script_json(value: object) -> str:
    """Return a value as JSON that is safe inside an HTML script, whatever its strings contain.

    Raises:
        ValueError: It contains NaN or infinity.
    """
    text = json.dumps(value, ensure_ascii=True, allow_nan=False, separators=(",", ":"))
    for character, escape in _UNSAFE.items():
        text = text.replace(character, escape)
    return text


def _printable(text: str, instead: Callable[[str], str]) -> str:
    if text.isprintable():
        return text
    return "".join(letter if letter.isprintable() else instead(letter) for letter in text)
