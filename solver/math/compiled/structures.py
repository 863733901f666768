"""Named tuples that compiled code sees as one pointer.

The pointer leads to a table of 8-byte words: address and lengths of each array, the value of each
number, the words of a structure inside. Compiled code loads what it needs and is spared the
hundreds of words that the arrays of a model and its memory take. Python sees the tuple.
"""

import ctypes
from functools import cache
from typing import Any, NamedTuple, TypeVar

import numpy as np

Class = TypeVar("Class", bound=type)

_NUMBERS = {int: "i8", float: "f8", bool: "b1"}
_PLAIN = 0x101  # flags of arrays: contiguous, aligned
_DATA = 16  # bytes from the beginning of an array object to the address of its data
_PACKED = {"i8": np.int64, "b1": np.int64, "f8": np.float64}


class Table(NamedTuple):
    """The words of one structure, and the text that says what they are (signatures.py)."""

    text: str
    words: Any  # (n,) int64
    address: int


def structure(cls: Class) -> Class:
    """Mark a NamedTuple of contiguous arrays, numbers and structures: compiled, one pointer.

    Its arrays may be filled, and never change their place or length.
    """

    class Structure(cls):  # type: ignore[valid-type, misc]
        is_structure = True

        def __getstate__(self) -> None:
            """Leave the table behind: addresses mean nothing to a copy."""

    for name in ("__name__", "__qualname__", "__module__", "__doc__"):
        setattr(Structure, name, getattr(cls, name))
    Structure.__annotations__ = dict(cls.__annotations__)
    return Structure  # type: ignore[return-value]


def table_of(value: Any) -> Table:
    """Return the table of a structure, which lives as long as the tuple.

    Raises TypeError : a field that compiled code cannot be given
    """
    found = value.__dict__.get("_table")
    if found is None:
        words: list[int] = []
        text = _describe(value, words)
        array = np.array(words, dtype=np.uint64).view(np.int64)
        found = value.__dict__["_table"] = Table(text, array, array.ctypes.data)
    return found  # type: ignore[no-any-return]


@cache
def _text_of(dtype: np.dtype[Any], ndim: int) -> str:
    """Return what an array is; nothing if its numbers are not in the order of this machine."""
    return f"{dtype.str[1:]}[{ndim}]" if dtype.isnative else ""


def _describe(value: Any, words: list[int]) -> str:
    """Append the words of a structure; return its text."""
    cls = type(value)
    fields = []
    for name, field in zip(cls._fields, value, strict=True):
        if isinstance(field, np.ndarray):
            text = _text_of(field.dtype, field.ndim)
            if field.flags.num & _PLAIN != _PLAIN or not text:
                raise TypeError(f"{cls.__name__}.{name}: expected a contiguous array")
            words.append(address_of(field))
            words.extend(field.shape)
        elif hasattr(field, "is_structure"):  # models that differ in numbers share most of theirs
            table = table_of(field)
            text = table.text
            words.extend(table.words.view(np.uint64).tolist())
        else:
            text = _NUMBERS.get(cls.__annotations__[name], "")
            if not text:
                raise TypeError(f"{cls.__name__}.{name}: expected an array, a number, a structure")
            words.append(int(np.array(field, dtype=_PACKED[text]).view(np.uint64)))
        fields.append(f"{name}={text}")
    return "{" + cls.__name__ + ":" + ",".join(fields) + "}"


@cache
def array_head_is_known() -> bool:
    """Tell whether array objects begin as compiled code expects (ndarrayobject.h of NumPy)."""
    array = np.zeros((2, 3))[:, ::2]
    if tuple.__itemsize__ != 8 or not hasattr(ctypes, "PYFUNCTYPE"):
        return False
    head = (ctypes.c_int64 * 6).from_address(id(array))
    if head[2] != array.ctypes.data or ctypes.c_int32.from_address(id(array) + 24).value != 2:
        return False
    lengths = (ctypes.c_int64 * 2).from_address(head[4])
    strides = (ctypes.c_int64 * 2).from_address(head[5])
    return tuple(lengths) == array.shape and tuple(strides) == array.strides


def address_of(array: np.ndarray[Any, Any]) -> int:
    """Return the address of the data; the way of NumPy takes four times as long."""
    if array_head_is_known():
        return ctypes.c_uint64.from_address(id(array) + _DATA).value
    return array.__array_interface__["data"][0]  # type: ignore[no-any-return]
