"""Draw the figures of a report: those out of date only, two or more at a time."""

import hashlib
import importlib.metadata
import json
import multiprocessing
import sys
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

from ..interrupts import ignore, shielded
from ..math.cores import cores
from ..math.digests import sources_sha256
from ..package.common.temporary import write_text
from .style import house_style

KEYS = "figures.json"  # digest of what each figure was drawn from, by path
FEW = 3  # figures that do not pay for a second process


class Drawing(NamedTuple):
    """A figure to draw: `draw(path, *arguments)`."""

    path: Path
    draw: Callable[..., Path]
    arguments: tuple[Any, ...]
    content: str  # digest of the data that it shows


def draw_all(folder: Path, drawings: Sequence[Drawing]) -> None:
    """Draw figures whose data, titles or sources have changed, or that are missing.

    On as many processes as there are cores. `folder` keeps the digests.
    """
    before = _keys(folder / KEYS)
    now = {str(d.path.relative_to(folder)): _key(d) for d in drawings}
    stale = [
        d
        for d, (name, key) in zip(drawings, now.items(), strict=True)
        if before.get(name) != key or not _there(d.path)
    ]
    if stale:
        with house_style():  # also tells that matplotlib is missing
            count = min(cores(), len(stale)) if len(stale) > FEW else 1
            if count > 1:
                with ProcessPoolExecutor(count, _context(), ignore) as pool:
                    try:
                        with shielded():  # processes start in `map`
                            drawn = pool.map(_draw, stale)
                        for _ in drawn:
                            pass
                    finally:  # after a signal the others are not begun
                        pool.shutdown(cancel_futures=True)
            else:
                for drawing in stale:
                    _draw(drawing)
    _write_keys(folder / KEYS, now)


def drawn_before(folder: Path) -> bool:
    """Tell whether a folder has figures that draw_all has left there."""
    return any((folder / name).is_file() for name in _keys(folder / KEYS) if name.endswith(".png"))


def is_up_to_date(folder: Path, page: str, key: str) -> bool:
    """Tell whether a page and all figures were made from data of this digest, and are there."""
    known = _keys(folder / KEYS)
    return known.get(page) == key and all(_there(folder / name) for name in known)


def _there(file: Path) -> bool:
    """Tell whether there is a file; a full disk or a lost machine may leave an empty one."""
    return file.is_file() and file.stat().st_size > 0


def remember(folder: Path, page: str, key: str) -> None:
    """Keep the digest of a page that was made after its figures."""
    _write_keys(folder / KEYS, _keys(folder / KEYS) | {page: key})


def _write_keys(file: Path, keys: dict[str, str]) -> None:
    write_text(file, json.dumps(keys, indent=1) + "\n")


def _draw(drawing: Drawing) -> None:
    with house_style():
        drawing.draw(drawing.path, *drawing.arguments)


def _context() -> Any:
    """A copy of this process has matplotlib and the data already."""
    return multiprocessing.get_context("fork" if sys.platform == "linux" else "spawn")


def _keys(file: Path) -> dict[str, str]:
    try:
        found = json.loads(file.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return found if isinstance(found, dict) else {}


def _key(drawing: Drawing) -> str:
    """Digest of a figure's data, of the code that draws it and of matplotlib's version."""
    found = hashlib.sha256(drawing.content.encode())
    found.update(drawing.draw.__name__.encode())
    found.update(version().encode())
    found.update(sources_sha256("solver/report").encode())
    return found.hexdigest()


@cache
def version() -> str:
    """Version of matplotlib; none without it."""
    try:
        return importlib.metadata.version("matplotlib")
    except importlib.metadata.PackageNotFoundError:
        return ""
