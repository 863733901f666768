"""Compile the hot path with Numba where it is installed; plain NumPy otherwise.

`PLYMOTION_COMPILED=0` forces plain NumPy. The two give the same numbers to
rounding, so a result never depends on what is installed.
"""

import hashlib
import os
import shutil
from collections.abc import Callable
from pathlib import Path
from types import FunctionType
from typing import Any, TypeVar

Function = TypeVar("Function", bound=Callable[..., Any])

_KEPT_CACHES = 4
# Sums may be reordered and products contracted; inf and nan keep their meaning.
_FASTMATH = {"reassoc", "contract", "nsz", "arcp"}


def _cache_directory() -> Path:
    """Return the cache folder, named after the content of all compiled sources.

    Numba looks at the file of a function but not at the files of what it
    calls: without this, an edit of a callee would leave stale machine code.
    """
    here = Path(__file__).resolve().parent.parent
    digest = hashlib.sha256()
    for source in sorted(here.rglob("*.py")):
        text = source.read_bytes()
        if any(word in text for word in (b"@jit", b"@lean", b"@inlined", b"NamedTuple")):
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
    # Loops are over few modes and rows: made ready for vectors they are slower, and take longer
    # to compile.
    os.environ.setdefault("NUMBA_LOOP_VECTORIZE", "0")
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
    # Said outright: a function would take over what its first caller is.
    return _compiled(function, _nrt=True)


def lean(function: Function) -> Function:
    """As `jit`, for a function that makes no arrays and returns none.

    Numba counts the references to an array, by one atomic addition for every row that a loop
    looks at: half of the time of an evaluation. Where no memory is needed nothing is counted;
    Numba refuses to compile where some is, also to copy arrays that might overlap.
    """
    return _compiled(function, _nrt=False)


def inlined(function: Function) -> Function:
    """As `lean`, for a part of one larger function: it becomes code of its caller.

    A call hands over every array of a model and its memory one by one, hundreds of words. What
    is called from one or two places only is spared that.
    """
    return _compiled(function, forceinline=True, _nrt=False)


def _compiled(function: Function, **options: bool) -> Function:
    if _numba is None:
        return function
    compiled: Function = _numba.njit(
        cache=bool(_numba.config.CACHE_DIR),
        error_model="numpy",
        fastmath=_FASTMATH,
        **options,
    )(function)
    return compiled


def rebound(function: Function, **names: Any) -> Function:
    """Return a plain copy of `function` in which global names mean something else.

    One source then serves a compiled loop and other functions that it may call.
    """
    plain: Any = getattr(function, "py_func", function)
    copy: Any = FunctionType(plain.__code__, plain.__globals__ | names, plain.__name__)
    copy.__doc__, copy.__defaults__ = plain.__doc__, plain.__defaults__
    return copy  # type: ignore[no-any-return]
