"""Functions that are compiled: units by themselves, inlined ones with each unit that calls them.

A unit is known by a digest of its own code, what it takes in and what it runs on: two functions of
one digest are compiled to the same code, wherever their files are.
"""

import functools
import hashlib
import inspect
import marshal
import os
import sys
import warnings
from collections.abc import Callable
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from types import CodeType, ModuleType
from typing import Any, NamedTuple

import numpy as np


def digest(*texts: str | bytes) -> str:
    """Return the digest of texts, each apart from the next."""
    data = [text.encode() if isinstance(text, str) else text for text in texts]
    whole = b"".join(b"%d:%b" % (len(one), one) for one in data)
    return hashlib.sha256(whole).hexdigest()[:40]


@cache
def installed_version(name: str) -> str:
    """Return the version of a package that is installed, without importing it.

    From the name of the folder beside it: importlib.metadata takes 20 ms to import.
    """
    spec = find_spec(name)
    for package in (spec.submodule_search_locations or []) if spec else []:
        folders = list(Path(package).parent.glob(f"{name}-*.dist-info"))
        if len(folders) == 1:
            return folders[0].name.removeprefix(f"{name}-").removesuffix(".dist-info")
    import importlib.metadata

    return importlib.metadata.version(name)


def import_numba() -> Any:
    """Return Numba, imported without .numba_config.yaml of the current folder.

    Numba reads it when it is imported and before each compilation. The file could name the
    folder of Numba's cache, which holds pickles. Variables NUMBA_... of the user count. Nothing is
    done to one that a script of the user has imported before.
    """
    if "numba" in sys.modules:
        return sys.modules["numba"]
    absent = object()
    yaml = sys.modules.get("yaml", absent)
    sys.modules["yaml"] = None  # type: ignore[assignment]  # Numba then warns and does not read it
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            from numba.core import config
    finally:
        del sys.modules["yaml"]
        if yaml is not absent:
            sys.modules["yaml"] = yaml  # type: ignore[assignment]
    config._config_fname = os.devnull  # type: ignore[attr-defined]
    return sys.modules["numba"]


def content_of(function: Any) -> str:
    """Return the digest of a function: bytecode, constants, and the globals that it reads.

    Of a function compiled by itself only the name counts; one that becomes code of its callers
    counts in full.
    """
    code, known = function.__code__, function.__globals__
    read = {name: known[name] for name in sorted(_names(code) & known.keys())}
    cells = zip(code.co_freevars, function.__closure__ or (), strict=True)
    read |= {name: cell.cell_contents for name, cell in cells}
    values = [(name, _value(value, code)) for name, value in read.items()]
    whole = _code(code, function.__doc__), function.__defaults__, values
    return digest(marshal.dumps(whole, 2))  # later versions depend on what else is in memory


def _names(code: CodeType) -> set[str]:
    inner = [c for c in code.co_consts if isinstance(c, CodeType)]
    return set(code.co_names).union(*(_names(c) for c in inner))


def _code(code: CodeType, words: str | None = None) -> tuple[Any, ...]:
    """Return what code is without its place in a file and its docstring `words`."""
    constants = [_code(c) if isinstance(c, CodeType) else c for c in code.co_consts]
    if words is not None and constants[:1] == [words]:
        constants[0] = None
    names = code.co_names, code.co_varnames, code.co_freevars, code.co_cellvars
    counts = code.co_argcount, code.co_kwonlyargcount, code.co_flags
    return code.co_code, names, counts, code.co_exceptiontable, constants


_CONSTANTS = {bool, int, float, complex, str, bytes, type(None)}


def _value(value: Any, code: CodeType) -> Any:
    """Return what a global is, as far as it enters compiled code: plain data.

    Numbers and texts are themselves; all else is a list, which no constant is.
    """
    if type(value) in _CONSTANTS:
        return value
    if hasattr(value, "content_as_callee"):
        return [value.content_as_callee()]
    if isinstance(value, tuple):
        return [str(type(value)), *(_value(v, code) for v in value)]
    if isinstance(value, ModuleType):
        # not by hasattr: NumPy looks for parts of it that are not imported
        read = sorted(_names(code) & vars(value).keys())
        return [value.__name__, *((name, _value(getattr(value, name), code)) for name in read)]
    if isinstance(value, np.ndarray | np.generic):
        return [str(type(value)), value.dtype.str, value.shape, value.tobytes()]
    if isinstance(value, type):
        return ["class", value.__module__, value.__qualname__, getattr(value, "_fields", "")]
    if isinstance(getattr(value, "__code__", None), CodeType):
        return [_code(value.__code__)]
    module, name = getattr(value, "__module__", ""), getattr(value, "__name__", "")
    return [type(value).__name__, module, name]


# Sums may be reordered and products contracted; inf and nan keep their meaning.
FAST_MATH = {"reassoc", "contract", "nsz", "arcp"}


class Statistics:
    """What this process has compiled or loaded: names, once for each set of argument types."""

    def __init__(self) -> None:
        self.compiled: list[str] = []
        self.loaded: list[str] = []
        self.fallbacks: list[str] = []  # compiled by numba.njit
        self.kept = True  # the cache could be written
        self.load_s = 0.0  # CPU time for all of them


statistics = Statistics()


class Unit(NamedTuple):
    """Machine code of one part for one set of argument types, loaded."""

    part: "Part"
    arguments: str  # types, as text (entry_points.py)
    result: str
    symbol: str


class Service(NamedTuple):
    """What makes machine code of parts.

    Attributes
    ----------
    unit : returns the unit of a part for argument types
    door : returns what takes words and arguments of some kinds to compiled code
    described : returns kinds and words of arguments (entry_points.py)
    """

    unit: Callable[["Part", str], Unit]
    door: Callable[["Part", tuple[Any, ...], Any], Callable[..., Any]]
    described: Callable[[tuple[Any, ...]], tuple[Any, Any]]


_parts: dict[str, "Part"] = {}


class Part:
    """A function of numbers, arrays and structures that is compiled where it is first called.

    Called from Python it runs as compiled code if its arguments are of kinds that compiled code
    can be given, and as plain Python otherwise.

    Parameters
    ----------
    inline : it becomes code of its callers
    service : compiles and loads
    """

    def __init__(
        self, function: Callable[..., Any], *, inline: bool, service: Service | None = None
    ) -> None:
        self._service: Any = service
        self.function = self.__wrapped__ = function
        self.inline = inline
        functools.update_wrapper(self, function)
        name, count = f"{function.__module__}:{function.__qualname__}", 1
        while name in _parts:  # of functions made in a loop, say
            count += 1
            name = f"{function.__module__}:{function.__qualname__}#{count}"
        self.name = name
        _parts[name] = self
        self._units: dict[str, Unit] = {}
        self._doors: dict[Any, Any] = {}
        self._content = ""
        self.others: dict[int, Part] = {}  # of the same name, by number of arguments

    def of_count(self, count: int) -> "Part | None":
        """Return the part that takes so many arguments."""
        own = self.function.__code__.co_argcount == count
        return self if own else self.others.get(count)

    @property
    def py_func(self) -> Callable[..., Any]:
        """The function itself."""
        return self.function

    def __reduce__(self) -> str:
        return str(self.function.__qualname__)

    def __repr__(self) -> str:
        return f"<compiled {self.name}>"

    def __call__(self, *arguments: Any, **keywords: Any) -> Any:
        """Call compiled code; compile it first if need be."""
        if keywords:
            arguments = inspect.signature(self.function).bind(*arguments, **keywords).args
        kinds, words = self._service.described(arguments)
        door = self._doors.get(kinds)
        if door is None:
            door = self._doors[kinds] = self._service.door(self, arguments, kinds)
        return door(words, arguments)

    def content(self) -> str:
        """Return the digest of the function and what it takes in."""
        if not self._content:
            self._content = "recursive"
            self._content = content_of(self.function)
        return self._content

    def content_as_callee(self) -> str:
        """Return what enters the digest of callers."""
        return f"inlined {self.content()}" if self.inline else f"unit {self.name}"

    def unit(self, text: str) -> Unit:
        """Return the unit for argument types, compiled or from the cache, and loaded."""
        known_unit = self._units.get(text)
        if known_unit is None:
            known_unit = self._units[text] = self._service.unit(self, text)
        return known_unit


def part_named(name: str) -> Part | None:
    """Return a part by its name."""
    return _parts.get(name)
