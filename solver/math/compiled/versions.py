"""Which versions of Numba the machinery is written for and tested with, and how it is imported."""

import os
import re
import sys
import warnings
from functools import cache
from importlib.util import find_spec
from pathlib import Path

LOWEST, NEWEST = (0, 62), (0, 68)


class UnsupportedError(Exception):
    """Functions are left to numba.njit."""


def check_choice() -> None:
    """Raise UnsupportedError if the user wants numba.njit."""
    if os.environ.get("PLYMOTION_COMPILED") == "njit":
        raise UnsupportedError("PLYMOTION_COMPILED=njit")


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


@cache
def check_versions() -> None:
    """Raise UnsupportedError for a Numba, or arrays of NumPy, that the machinery does not know."""
    from .array_head import usable

    version = numba_version()
    numbers = tuple(int(n) for n in re.findall(r"\d+", version)[:2])
    if not LOWEST <= numbers <= NEWEST:
        low, high = (".".join(map(str, v)) for v in (LOWEST, NEWEST))
        raise UnsupportedError(f"Numba {version}: fast compilation knows {low} to {high}")
    if not usable():
        raise UnsupportedError("arrays of this NumPy are laid out in another way than expected")


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
