"""What a file of this folder supplies: a `Driver`."""

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from types import ModuleType

from ....errors import InputError
from ....math.arrays import Array
from ..problem import Options, Problem


@dataclass(frozen=True)
class Ending:
    """How an optimiser ended."""

    x: Array  # (n,)
    converged: bool
    message: str


@dataclass(frozen=True)
class Driver:
    """An optimiser of a `Problem`: fun, jac, cons, cons_jac, x0 and bounds.

    Attributes
    ----------
    name : in a case file
    meaning : one line
    minimise : begins at x0. Raises InputError without its library, with the line that installs it
    """

    name: str
    meaning: str
    minimise: Callable[[Problem, Options], Ending]


def library(name: str, extra: str) -> ModuleType:
    """Return the library of a driver. Raises InputError with the line that installs it."""
    try:
        return import_module(name)
    except ImportError as error:
        raise InputError(f"driver {extra}: needs {name} ({error}): pip install {extra}") from error
