"""Functions of the user that controllers call, after the user has allowed it."""

import builtins
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any

import numpy as np

from ..dynamics.elements.forces.contract import Code
from ..dynamics.elements.forces.table import COORDINATE_FORCES
from ..errors import InputError
from ..inputs.case.expressions import is_along
from ..math.arrays import Array
from ..math.disk_cache import file_sha256

if TYPE_CHECKING:
    from ..inputs.case.tables.laws import PythonCode
    from ..inputs.case.tables.schema import Mechanism


Called = Callable[[float, Array], float]
OPTION = "--allow-python"


def require_permission(mechanism: "Mechanism") -> None:
    """Raise InputError if the mechanism has functions of the user."""
    for name, code in codes_of(mechanism).items():
        raise InputError(
            f'forces.{name}.code.file = "{code.file}": runs Python code, which can do anything '
            f"that you can; expected `plymotion run {OPTION}` if you trust it"
        )


def python_functions(mechanism: "Mechanism") -> dict[str, Called]:
    """Return the functions of the user by force, each with a memory of its own; runs their files.

    Functions of one file see the same variables of it, as do all that import a module beside it.

    Raises
    ------
    InputError
        A file that fails, or has no such function.
    """
    spaces: dict[tuple[str, str], dict[str, object]] = {}
    return {
        name: _loaded(f"forces.{name}.code", code, spaces)
        for name, code in codes_of(mechanism).items()
    }


def codes_of(mechanism: "Mechanism") -> "dict[str, PythonCode]":
    """Return the tables of the user's functions by the names of the forces that call them."""
    codes = {}
    for name, force in mechanism.forces.items():
        if is_along(force):
            for key in COORDINATE_FORCES[force.kind].keys:
                if isinstance(key, Code):
                    codes[name] = getattr(force, key.name)
    return codes


def _loaded(key: str, code: Any, spaces: dict[tuple[str, str], dict[str, object]]) -> Called:
    space = spaces.setdefault((code.file, code.source), {})
    try:
        for name, digest in code.reads.items():
            if file_sha256(Path(name)) != digest:
                raise ValueError(f"{name} was changed since the case was checked; check it again")
        if not space:
            space |= {"__name__": "user_code", "__builtins__": _builtins(code.modules, spaces)}
            exec(compile(code.source, code.file, "exec"), space)
    except Exception as error:
        raise InputError(f'{key}.file = "{code.file}": {_words(error)}') from error
    function: Any = space.get(code.function)
    memory: dict[Any, Any] = {}
    if not callable(function):
        raise InputError(f'{key}.function = "{code.function}": {code.file} has no such function')

    def called(t: float, inputs: Array) -> float:
        where = f"{key}: {code.function}() at t = {t:.6g} s"
        try:
            value = float(function(t, inputs, memory))
        except Exception as error:
            raise InputError(f"{where}: {_words(error)}") from error
        if not np.isfinite(value):
            raise InputError(f"{where} returned {value}; expected a finite number")
        return value

    return called


def _builtins(
    modules: dict[str, str], spaces: dict[tuple[str, str], dict[str, object]]
) -> dict[str, object]:
    """Return Python's own names with an import that takes these modules from their texts.

    Not from files, which may have been edited since, nor from modules that an earlier run loaded.
    """

    def load(name: str, *words: Any, **more: Any) -> object:
        if name not in modules:
            return builtins.__import__(name, *words, **more)
        space = spaces.setdefault((name, modules[name]), {})
        if not space:
            space["module"] = module = ModuleType(name)
            vars(module)["__builtins__"] = own
            exec(compile(modules[name], f"{name}.py", "exec"), vars(module))
        return space["module"]

    own = {**vars(builtins), "__import__": load}
    return own


def _words(error: Exception) -> str:
    return f"{type(error).__name__}: {error}"
