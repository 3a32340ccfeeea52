"""Reading XML of strangers: limits on size and depth, no document types, one line a fault."""

import gzip
import zlib
from collections.abc import Callable, Mapping
from pathlib import Path
from xml.parsers import expat

from plant_bench.errors import InputError, in_one_line

DEEPEST = 64  # elements inside each other
ENCODINGS = ("utf-8", "us-ascii", "ascii", "iso-8859-1")
_GZIP = b"\x1f\x8b"
_ARCHIVES = (b"PK", b"BZh", b"\xfd7z", b"7z\xbc", b"\x28\xb5\x2f\xfd")
_CHUNK = 2**20

Enter = Callable[[str, Mapping[str, str]], None]
Leave = Callable[[str], None]


def read_limited(path: Path, most: int) -> bytes:
    """Return a file's bytes, unpacked where it is a gzip file.

    Raises:
        InputError: It holds more than `most` bytes, or is an archive of another kind, or damaged.
    """
    with path.open("rb") as file:
        begin = file.read(4)
    if begin.startswith(_ARCHIVES):
        raise InputError(f"{path} is an archive: unpack it and give the file inside it.")
    try:
        with gzip.open(path) if begin.startswith(_GZIP) else path.open("rb") as file:
            content = file.read(most + 1)
    except (EOFError, zlib.error, gzip.BadGzipFile) as error:
        raise InputError(f"{path} is a damaged gzip file: {in_one_line(error)}.") from error
    if len(content) > most:
        raise InputError(
            f"{path} holds more than {most / 2**20:.0f} MB, the most that is read: cut out the "
            "part that is to be driven in."
        )
    return content


def scan_xml(content: bytes, path: Path, enter: Enter, leave: Leave | None = None) -> None:
    """Go through an XML text once, and call a function for each element that begins or ends.

    Args:
        content: The text.
        path: Its file, for messages.
        enter: Told each element's name and attributes.
        leave: Told the name of each element that ends.

    Raises:
        InputError: The text is no XML, is cut off, is in an encoding that few programs agree on,
            has a document type, or too deep a nesting.
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
            f"{path} is no whole XML file ({expat.ErrorString(error.code)}, line "
            f"{error.lineno}): get it again."
        ) from error


class _Scan:
    """What expat is told to call; mutable."""

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
            f"{self._path} has a document type (<!DOCTYPE ...>), by which XML files read others or "
            "blow up, and no map needs: remove it."
        )

    def enter(self, name: str, attributes: dict[str, str]) -> None:
        self._depth += 1
        if self._depth > DEEPEST:
            raise InputError(
                f"{self._path} has more than {DEEPEST} elements inside each other: that is no map."
            )
        self._enter(name, attributes)

    def leave(self, name: str) -> None:
        self._depth -= 1
        if self._leave is not None:
            self._leave(name)
