"""Mutations of XML that are likely to cause errors: in the tree, or in the surrounding text."""

import gzip
import random
import re
import zlib
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

GZIP = b"\x1f\x8b"
EVIL: tuple[str, ...] = (  # values of attributes
    "", " ", "0", "-1", "1", "1.5", "nan", "NaN", "inf", "-inf", "1e999", "-1e308", "1e-320",
    "-0.0", "9" * 30, "9" * 5000, "0x10", "1,2", "0,0 0,0", "0,0 1e9,1e9", "nan,nan inf,inf",
    "1,2,3 4", ("1,2 " * 20_000), "x" * 300, "y" * 100_000, "../fuzz-escaped", "/tmp/fuzz-escaped",
    "/etc/passwd", "file:///dev/zero", "/dev/zero", "$(touch fuzz-escaped)", "; touch fuzz-escaped",
    "-o", "--output-file=fuzz-escaped", "\n", "a\nb", "\t", "é", "地", "%s%n", "[bold]x[/]",
    ":", ":x_0", "true",
    "passenger", "all", "pedestrian", "-2147483648", "2147483647", "4294967296",
    "9223372036854775807", "Town99", "UTM", "!", "-", "+proj=utm +zone=32", "internal", "e0_0",
)  # fmt: skip
PROLOGUES: tuple[bytes, ...] = (
    b'<!DOCTYPE x [<!ENTITY e SYSTEM "file:///etc/passwd">]>',
    b'<!DOCTYPE x SYSTEM "/dev/zero">',
    b'<!DOCTYPE x [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;"><!ENTITY c "&b;&b;&b;">]>',
    b'<?xml version="1.0" encoding="utf-7"?>',
    b'<?xml version="1.0" encoding="utf-16"?>',
    b'<?xml version="1.1"?>',
    b'<?xml-stylesheet href="/etc/passwd"?>',
    b"\xef\xbb\xbf", b"\xff\xfe", b"\0", b"<!--", b"<![CDATA[",
)  # fmt: skip
INSIDE: tuple[bytes, ...] = (
    b"&e;", b"&c;", b"&#0;", b"&#xD800;", b"&lt;", b'<include href="/etc/passwd"/>', b"<a>" * 100,
    b"<a>" * 100_000, b"</net>", b"<![CDATA[x]]>", b"<!-- x -->", b"<?x y?>", b"\0", b"\xff", b'"',
    b'<xi:include xmlns:xi="http://www.w3.org/2001/XInclude" href="/etc/passwd"/>', b"<x/>" * 1000,
)  # fmt: skip
NUMBERS = (
    "0", "-1", "1", "0.001", "-0.5", "30", "1000", "1e5", "1e7", "1e30", "1e300", "-1e300", "nan",
    "inf", "1e-300", "", "x",
)  # fmt: skip
_NUMBER = re.compile(r"-?\d+(\.\d*)?(e-?\d+)?")
_ATTRIBUTE = re.compile(rb'\s[\w:.-]+="[^"]*"')


def xml_changed(chance: random.Random, content: bytes) -> bytes:
    """Return XML with something else in it; a packed one stays packed."""
    if content.startswith(GZIP):
        try:
            inside = gzip.decompress(content)
        except (OSError, EOFError, zlib.error):
            return content
        return gzip.compress(xml_changed(chance, inside), 1)
    return _tree_changed(chance, content) if chance.random() < 0.8 else _text(chance, content)


def _text(chance: random.Random, content: bytes) -> bytes:
    """Change what a tree does not tell: prologues, entities, an attribute that is there twice."""
    way = chance.randrange(3)
    if way == 0:
        return chance.choice(PROLOGUES) + content
    if way == 1:
        place = chance.choice([item.start() for item in re.finditer(rb"[<>]", content)] or [0])
        place += chance.randrange(2)
        return content[:place] + chance.choice(INSIDE) + content[place:]
    found = list(_ATTRIBUTE.finditer(content))
    if not found:
        return content
    one = chance.choice(found)
    return content[: one.end()] + one[0] + content[one.end() :]


def _tree_changed(chance: random.Random, content: bytes) -> bytes:
    try:
        root = ElementTree.fromstring(content)
    except (ElementTree.ParseError, ValueError, LookupError):
        return content
    parents = {child: parent for parent in root.iter() for child in parent}
    element = _some_element(chance, root)
    parent = parents.get(element)
    way = chance.random()
    if parent is None or way < 0.55:
        _change_attributes(chance, root, element)
    else:
        _change_children(chance, parent, element, way)
    try:
        return ElementTree.tostring(root, encoding="utf-8", xml_declaration=True)
    except (ValueError, RecursionError):
        return content


def _some_element(chance: random.Random, root: Element) -> Element:
    """Return an element, each name as likely as any other."""
    by_name: dict[str, list[Element]] = {}
    for element in root.iter():
        by_name.setdefault(element.tag, []).append(element)
    return chance.choice(by_name[chance.choice(sorted(by_name))])


def _change_attributes(chance: random.Random, root: Element, element: Element) -> None:
    name = chance.choice(sorted(element.attrib) or ["id"])
    way = chance.randrange(8)
    if way == 0:
        element.attrib.pop(name, None)
    elif way < 3:
        element.set(name, _other_number(chance, element.get(name, "")))
    elif way == 3:
        element.set(name, _other_value(chance, root, name))
    elif way == 4:
        element.set(name, element.get(name, "") + chance.choice(("x", " ", ",", "0" * 300, "/..")))
    elif way == 5:
        element.set(chance.choice(_names(root)), chance.choice(EVIL))
    else:
        element.set(name, chance.choice(EVIL))


def _other_number(chance: random.Random, value: str) -> str:
    """Put another number in the place of one, in a line of many too."""
    found = list(_NUMBER.finditer(value))
    if not found:
        return chance.choice(EVIL)
    one, other = chance.choice(found), chance.choice((*NUMBERS, f"0,0,{chance.choice(NUMBERS)}"))
    return value[: one.start()] + other + value[one.end() :]


def _other_value(chance: random.Random, root: Element, name: str) -> str:
    """Return what the attribute is elsewhere: an id doubled, a reference to another thing."""
    values = sorted({item.attrib[name] for item in root.iter() if name in item.attrib})
    return chance.choice(values or ["x"])


def _names(root: Element) -> list[str]:
    return sorted({name for item in root.iter() for name in item.attrib} | {"href", "x"})


def _change_children(chance: random.Random, parent: Element, element: Element, way: float) -> None:
    place = list(parent).index(element)
    if way < 0.7:
        parent.remove(element)
    elif way < 0.8:
        parent.insert(place, element)
    elif way < 0.85:
        for _ in range(chance.choice((2, 50, 500))):
            parent.insert(place, element)
    elif way < 0.9:
        element.extend([Element(chance.choice(("x", "include", parent.tag, element.tag)))])
    elif way < 0.95:
        element.tag = chance.choice(("x", "include", parent.tag, "net", "osm", "route"))
    else:
        deepest = element
        for _ in range(chance.choice((3, 70))):
            deeper = Element(element.tag, element.attrib)
            deepest.append(deeper)
            deepest = deeper
