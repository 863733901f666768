"""Digests of what a compiled function is made of: its own code, what it takes in, what it runs on.

Two functions of one digest are compiled to the same code, wherever their files are.
"""

import hashlib
import os
import platform
import sys
import warnings
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from types import CodeType, ModuleType
from typing import Any

import numpy as np

from ..digests import sources_sha256


def digest(*texts: str | bytes) -> str:
    """Return the digest of texts, each apart from the next."""
    found = hashlib.sha256()
    for text in texts:
        data = text.encode() if isinstance(text, str) else text
        found.update(str(len(data)).encode() + b":" + data)
    return found.hexdigest()[:40]


@cache
def numba_version() -> str:
    """Return the version of the Numba that is installed, without importing it.

    From the name of the folder beside it: importlib.metadata takes 20 ms to import.
    """
    spec = find_spec("numba")
    for package in (spec.submodule_search_locations or []) if spec else []:
        found = list(Path(package).parent.glob("numba-*.dist-info"))
        if len(found) == 1:
            return found[0].name.removeprefix("numba-").removesuffix(".dist-info")
    import importlib.metadata

    return importlib.metadata.version("numba")


def import_numba() -> None:
    """Import Numba without .numba_config.yaml of the current folder.

    Numba reads it when it is imported and before each compilation. The file could name the
    folder of Numba's cache, which holds pickles. Variables NUMBA_... of the user count. Nothing is
    done where a script of the user has imported Numba before.
    """
    if "numba" in sys.modules:
        return
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


@cache
def environment() -> str:
    """Return the digest of what all functions are compiled by and for."""
    import llvmlite
    import llvmlite.binding as llvm

    settings = sorted(f"{k}={v}" for k, v in os.environ.items() if k.startswith("NUMBA_"))
    return digest(
        numba_version(),
        llvmlite.__version__,
        sys.version,
        platform.machine(),
        llvm.get_default_triple(),
        llvm.get_host_cpu_name(),
        llvm.get_host_cpu_features().flatten(),
        *settings,
        sources_sha256("solver/math/compiled", apart=("solver/math/compiled/README.md",)),
    )


def content(function: Any) -> str:
    """Return the digest of a function: bytecode, constants, and the globals that it reads.

    Of a function compiled by itself only the name counts; one that becomes code of its callers
    counts in full.
    """
    code, known = function.__code__, function.__globals__
    found = [_code(code, function.__doc__), repr(function.__defaults__)]
    for name in sorted(_names(code)):
        if name in known:
            found.append(f"{name}={_value(known[name], code)}")
    for name, cell in zip(code.co_freevars, function.__closure__ or (), strict=True):
        found.append(f"{name}={_value(cell.cell_contents, code)}")
    return digest(*found)


def _names(code: CodeType) -> set[str]:
    inner = [c for c in code.co_consts if isinstance(c, CodeType)]
    return set(code.co_names).union(*(_names(c) for c in inner))


def _code(code: CodeType, words: str | None = None) -> str:
    """Digest of code without its place in a file and its docstring `words`."""
    constants = [_code(c) if isinstance(c, CodeType) else _constant(c) for c in code.co_consts]
    if words is not None and code.co_consts[:1] == (words,):
        constants[0] = ""
    return digest(
        code.co_code,
        repr((code.co_names, code.co_varnames, code.co_freevars, code.co_cellvars)),
        repr((code.co_argcount, code.co_kwonlyargcount, code.co_flags)),
        getattr(code, "co_exceptiontable", b""),
        *constants,
    )


def _constant(value: Any) -> str:
    return f"{type(value).__name__}:{value!r}"


def _value(value: Any, code: CodeType) -> str:
    """What a global is, as far as it enters compiled code."""
    if isinstance(value, ModuleType):
        read = sorted(name for name in _names(code) if hasattr(value, name))
        parts = [f"{name}={_value(getattr(value, name), code)}" for name in read]
        return digest(value.__name__, *parts)
    if isinstance(value, np.ndarray):
        return digest(value.dtype.str, repr(value.shape), np.ascontiguousarray(value).tobytes())
    if isinstance(value, np.generic | bool | int | float | complex | str | bytes | None):
        return _constant(value)
    if isinstance(value, tuple):
        return digest("tuple", type(value).__name__, *(_value(v, code) for v in value))
    if hasattr(value, "content_as_callee"):
        return str(value.content_as_callee())
    if isinstance(value, type):
        return f"class {value.__module__}.{value.__qualname__}{getattr(value, '_fields', '')}"
    if isinstance(getattr(value, "__code__", None), CodeType):
        return _code(value.__code__)
    module, name = getattr(value, "__module__", ""), getattr(value, "__name__", "")
    return f"{type(value).__name__} {module}.{name}"
