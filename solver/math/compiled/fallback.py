"""Compilation by numba.njit, where Numba is of another version than the machinery is written for.

Slow: every function is compiled again with each one that calls it.
"""

import os
import shutil
from pathlib import Path
from types import FunctionType
from typing import Any

from ..digests import sources_sha256
from .content import import_numba
from .parts import FAST_MATH, Part

_KEPT_CACHES = 4
_dispatchers: dict[str, Any] = {}


def dispatcher(part: Part, folder: Path | None) -> Any:
    """Return Numba's dispatcher for a part, whose callees are dispatchers as well.

    `folder` is that of our own cache; beside it there is one for Numba's.
    """
    if part.name not in _dispatchers:
        numba = _numba(folder)
        function = part.function
        known = dict(function.__globals__)
        plain: Any = FunctionType(
            function.__code__, known, function.__name__, function.__defaults__, function.__closure__
        )
        _dispatchers[part.name] = numba.njit(
            cache=bool(numba.config.CACHE_DIR),
            error_model="numpy",
            fastmath=FAST_MATH,
            forceinline=part.inline,
        )(plain)
        for name in function.__code__.co_names:
            if isinstance(known.get(name), Part):
                known[name] = dispatcher(known[name], folder)
    return _dispatchers[part.name]


def _numba(folder: Path | None) -> Any:
    """Return Numba, set up to keep code in a folder named after the content of all sources.

    Numba looks at the file of a function but not at the files of what it calls: without this, an
    edit of a callee would leave stale machine code.
    """
    # Loops are over few modes and rows: ready for vectors they are slower.
    os.environ.setdefault("NUMBA_LOOP_VECTORIZE", "0")
    import_numba()
    import numba

    config: Any = numba.config
    if _dispatchers or folder is None:
        return numba
    sources = sources_sha256("solver/math", "solver/dynamics", "solver/integrators")
    cache = folder.parent / f"numba-{sources[:16]}"
    try:
        cache.mkdir(mode=0o700, exist_ok=True)
    except OSError:  # compile in every process
        return numba
    config.CACHE_DIR = str(cache)
    siblings = [p for p in cache.parent.glob("numba-*") if p != cache]
    siblings.sort(key=lambda p: p.stat().st_mtime, reverse=True)
    for old in siblings[_KEPT_CACHES - 1 :]:
        shutil.rmtree(old, ignore_errors=True)
    return numba
