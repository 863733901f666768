"""Which versions of Numba the machinery is written for and tested with."""

import importlib.metadata
import os
import re
from functools import cache

LOWEST, NEWEST = (0, 62), (0, 68)


class UnsupportedError(Exception):
    """Functions are left to numba.njit."""


def check_choice() -> None:
    """Raise UnsupportedError if the user wants numba.njit."""
    if os.environ.get("PLYMOTION_COMPILED") == "njit":
        raise UnsupportedError("PLYMOTION_COMPILED=njit")


@cache
def check_versions() -> None:
    """Raise UnsupportedError for a Numba, or arrays of NumPy, that the machinery does not know."""
    from .doors import usable

    version = importlib.metadata.version("numba")
    numbers = tuple(int(n) for n in re.findall(r"\d+", version)[:2])
    if not LOWEST <= numbers <= NEWEST:
        low, high = (".".join(map(str, v)) for v in (LOWEST, NEWEST))
        raise UnsupportedError(f"Numba {version}: fast compilation knows {low} to {high}")
    if not usable():
        raise UnsupportedError("arrays of this NumPy are laid out in another way than expected")
