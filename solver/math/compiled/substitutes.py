"""Functions that take the place of Numba's own inside parts.

Numba compiles its own separately, links them with every caller, and its powers of integers raise
an error where zero is divided by.
"""

from typing import Any

from .parts import Part


def _lesser(a: Any, b: Any) -> Any:
    return b if b < a else a


def _least(a: Any, b: Any, c: Any) -> Any:
    return min(min(a, b), c)


def _larger(a: Any, b: Any) -> Any:
    return b if b > a else a


def _largest(a: Any, b: Any, c: Any) -> Any:
    return max(max(a, b), c)


def _power(base: Any, exponent: Any) -> Any:
    n, square, found = exponent if exponent > 0 else -exponent, base, 1.0
    while n != 0:
        if n & 1:
            found *= square
        n >>= 1
        square *= square
    return found if exponent >= 0 else 1.0 / found


BUILTINS = {"min": Part(_lesser, inline=True), "max": Part(_larger, inline=True)}
BUILTINS["min"].others[3] = Part(_least, inline=True)
BUILTINS["max"].others[3] = Part(_largest, inline=True)
POWER = Part(_power, inline=True)
