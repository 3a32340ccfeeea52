"""Options of a command from dataclasses: each one, its default and its help are written once.

The name, the type and the default are the field's; the help is the field's line in the docstring's
"Attributes:"; a field's `metadata` may hold "min", "max", and "option": another name, or None for
no option. Fields that are dataclasses themselves give options of their own.
"""

import inspect
import re
import types
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import MISSING, Field, dataclass, fields, is_dataclass
from enum import Enum
from pathlib import Path
from typing import Annotated, Any, Literal, Union, get_args, get_origin, get_type_hints

import typer

from plant_bench.errors import InputError

_PLAIN = (bool, int, float, str, Path)
_ITEM = re.compile(r"(\w+): (.*)")
REQUIRED: Any = MISSING


@dataclass(frozen=True)
class OptionField:
    """An option of a command, from a field of a dataclass.

    Attributes:
        path: Names of fields, from the outermost dataclass on.
        name: Of the option, with underscores.
        kind: Its type.
        default: Its value where it is not given; `REQUIRED` if it must be.
        help: One or more sentences.
        low: Least value, if there is one.
        high: Greatest value, if there is one.
    """

    path: tuple[str, ...]
    name: str
    kind: Any
    default: Any
    help: str
    low: int | float | None = None
    high: int | float | None = None

    def parameter(self, *, optional: bool = False) -> inspect.Parameter:
        """Return the parameter of a function that typer makes an option of.

        Args:
            optional: None stands for "not given", whatever the default is.
        """
        shown = _on_command_line(self.kind)
        about = typer.Option(help=self.help, min=self.low, max=self.high)
        return inspect.Parameter(
            self.name,
            inspect.Parameter.KEYWORD_ONLY,
            default=None if optional else self._shown_default(),
            annotation=Annotated[shown | None if optional else shown, about],
        )

    def _shown_default(self) -> Any:
        if self.default is REQUIRED:
            return inspect.Parameter.empty
        if get_origin(self.kind) is Literal:
            return str(self.default)
        return self.default

    def value(self, given: Any) -> Any:
        """Return the field's value for what was given."""
        if given is None:
            return None
        if get_origin(self.kind) is Literal:
            return next(item for item in get_args(self.kind) if str(item) == str(given))
        if get_origin(self.kind) is tuple:
            return tuple(given)
        return given


def option_fields(
    kind: type,
    *,
    inside: Mapping[str, type] | None = None,
    without: frozenset[str] = frozenset(),
) -> list[OptionField]:
    """Return the options of a dataclass.

    Args:
        kind: The dataclass.
        inside: What its fields of no type of their own are, by name.
        without: Names of its fields that are no options.

    Raises:
        InputError: A field's type cannot be an option, or two options have one name.
    """
    found = list(_fields(kind, inside or {}, without, (), REQUIRED))
    names = [item.name for item in found]
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        message = (
            f"Options that are there twice: {', '.join(twice)}. Name the fields otherwise, or give "
            'them metadata={"option": "another_name"}.'
        )
        raise InputError(message)
    return found


def built(kind: type, values: Mapping[tuple[str, ...], Any], base: Any = REQUIRED) -> Any:
    """Return an object of a dataclass with some values, by their fields' paths.

    Args:
        kind: The dataclass.
        values: Of fields; a field that is not there is as in the base.
        base: An object whose values are taken where none is given; by default the defaults.
    """
    arguments: dict[str, Any] = {}
    for item in fields(kind):
        inner = {path[1:]: value for path, value in values.items() if path[0] == item.name}
        if () in inner:
            arguments[item.name] = inner[()]
            continue
        found = _default(item, base)
        if inner:
            inner_kind = type(found) if found is not REQUIRED else get_type_hints(kind)[item.name]
            arguments[item.name] = built(inner_kind, inner, found)
        elif found is not REQUIRED:
            arguments[item.name] = found
    return kind(**arguments)


def with_options(
    function: Callable[..., Any], parameters: Sequence[inspect.Parameter], about: str
) -> Callable[..., Any]:
    """Return a function of keywords that typer takes for one with these parameters."""

    def command(**values: Any) -> Any:
        return function(**values)

    ordered = sorted(parameters, key=lambda item: item.default is not inspect.Parameter.empty)
    keywords = [item.replace(kind=inspect.Parameter.KEYWORD_ONLY) for item in ordered]
    command.__signature__ = inspect.Signature(keywords)  # pyright: ignore[reportFunctionMemberAccess]
    command.__annotations__ = {item.name: item.annotation for item in keywords}
    command.__doc__ = about
    return command


def attributes_of(kind: type) -> dict[str, str]:
    """Return what a class's docstring says of its attributes, each in one line.

    >>> attributes_of(OptionField)["low"]
    'Least value, if there is one.'
    """
    _, _, section = inspect.cleandoc(kind.__doc__ or "").partition("Attributes:\n")
    texts: dict[str, str] = {}
    name = ""
    for line in section.splitlines():
        if line and not line.startswith(" "):
            break
        found = _ITEM.fullmatch(line.removeprefix("    "))
        if found and not line.startswith("     "):
            name = found[1]
            texts[name] = found[2].strip()
        elif name and line.strip():
            texts[name] += f" {line.strip()}"
    return texts


def _fields(
    kind: type,
    inside: Mapping[str, type],
    without: frozenset[str],
    path: tuple[str, ...],
    base: Any,
) -> Iterator[OptionField]:
    hints, texts = get_type_hints(kind), attributes_of(kind)
    for item in fields(kind):
        of = inside.get(item.name, hints[item.name])
        name = item.metadata.get("option", item.name)
        if item.name in without or name is None:
            continue
        default = _default(item, base)
        if is_dataclass(of) and isinstance(of, type):
            yield from _fields(of, {}, frozenset(), (*path, item.name), default)
            continue
        _check(of, kind, item.name)
        low, high = item.metadata.get("min"), item.metadata.get("max")
        text = texts.get(item.name, "")
        yield OptionField((*path, item.name), name, of, default, text, low, high)


def _default(item: Field, base: Any) -> Any:
    if base is not REQUIRED:
        return getattr(base, item.name)
    return item.default if item.default_factory is MISSING else item.default_factory()


def _check(of: Any, kind: type, name: str) -> None:
    """Check that a type can be given on the command line."""
    if not all(_is_plain(part) for part in _parts(of)):
        message = (
            f"{kind.__name__}.{name} is of type {of}, which is no option's: numbers, texts, paths, "
            "choices and tuples of them are. Give the field metadata={'option': None} to leave it "
            "out."
        )
        raise InputError(message)


def _parts(of: Any) -> list[Any]:
    if get_origin(of) in (tuple, Union, types.UnionType):
        return [part for part in get_args(of) if part not in (Ellipsis, type(None))]
    return [of]


def _is_plain(of: Any) -> bool:
    return (
        get_origin(of) is Literal or of in _PLAIN or (isinstance(of, type) and issubclass(of, Enum))
    )


def _on_command_line(of: Any) -> Any:
    """Return the type that typer is told: of texts, where choices are numbers."""
    if get_origin(of) is Literal:
        return Literal[tuple(str(item) for item in get_args(of))]
    if get_origin(of) is tuple and Ellipsis in get_args(of):
        return list[get_args(of)[0]]
    return of
