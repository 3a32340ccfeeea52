"""Derives command-line options from the fields of dataclasses.

An option has the name, type and default of its field, and the field's entry under "Attributes:" of
the docstring as its help. A field's `metadata` may hold "min", "max", and "option": another name,
or None for no option. The fields of nested dataclasses become options as well; the nested field's
"ranges" may hold minimum and maximum by the name of a field in it. All numbers must be finite.
"""

import inspect
import re
import types
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import MISSING, Field, dataclass, fields, is_dataclass
from enum import Enum
from pathlib import Path
from types import MappingProxyType
from typing import Annotated, Any, Literal, Union, get_args, get_origin, get_type_hints

import typer

from plant_bench.cli.number_options import number_check
from plant_bench.errors import InputError

_SCALAR_TYPES = (bool, int, float, str, Path)
_ATTRIBUTE = re.compile(r"(\w+): (.*)")
REQUIRED: Any = MISSING


@dataclass(frozen=True)
class OptionField:
    """A command-line option derived from a field of a dataclass.

    Attributes:
        path: Field names, from the outermost dataclass to the field.
        name: Name of the option, with underscores.
        kind: Type of the field.
        default: Default value; `REQUIRED` if there is none.
        help: Help text, one or more sentences.
        low: Minimum, if there is one.
        high: Maximum, if there is one.
    """

    path: tuple[str, ...]
    name: str
    kind: Any
    default: Any
    help: str
    low: int | float | None = None
    high: int | float | None = None

    def parameter(self, *, optional: bool = False) -> inspect.Parameter:
        """Return the function parameter from which typer makes the option.

        Args:
            optional: Make the default None, which means that the option was not passed.
        """
        cli_type = _command_line_type(self.kind)
        check = number_check(self.low, self.high) if _has_number(self.kind) else None
        ranged = get_origin(self.kind) is not tuple
        option = typer.Option(
            help=self.help,
            min=self.low if ranged else None,
            max=self.high if ranged else None,
            callback=check,
        )
        return inspect.Parameter(
            self.name,
            inspect.Parameter.KEYWORD_ONLY,
            default=None if optional else self._command_line_default(),
            annotation=Annotated[cli_type | None if optional else cli_type, option],
        )

    def _command_line_default(self) -> Any:
        if self.default is REQUIRED:
            return inspect.Parameter.empty
        if get_origin(self.kind) is Literal:
            return str(self.default)
        return self.default

    def value(self, argument: Any) -> Any:
        """Convert an argument of the command line to the field's type."""
        if argument is None:
            return None
        if get_origin(self.kind) is Literal:
            return next(item for item in get_args(self.kind) if str(item) == str(argument))
        if get_origin(self.kind) is tuple:
            return tuple(argument)
        return argument


def option_fields(
    kind: type,
    *,
    inside: Mapping[str, type] | None = None,
    without: frozenset[str] = frozenset(),
) -> list[OptionField]:
    """Return the options of a dataclass.

    Args:
        kind: The dataclass.
        inside: Types of fields that are annotated as `Any`, by field name.
        without: Names of fields that get no option.

    Raises:
        InputError: A field's type cannot be an option, or two options have the same name.
    """
    options = list(_fields(kind, inside or {}, without, (), REQUIRED))
    names = [item.name for item in options]
    duplicates = sorted({name for name in names if names.count(name) > 1})
    if duplicates:
        message = (
            f"Duplicate options: {', '.join(duplicates)}. Rename the fields, or set "
            'metadata={"option": "another_name"}.'
        )
        raise InputError(message)
    return options


def build_dataclass(kind: type, values: Mapping[tuple[str, ...], Any], base: Any = REQUIRED) -> Any:
    """Build an instance of a dataclass from field values.

    Args:
        kind: The dataclass.
        values: Field values by field path; missing fields are taken from `base`.
        base: Instance that supplies the missing values. Default: the fields' defaults.
    """
    arguments: dict[str, Any] = {}
    for item in fields(kind):
        inner = {path[1:]: value for path, value in values.items() if path[0] == item.name}
        if () in inner:
            arguments[item.name] = inner[()]
            continue
        default = _default(item, base)
        if inner:
            inner_kind = (
                type(default) if default is not REQUIRED else get_type_hints(kind)[item.name]
            )
            arguments[item.name] = build_dataclass(inner_kind, inner, default)
        elif default is not REQUIRED:
            arguments[item.name] = default
    return kind(**arguments)


def with_options(
    function: Callable[..., Any], parameters: Sequence[inspect.Parameter], description: str
) -> Callable[..., Any]:
    """Wrap a keyword function so that typer sees the given parameters and description."""

    def command(**values: Any) -> Any:
        return function(**values)

    ordered = sorted(parameters, key=lambda item: item.default is not inspect.Parameter.empty)
    keywords = [item.replace(kind=inspect.Parameter.KEYWORD_ONLY) for item in ordered]
    command.__signature__ = inspect.Signature(keywords)  # pyright: ignore[reportFunctionMemberAccess]
    command.__annotations__ = {item.name: item.annotation for item in keywords}
    command.__doc__ = description
    return command


def attributes_of(kind: type) -> dict[str, str]:
    """Return the attribute descriptions of a class's docstring, each joined to one line.

    >>> attributes_of(OptionField)["low"]
    'Minimum, if there is one.'
    """
    _, _, section = inspect.cleandoc(kind.__doc__ or "").partition("Attributes:\n")
    texts: dict[str, str] = {}
    name = ""
    for line in section.splitlines():
        if line and not line.startswith(" "):
            break
        match = _ATTRIBUTE.fullmatch(line.removeprefix("    "))
        if match and not line.startswith("     "):
            name = match[1]
            texts[name] = match[2].strip()
        elif name and line.strip():
            texts[name] += f" {line.strip()}"
    return texts


def _fields(
    kind: type,
    inside: Mapping[str, type],
    without: frozenset[str],
    path: tuple[str, ...],
    base: Any,
    ranges: Mapping[str, tuple[int | float, int | float]] = MappingProxyType({}),
) -> Iterator[OptionField]:
    hints, texts = get_type_hints(kind), attributes_of(kind)
    for item in fields(kind):
        of = inside.get(item.name, hints[item.name])
        name = item.metadata.get("option", item.name)
        if item.name in without or name is None:
            continue
        default = _default(item, base)
        if is_dataclass(of) and isinstance(of, type):
            inner = {**ranges, **item.metadata.get("ranges", {})}
            yield from _fields(of, {}, frozenset(), (*path, item.name), default, inner)
            continue
        _check(of, kind, item.name)
        low, high = ranges.get(item.name, (item.metadata.get("min"), item.metadata.get("max")))
        text = texts.get(item.name, "")
        yield OptionField((*path, item.name), name, of, default, text, low, high)


def _default(item: Field, base: Any) -> Any:
    if base is not REQUIRED:
        return getattr(base, item.name)
    return item.default if item.default_factory is MISSING else item.default_factory()


def _check(of: Any, kind: type, name: str) -> None:
    """Check that an option can have this type."""
    if not all(_is_scalar(part) for part in _parts(of)):
        message = (
            f"{kind.__name__}.{name} has type {of}: expected a number, text, path, choice or a "
            "tuple of these. To give the field no option, set metadata={'option': None}."
        )
        raise InputError(message)


def _parts(of: Any) -> list[Any]:
    if get_origin(of) in (tuple, Union, types.UnionType):
        return [part for part in get_args(of) if part not in (Ellipsis, type(None))]
    return [of]


def _has_number(of: Any) -> bool:
    return any(part in (int, float) for part in _parts(of))


def _is_scalar(of: Any) -> bool:
    return (
        get_origin(of) is Literal
        or of in _SCALAR_TYPES
        or (isinstance(of, type) and issubclass(of, Enum))
    )


def _command_line_type(of: Any) -> Any:
    """Return the type for typer: choices as text, since typer does not support other choices."""
    if get_origin(of) is Literal:
        return Literal[tuple(str(item) for item in get_args(of))]
    if get_origin(of) is tuple and Ellipsis in get_args(of):
        return list[get_args(of)[0]]
    return of
