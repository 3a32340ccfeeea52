"""Hashes Python code and finds its imports, for checksums.

Comments, docstrings, blank lines and line breaks do not count, so that rewording and reformatting
change no checksum. The results are cached in `__pycache__` by the hash of a file's bytes, since
parsing all files would take half a second.
"""

import ast
import hashlib
import json
import re
import sys
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from importlib.metadata import PackageNotFoundError, packages_distributions, version
from pathlib import Path

from plant_bench.atomic_files import write_whole_text

_PACKAGE = Path(__file__).resolve().parent
_NAME = _PACKAGE.name
_KEPT = _PACKAGE / "__pycache__" / "source-code.json"
_FOR_TYPES = ("TYPE_CHECKING",)
_DEFINITIONS = (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)
_SPOKEN = re.compile(rf"({_NAME}(?:\.\w+)+):\w+")  # "plant_bench.a.b:Class" in a table
NUMERICAL_PACKAGES = frozenset(  # imported packages whose version may change results
    {
        "jax",
        "libsumo",
        "networkx",
        "numba",
        "numpy",
        "onnxruntime",
        "scipy",
        "shapely",
        "tensorflow",
        "torch",
    }
)
_BESIDE = re.compile(r"[\w-]+(?:\.[\w-]+)+")  # possibly a file name


@dataclass(frozen=True, slots=True)
class Source:
    """The hash and references of a Python file.

    Attributes:
        hash: Hash of the syntax tree without docstrings.
        modules: Imported names, as in `import` and `from`, relative ones with their dots; and
            modules of this package in strings such as "plant_bench.a.b:Class".
        texts: Strings that may be file names.
    """

    hash: str
    modules: tuple[str, ...]
    texts: tuple[str, ...]


def import_closure(*roots: str, without: Collection[str] = ()) -> frozenset[str]:
    """Return all modules of this package that modules import, at import time or in functions.

    Imports for type checkers do not count, nor does the package's own `__init__`, which only
    provides the public names.

    Args:
        roots: Names of modules; they are part of the closure.
        without: Modules to leave out, together with those that only they import. A name includes
            its submodules.

    >>> sorted(import_closure("plant_bench.geometry.pose"))
    ['plant_bench.geometry', 'plant_bench.geometry.pose']
    """
    found: set[str] = set()
    pending = [name for name in roots if not is_part(name, without)]
    while pending:
        name = pending.pop()
        if name in found:
            continue
        found.add(name)
        near = {*imported_modules(module_file(name)), *_parents(name)} - {_NAME}
        pending += [other for other in near if not is_part(other, without)]
    _keep()
    return frozenset(found)


def modules_below(package: str) -> list[str]:
    """Return a subpackage and all modules in it."""
    folder = module_file(package).parent
    return sorted(filter(None, map(module_name, folder.rglob("*.py"))))


def is_part(name: str, modules: Iterable[str]) -> bool:
    """Return whether a module is one of `modules`, or inside one of them."""
    return any(name == other or name.startswith(f"{other}.") for other in modules)


def imported_modules(path: Path) -> set[str]:
    """Return the modules of this package that a file imports."""
    names = {name for name in source_of(path).modules if name.partition(".")[0] == _NAME}
    return {found for name in names if (found := _module(name)) is not None}


def imported_packages(files: Iterable[Path]) -> frozenset[str]:
    """Return the top-level names of all third-party packages that Python files import."""
    modules = (name for path in files for name in source_of(path).modules)
    first = {name.partition(".")[0] for name in modules if not name.startswith(".")}
    return frozenset(first - {_NAME} - sys.stdlib_module_names)


def library_versions(packages: Iterable[str]) -> list[str]:
    """Return name and version of each installed package, sorted by name.

    Args:
        packages: Import names; those of packages that are not installed are left out.

    >>> [text.partition("==")[0] for text in library_versions(["numpy", "libsumo", "no_such"])]
    ['libsumo', 'numpy']
    """
    found = ((name, _version(name)) for name in sorted(set(packages)))
    return [f"{name}=={number}" for name, number in found if number is not None]


def _version(package: str) -> str | None:
    try:
        return version(package)
    except PackageNotFoundError:
        others = _distributions().get(package, ())
        return " ".join(sorted(version(name) for name in set(others))) or None


@cache
def _distributions() -> Mapping[str, list[str]]:
    return packages_distributions()


def data_files(module: str) -> list[Path]:
    """Return the non-Python files in a module's folder that it names in a string."""
    path = module_file(module)
    beside = [path.with_name(text) for text in source_of(path).texts]
    return sorted(file for file in beside if file.suffix != ".py" and file.is_file())


def module_file(name: str) -> Path:
    """Return the file of a module of this package.

    Raises:
        ValueError: There is none.
    """
    path = _file(name)
    if path is None:
        message = f"There is no module {name} in {_PACKAGE}."
        raise ValueError(message)
    return path


def module_name(path: Path) -> str | None:
    """Return the name of a file's module in this package; None for other files."""
    path = path.resolve()
    if path.suffix != ".py" or not path.is_relative_to(_PACKAGE):
        return None
    parts = [_NAME, *path.relative_to(_PACKAGE).with_suffix("").parts]
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def code_hash(modules: Iterable[str]) -> str:
    """Return a hash of the code of modules of this package, and of the files that they name."""
    digest = hashlib.sha256()
    for name in sorted(set(modules)):
        for path in (module_file(name), *data_files(name)):
            digest.update(f"{name} {path.name} {file_hash(path)}\n".encode())
    _keep()
    return digest.hexdigest()


def file_hash(path: Path) -> str:
    """Return a file's hash: of the code of Python files, of the bytes of others.

    Raises:
        OSError: It cannot be read.
    """
    if path.suffix == ".py":
        return source_of(path).hash
    return hashlib.sha256(path.read_bytes()).hexdigest()


def source_of(path: Path) -> Source:
    """Return the hash and references of a Python file; cached.

    Raises:
        OSError: It cannot be read.
    """
    content = path.read_bytes()
    name = hashlib.sha256(content).hexdigest()
    kept = _kept()
    if name not in kept:
        kept[name] = source_in(content)
    return kept[name]


def source_in(content: bytes) -> Source:
    """Return the hash and references of Python source; if invalid, only the hash of its bytes.

    >>> source_in(b"x = 1  # one").hash == source_in(b"x = (1)").hash
    True
    >>> source_in(b"x = 1").hash == source_in(b"x = 2").hash
    False
    """
    try:
        tree = ast.parse(content)
    except (SyntaxError, ValueError, RecursionError):
        return Source(hashlib.sha256(content).hexdigest(), (), ())
    parts: list[str] = []
    _write(tree, parts.append)
    text = "".join(parts).encode("utf-8", "surrogatepass")
    modules, texts = set(_named(tree)), set(_texts(tree))
    spoken = {found[1] for text in texts if (found := _SPOKEN.fullmatch(text))}
    files = {text for text in texts if _BESIDE.fullmatch(text)} - spoken
    return Source(
        hashlib.sha256(text).hexdigest(), tuple(sorted(modules | spoken)), tuple(sorted(files))
    )


def _write(value: object, out: Callable[[str], None]) -> None:
    """Write a syntax tree as text that is the same in all versions of Python.

    Empty fields are left out, since new versions add some.
    """
    if isinstance(value, ast.AST):
        out(f"{type(value).__name__}(")
        for name in value._fields:
            item = getattr(value, name, None)
            if name == "body" and isinstance(value, _DEFINITIONS):
                item = _without_docstring(item)
            if item is None or item == [] or name == "kind":
                continue
            out(f"{name}=")
            _write(item, out)
        out(")")
    elif isinstance(value, list):
        out("[")
        for item in value:
            _write(item, out)
        out("]")
    else:
        out(f"{value!r},")


def _without_docstring(body: list[ast.stmt] | None) -> list[ast.stmt]:
    statements = body or []
    return statements[1:] if statements and _is_text(statements[0]) else statements


def _is_text(statement: ast.stmt) -> bool:
    value = statement.value if isinstance(statement, ast.Expr) else None
    return isinstance(value, ast.Constant) and isinstance(value.value, str)


def _statements(tree: ast.AST) -> Iterator[ast.AST]:
    """Yield all nodes except docstrings and code for type checkers."""
    pending: list[ast.AST] = [tree]
    while pending:
        node = pending.pop()
        yield node
        if isinstance(node, ast.If) and ast.unparse(node.test).endswith(_FOR_TYPES):
            pending += node.orelse
        elif not (isinstance(node, ast.stmt) and _is_text(node)):
            pending += ast.iter_child_nodes(node)


def _named(tree: ast.Module) -> Iterator[str]:
    for node in _statements(tree):
        if isinstance(node, ast.Import):
            yield from (item.name for item in node.names)
        elif isinstance(node, ast.ImportFrom):
            start = "." * node.level + (node.module or "")
            gap = "." if node.module else ""
            yield start
            yield from (f"{start}{gap}{item.name}" for item in node.names)


def _texts(tree: ast.Module) -> Iterator[str]:
    for node in _statements(tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            yield node.value


def _parents(name: str) -> list[str]:
    parts = name.split(".")
    return [".".join(parts[:count]) for count in range(1, len(parts))]


@cache
def _module(name: str) -> str | None:
    """Return the module that a dotted name refers to: itself, or the one that contains it."""
    while name:
        if _file(name) is not None:
            return name
        name = name.rpartition(".")[0]
    return None


@cache
def _file(name: str) -> Path | None:
    first, *parts = name.split(".")
    path = _PACKAGE.joinpath(*parts)
    candidates = (path / "__init__.py", path.with_suffix(".py") if parts else path)
    return next((file for file in candidates if first == _NAME and file.is_file()), None)


_saved = 0  # number of files in the cache when it was last read or written


@cache
def _kept() -> dict[str, Source]:
    """Return the cache of files' hashes and references, by the hash of their bytes; mutable."""
    global _saved
    with suppress(OSError, ValueError, TypeError, KeyError):
        found = json.loads(_KEPT.read_text(encoding="utf-8"))
        if found["made by"] == _made_by():
            files = {
                name: Source(text, tuple(modules), tuple(texts))
                for name, (text, modules, texts) in found["files"].items()
            }
            _saved = len(files)
            return files
    return {}


def _keep() -> None:
    """Save the cache if it has grown and its folder is writable."""
    global _saved
    kept = _kept()
    if len(kept) <= _saved:
        return
    _saved = len(kept)
    files = {name: (item.hash, item.modules, item.texts) for name, item in kept.items()}
    with suppress(OSError):
        write_whole_text(_KEPT, json.dumps({"made by": _made_by(), "files": files}))


@cache
def _made_by() -> str:
    python = ".".join(map(str, sys.version_info[:2]))
    return f"{python} {hashlib.sha256(Path(__file__).read_bytes()).hexdigest()}"
