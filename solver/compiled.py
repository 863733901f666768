"""Compile the hot path with Numba where it is installed; plain NumPy otherwise.

`PLYMOTION_COMPILED=0` forces plain NumPy. The two give the same numbers to
rounding, so a result never depends on what is installed.
"""

import hashlib
import os
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

Function = TypeVar("Function", bound=Callable[..., Any])

_KEPT_CACHES = 4


def _cache_directory() -> Path:
    """Return the cache folder, named after the content of all compiled sources.

    Numba looks at the file of a function but not at the files of what it
    calls: without this, an edit of a callee would leave stale machine code.
    """
    here = Path(__file__).resolve().parent
    digest = hashlib.sha256()
    for source in sorted(here.rglob("*.py")):
        text = source.read_bytes()
        if b"@jit" in text or b"NamedTuple" in text:
            digest.update(source.relative_to(here).as_posix().encode())
            digest.update(text)
    base = Path(os.environ.get("PLYMOTION_CACHE", Path.home() / ".cache" / "plymotion"))
    return base / f"numba-{digest.hexdigest()[:16]}"


def _drop_old_caches(current: Path) -> None:
    """Keep the newest few caches, so that edits do not fill the disk."""
    siblings = [p for p in current.parent.glob("numba-*") if p != current]
    siblings.sort(key=lambda p: p.stat().st_mtime, reverse=True)
    for old in siblings[_KEPT_CACHES - 1 :]:
        shutil.rmtree(old, ignore_errors=True)


def _find_numba() -> Any:
    if os.environ.get("PLYMOTION_COMPILED", "1") == "0":
        return None
    # Level 3 takes half as long again to compile this code and gains nothing at run time.
    os.environ.setdefault("NUMBA_OPT", "1")
    try:
        import numba
    except ImportError:
        return None
    config: Any = numba.config
    cache = _cache_directory()
    try:
        cache.mkdir(parents=True, exist_ok=True)
        _drop_old_caches(cache)
        config.CACHE_DIR = str(cache)
    except OSError:  # no writable home: compile anew in every process
        config.CACHE_DIR = ""
    return numba


_numba = _find_numba()
COMPILED: bool = _numba is not None


def jit(function: Function) -> Function:
    """Compile `function` (a pure function of arrays) where Numba is available."""
    if _numba is None:
        return function
    compiled: Function = _numba.njit(cache=bool(_numba.config.CACHE_DIR))(function)
    return compiled
