"""Reads untrusted XML: limits on size and depth, no document types, one-line errors."""

import gzip
import zlib
from collections.abc import Callable, Mapping
from pathlib import Path
from xml.parsers import expat

from plant_bench.errors import InputError, in_one_line

MAX_DEPTH = 64  # nested elements
ENCODINGS = ("utf-8", "us-ascii", "ascii", "iso-8859-1")
_GZIP = b"\x1f\x8b"
_ARCHIVES = (b"PK", b"BZh", b"\xfd7z", b"7z\xbc", b"\x28\xb5\x2f\xfd")
_CHUNK = 2**20

Enter = Callable[[str, Mapping[str, str]], None]
Leave = Callable[[str], None]


def read_limited(path: Path, max_bytes: int) -> bytes:
    """Return a file's bytes, decompressed if it is a gzip file.

    Raises:
        InputError: It has more than `max_bytes` bytes, is another kind of archive, or is damaged.
    """
    with path.open("rb") as file:
        begin = file.read(4)
    if begin.startswith(_ARCHIVES):
        raise InputError(f"{path} is an archive: unpack it and pass the file inside it.")
    try:
        with gzip.open(path) if begin.startswith(_GZIP) else path.open("rb") as file:
            content = file.read(max_bytes + 1)
    except (EOFError, zlib.error, gzip.BadGzipFile) as error:
        raise InputError(f"{path} is a damaged gzip file: {in_one_line(error)}.") from error
    if len(content) > max_bytes:
        raise InputError(
            f"{path} has more than {max_bytes / 2**20:.0f} MB, the limit: cut out the part of the "
            "map that you need."
        )
    return content


def scan_xml(content: bytes, path: Path, enter: Enter, leave: Leave | None = None) -> None:
    """Parse XML once and call a function at the start and end of each element.

    Args:
        content: The XML text.
        path: Its file, for messages.
        enter: Called with the name and attributes of each element that starts.
        leave: Called with the name of each element that ends.

    Raises:
        InputError: The text is not XML, is truncated, is in an unsupported encoding, has a
            document type, or is nested too deeply.
    """
    scan = _Scan(path, enter, leave)
    parser = expat.ParserCreate()
    parser.XmlDeclHandler = scan.declare
    parser.StartDoctypeDeclHandler = scan.refuse_doctype
    parser.StartElementHandler = scan.enter
    parser.EndElementHandler = scan.leave
    if content.startswith((b"\xff\xfe", b"\xfe\xff", b"\0")):
        raise InputError(f"{path} is not in UTF-8: save it as UTF-8.")
    try:
        for start in range(0, len(content), _CHUNK):
            parser.Parse(content[start : start + _CHUNK], False)
        parser.Parse(b"", True)
    except expat.ExpatError as error:
        raise InputError(
            f"{path} is not a complete XML file ({expat.ErrorString(error.code)}, line "
            f"{error.lineno}): download or export it again."
        ) from error


class _Scan:
    """Handlers for expat; mutable."""

    def __init__(self, path: Path, enter: Enter, leave: Leave | None) -> None:
        self._path = path
        self._enter = enter
        self._leave = leave
        self._depth = 0

    def declare(self, _version: str, encoding: str | None, _alone: int) -> None:
        if encoding is not None and encoding.lower() not in ENCODINGS:
            raise InputError(f"{self._path} is in {encoding[:40]!r}: save it as UTF-8.")

    def refuse_doctype(self, *_: object) -> None:
        raise InputError(
            f"{self._path} has a document type (<!DOCTYPE ...>), which can read other files or "
            "expand without limit: remove it. Maps do not need one."
        )

    def enter(self, name: str, attributes: dict[str, str]) -> None:
        self._depth += 1
        if self._depth > MAX_DEPTH:
            raise InputError(
                f"{self._path} has more than {MAX_DEPTH} nested elements, which no map has: "
                "check the file."
            )
        self._enter(name, attributes)

    def leave(self, name: str) -> None:
        self._depth -= 1
        if self._leave is not None:
            self._leave(name)
