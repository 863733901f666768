"""The head of array objects in memory, as compiled code reads it (ndarrayobject.h of NumPy)."""

import ctypes
from functools import cache
from typing import Any

import numpy as np

_DATA = 16  # bytes from the beginning of the object to the address of the data


@cache
def usable() -> bool:
    """Tell whether array objects begin as compiled code expects."""
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
    if usable():
        return ctypes.c_uint64.from_address(id(array) + _DATA).value
    return array.__array_interface__["data"][0]  # type: ignore[no-any-return]
