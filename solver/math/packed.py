"""Columns of numbers as text: base64 of float64, little-endian, 11 characters a number.

Lists of numbers take 50 bytes each in memory; tables of millions of rows are kept like this.
"""

import base64
import binascii
from collections.abc import Sequence

import numpy as np

from .arrays import Array

PREFIX = "float64:"


class Packed(str):
    """A packed column, made here and not by a user."""

    __slots__ = ()


def packed(values: Array) -> Packed:
    """Return a column (k,) as text."""
    data = base64.b64encode(np.ascontiguousarray(values, dtype="<f8").tobytes())
    return Packed(PREFIX + data.decode("ascii"))


def column(values: Sequence[float] | str | None) -> Array:
    """Return the numbers of a column (k,); none of a column that is not given.

    Raises ValueError : text that is no packed column.
    """
    if not isinstance(values, str):
        return np.asarray([] if values is None else values, dtype=float)
    try:
        data = base64.b64decode(values.removeprefix(PREFIX), validate=True)
        return np.frombuffer(data, dtype="<f8")
    except (binascii.Error, ValueError) as error:
        raise ValueError(f"expected numbers, or a packed column ({error})") from error
