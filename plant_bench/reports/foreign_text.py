"""Text of others, as it may stand in one line of a message or of the terminal."""

SHOWN = 80  # characters


def one_line(text: str, most: int = SHOWN) -> str:
    r"""Return text without control characters, cut where it is too long.

    >>> one_line("a\x1b[31mb")
    'a [31mb'
    """
    line = "".join(letter if letter.isprintable() else " " for letter in text)
    return line if len(line) <= most else f"{line[:most]}..."
