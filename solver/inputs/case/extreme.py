"""The number of a mechanism that is farthest from ordinary ones, for messages of overflows."""

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

EXTREME = 1e75  # its fourth power is the end of the floating point range
ERRORS = (ArithmeticError, np.linalg.LinAlgError)  # to which such numbers may lead


def out_of_range(where: str, mechanism: Any) -> str:
    """Return a message that names the number; nothing if all numbers are ordinary.

    Parameters
    ----------
    where : file, or sweep
    mechanism : as plain data
    """
    key, value = max(_numbers(mechanism), key=lambda item: abs(math.log10(abs(item[1]))))
    if 1.0 / EXTREME < abs(value) < EXTREME:
        return ""
    return (
        f"{where}: {key} = {value:g}: expected numbers whose powers and products are within "
        "floating point range (1e-308 to 1e308)"
    )


def _numbers(data: Any, way: tuple[str, ...] = ()) -> Iterator[tuple[str, float]]:
    """Yield key and value of all numbers but 0."""
    if isinstance(data, dict):
        for key, value in data.items():
            yield from _numbers(value, (*way, key))
    elif isinstance(data, list | tuple):
        for i, value in enumerate(data):
            yield from _numbers(value, (*way, str(i)))
    elif isinstance(data, int | float) and not isinstance(data, bool) and data:
        yield ".".join(way), data
