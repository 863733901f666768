"""Compile the hot path with Numba where it is installed; plain NumPy otherwise.

`PLYMOTION_COMPILED=0` forces plain NumPy. The two give the same numbers to
rounding, so a result never depends on what is installed.

A `lean` function is a unit: compiled once, to object code that all its callers share. An `inlined`
one becomes code of its callers. Both take numbers, contiguous arrays, tuples of numbers and named
tuples marked as `structure`, make no arrays, and use no negative index. What is compiled is kept
under the digest of its content. README.md says what this gains and what it depends on.

Where Numba is of another version than the machinery is written for, numba.njit compiles instead.
It is slow: every function is compiled again with each one that calls it.
"""

import logging
import os
import re
import time
import warnings
from collections.abc import Callable
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from types import FunctionType
from typing import Any, TypeVar

from ..disk_cache import sources_sha256
from . import entry_points, unit_files
from .entry_points import array_head_is_known, parse, structure
from .parts import (
    FAST_MATH,
    Part,
    Service,
    Unit,
    digest,
    import_numba,
    installed_version,
    part_named,
    statistics,
)
from .unit_files import note, noted

LOGGER = logging.getLogger(__name__)
Function = TypeVar("Function", bound=Callable[..., Any])

_WANTED = os.environ.get("PLYMOTION_COMPILED", "1") != "0"
COMPILED: bool = _WANTED and find_spec("numba") is not None
SLOW = (
    "Numba is not installed: runs take about thirty times as long; expected pip install numba, or "
    "PLYMOTION_COMPILED=0 to compute without it"
)


LOWEST, NEWEST = (0, 62), (0, 68)  # versions of Numba that the tests were run with


class UnsupportedError(Exception):
    """Functions are left to numba.njit."""


def check_choice() -> None:
    """Raise UnsupportedError if the user wants numba.njit."""
    if os.environ.get("PLYMOTION_COMPILED") == "njit":
        raise UnsupportedError("PLYMOTION_COMPILED=njit")


@cache
def check_versions() -> None:
    """Raise UnsupportedError for a Numba, or arrays of NumPy, that the machinery does not know."""
    version = installed_version("numba")
    numbers = tuple(int(n) for n in re.findall(r"\d+", version)[:2])
    if not LOWEST <= numbers <= NEWEST:
        low, high = (".".join(map(str, v)) for v in (LOWEST, NEWEST))
        raise UnsupportedError(f"Numba {version}: fast compilation knows {low} to {high}")
    if not array_head_is_known():
        raise UnsupportedError("arrays of this NumPy are laid out in another way than expected")


def unit(part: Part, text: str) -> Unit:
    """Return the unit of a part for argument types, loaded."""
    return _loaded(part, text) or _compiled(part, text)


def door(part: Part, arguments: tuple[Any, ...], kinds: Any) -> Callable[..., Any]:
    """Return what takes words and arguments of such kinds to compiled code.

    Parameters
    ----------
    part : compiled function
    arguments : arguments of this call
    kinds : their types as text, read (entry_points.py)
    """
    begin = time.process_time()
    try:
        return _door(part, arguments, kinds)
    finally:
        statistics.load_s += time.process_time() - begin


def _door(part: Part, arguments: tuple[Any, ...], kinds: Any) -> Callable[..., Any]:
    text = None if kinds is None else entry_points.text(kinds)
    if text is None or len(arguments) != part.function.__code__.co_argcount:
        return lambda words, arguments: part.function(*arguments)
    try:
        check_choice()
        unit = part.unit(text)
        address = _door_address(unit)
    except Exception as error:
        return _fallback(part, error)
    return entry_points.door(address, kinds, parse(unit.result))


def _fallback(part: Part, error: Exception) -> Callable[..., Any]:
    """Return what calls the function as numba.njit compiles it."""
    statistics.fallbacks.append(part.name)
    if len(statistics.fallbacks) == 1:
        warnings.warn(
            f"{part.name}: {error}\nnumba.njit compiles it instead, which takes minutes.",
            RuntimeWarning,
            stacklevel=4,
        )
    slow = dispatcher(part, unit_files.folder())
    return lambda words, arguments: slow(*arguments)


def _key(part: Part, text: str) -> str:
    return digest(part.name, part.content(), text, unit_files.environment())


def _loaded(part: Part, text: str) -> Unit | None:
    """Load a unit from the library or its file, after what it needs; None if it is not there."""
    symbol = unit_files.symbol_of(part.name, text)
    found = unit_files.linked(symbol)
    if found is not None:
        return Unit(part, text, found.result, symbol)
    key = _key(part, text)
    file = unit_files.read(key)
    if file is None:
        return None
    description, code = file
    for name, arguments, result in description["units"]:
        needed = part_named(name)
        if needed is None or needed.unit(arguments).result != result:
            return None
    from . import linking, machine

    if not all(machine.available(symbol) for symbol in description["symbols"]):
        return None
    machine.add(code)
    linking.note_other(part, symbol, key)
    statistics.loaded.append(part.name)
    return Unit(part, text, description["result"], symbol)


def _compiled(part: Part, text: str) -> Unit:
    check_versions()
    import_numba()
    from . import building, linking, machine

    symbol, key = unit_files.symbol_of(part.name, text), _key(part, text)
    result, code, needs = building.compiled_unit(part, text, symbol)
    machine.add(code)
    statistics.compiled.append(part.name)
    statistics.kept &= unit_files.write(key, {"name": part.name, "result": result, **needs}, code)
    linking.note_other(part, symbol, key)
    return Unit(part, text, result, symbol)


def _door_address(unit: Unit) -> int:
    """Return the address of a unit's door for Python."""
    symbol = f"{unit.symbol}_door"
    if unit_files.linked(unit.symbol) and (address := unit_files.address_in_library(symbol)):
        return address
    from . import linking, machine

    key = unit_files.door_key(unit.symbol, unit.result)
    _, code = unit_files.read(key) or ({}, b"")
    if not code:
        import_numba()
        from . import building

        code = building.compiled_door(unit.arguments, unit.result, unit.symbol, symbol)
        unit_files.write(key, {"name": f"{unit.part.name} from Python"}, code)
    machine.add(code)
    linking.note_other(unit.part, unit.symbol, _key(unit.part, unit.arguments), door=True)
    return machine.address(symbol)


_KEPT_CACHES = 4
_dispatchers: dict[str, object] = {}


def dispatcher(part: Part, folder: Path | None) -> Any:
    """Return Numba's dispatcher for a part, whose callees are dispatchers as well.

    `folder` is that of our own cache; beside it there is one for Numba's.
    """
    if part.name not in _dispatchers:
        numba = _numba(folder)
        function = part.function
        known = dict(function.__globals__)
        plain: Any = FunctionType(
            function.__code__, known, function.__name__, function.__defaults__, function.__closure__
        )
        _dispatchers[part.name] = numba.njit(
            cache=bool(numba.config.CACHE_DIR),
            error_model="numpy",
            fastmath=FAST_MATH,
            forceinline=part.inline,
        )(plain)
        for name in function.__code__.co_names:
            if isinstance(known.get(name), Part):
                known[name] = dispatcher(known[name], folder)
    return _dispatchers[part.name]


def _numba(folder: Path | None) -> Any:
    """Return Numba, set up to keep code in a folder named after the content of all sources.

    Numba looks at the file of a function but not at the files of what it calls: without this, an
    edit of a callee would leave stale machine code.
    """
    # Loops are over few modes and rows: ready for vectors they are slower.
    os.environ.setdefault("NUMBA_LOOP_VECTORIZE", "0")
    numba = import_numba()

    config: Any = numba.config
    if _dispatchers or folder is None:
        return numba
    sources = sources_sha256("solver/math", "solver/dynamics", "solver/integrators")
    cache = folder.parent / f"numba-{sources[:16]}"
    try:
        cache.mkdir(mode=0o700, exist_ok=True)
    except OSError:  # compile in every process
        return numba
    config.CACHE_DIR = str(cache)
    siblings = [p for p in cache.parent.glob("numba-*") if p != cache]
    siblings.sort(key=lambda p: p.stat().st_mtime, reverse=True)
    import shutil

    for old in siblings[_KEPT_CACHES - 1 :]:
        shutil.rmtree(old, ignore_errors=True)
    return numba


@cache
def tell_if_slow() -> None:
    """Log once that Numba is missing, unless the user has chosen to compute without it."""
    if _WANTED and not COMPILED:
        LOGGER.warning("warning: %s", SLOW)


_SERVICE = Service(unit, door, entry_points.described)


def lean(function: Function) -> Function:
    """Compile `function` by itself where Numba is available."""
    return _part(function, inline=False)


jit = lean


def inlined(function: Function) -> Function:
    """Compile `function` as a part of each one that calls it: for small ones."""
    return _part(function, inline=True)


def _part(function: Any, *, inline: bool) -> Any:
    if not COMPILED:
        return function
    return Part(function, inline=inline, service=_SERVICE)


def rebound(function: Function, **names: Any) -> Function:
    """Return a plain copy of `function` in which global names mean something else.

    One source then serves a compiled loop and other functions that it may call.
    """
    plain: Any = getattr(function, "py_func", function)
    copy: Any = FunctionType(plain.__code__, plain.__globals__ | names, plain.__name__)
    copy.__doc__, copy.__defaults__ = plain.__doc__, plain.__defaults__
    return copy  # type: ignore[no-any-return]
