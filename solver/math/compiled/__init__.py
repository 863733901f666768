"""Compile the hot path with Numba where it is installed; plain NumPy otherwise.

`PLYMOTION_COMPILED=0` forces plain NumPy. The two give the same numbers to
rounding, so a result never depends on what is installed.

A `lean` function is a unit: compiled once, to object code that all its callers share. An `inlined`
one becomes code of its callers. Both take numbers, contiguous arrays, tuples of numbers and named
tuples marked as `structure`, make no arrays, and use no negative index. What is compiled is kept
under the digest of its content. README.md says what this gains and what it depends on.
"""

import logging
import os
from collections.abc import Callable
from functools import cache
from importlib.util import find_spec
from types import FunctionType
from typing import Any, TypeVar

from . import units
from .doors import structure
from .parts import Part, numba_version, statistics
from .units import note, noted

__all__ = [
    "COMPILED",
    "inlined",
    "jit",
    "lean",
    "note",
    "noted",
    "numba_version",
    "rebound",
    "statistics",
    "structure",
    "tell_if_slow",
]

LOGGER = logging.getLogger(__name__)
Function = TypeVar("Function", bound=Callable[..., Any])

_WANTED = os.environ.get("PLYMOTION_COMPILED", "1") != "0"
COMPILED: bool = _WANTED and find_spec("numba") is not None
SLOW = (
    "Numba is not installed: runs take about thirty times as long; expected pip install numba, or "
    "PLYMOTION_COMPILED=0 to compute without it"
)


@cache
def tell_if_slow() -> None:
    """Log once that Numba is missing, unless the user has chosen to compute without it."""
    if _WANTED and not COMPILED:
        LOGGER.warning("warning: %s", SLOW)


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
    return Part(function, inline=inline, service=units)


def rebound(function: Function, **names: Any) -> Function:
    """Return a plain copy of `function` in which global names mean something else.

    One source then serves a compiled loop and other functions that it may call.
    """
    plain: Any = getattr(function, "py_func", function)
    copy: Any = FunctionType(plain.__code__, plain.__globals__ | names, plain.__name__)
    copy.__doc__, copy.__defaults__ = plain.__doc__, plain.__defaults__
    return copy  # type: ignore[no-any-return]
