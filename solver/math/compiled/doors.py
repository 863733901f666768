"""Calls of compiled code from Python: arguments as 8-byte words, results from them."""

import ctypes
import struct
from collections.abc import Callable
from typing import Any

import numpy as np

from . import signatures
from .structures import table_of

_LETTERS = {"f8": "d", "i8": "q", "b1": "q", "c16": "dd"}


def described(arguments: tuple[Any, ...]) -> tuple[Any, list[Any]]:
    """Return what tells the types of arguments, and their words; None if there is no word."""
    kinds: list[Any] = []
    words: list[Any] = []
    for value in arguments:
        cls = type(value)
        if cls is np.ndarray:
            kinds.append((value.dtype, value.ndim, value.flags.num))
            words.append(id(value))
        elif cls is float or cls is int or cls is bool:
            kinds.append(cls)
            words.append(value)
        elif hasattr(cls, "is_structure"):
            table = table_of(value)
            kinds.append(table.text)
            words.append(table.address)
        elif isinstance(value, float | np.floating):
            kinds.append(float)
            words.append(float(value))
        elif isinstance(value, np.bool_):
            kinds.append(bool)
            words.append(bool(value))
        elif isinstance(value, np.integer):
            kinds.append(int)
            words.append(int(value))
        elif isinstance(value, complex | np.complexfloating):
            kinds.append(complex)
            words += [value.real, value.imag]
        else:
            return None, words
    return tuple(kinds), words


def text(arguments: tuple[Any, ...]) -> str | None:
    """Return the types of arguments as text; None if compiled code cannot be given them."""
    found = []
    for value in arguments:
        if isinstance(value, np.ndarray):
            flags = value.flags
            if not (flags.aligned and value.dtype.isnative and value.dtype.kind in "fcib"):
                return None
            layout = "" if flags.c_contiguous else "A"
            writable = "" if flags.writeable else "!"
            found.append(f"{value.dtype.str[1:]}[{value.ndim}]{layout}{writable}")
        elif hasattr(type(value), "is_structure"):
            found.append(table_of(value).text)
        elif isinstance(value, bool | np.bool_):
            found.append("b1")
        elif isinstance(value, int | np.integer):
            found.append("i8")
        elif isinstance(value, float | np.floating):
            found.append("f8")
        else:
            found.append("c16")
    return "(" + ",".join(found) + ")"


def door(address: int, kinds: tuple[Any, ...], result: Any) -> Callable[..., Any]:
    """Return what calls the code at an address with words, and makes a result of its words."""
    call = ctypes.PYFUNCTYPE(None, ctypes.c_char_p, ctypes.c_void_p)(address)
    form = [_LETTERS[k.code] if isinstance(k, signatures.Number) else "q" for k in kinds]
    packed = struct.Struct("=" + "".join(form)).pack
    codes = signatures.leaves(result)
    if not codes:

        def run(words: list[Any], arguments: Any) -> None:
            call(packed(*words), None)

        return run
    back = struct.Struct("=" + "".join(_LETTERS[code] for code in codes))
    made = _maker(result)

    def run_back(words: list[Any], arguments: Any) -> Any:
        space = ctypes.create_string_buffer(back.size)
        call(packed(*words), space)
        return made(iter(back.unpack(space)))

    return run_back


def _maker(kind: Any) -> Callable[[Any], Any]:
    """Return what takes numbers from an iterator and makes a result of them."""
    if isinstance(kind, signatures.TupleOf):
        parts = [_maker(part) for part in kind.parts]
        if not kind.name:
            return lambda numbers: tuple(part(numbers) for part in parts)
        cls = signatures.class_named(kind.name)
        return lambda numbers: cls(*(part(numbers) for part in parts))
    if kind.code == "b1":
        return lambda numbers: bool(next(numbers))
    if kind.code == "c16":
        return lambda numbers: complex(next(numbers), next(numbers))
    return next
