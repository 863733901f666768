"""Meshes of users: scripts that make them, which may be refused, and nodes at the same place."""

import contextlib
import importlib.util
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import numpy as np

from ..solver.math.arrays import Array, IntArray

SUFFIXES = (".geo", ".py")
_refused = False  # of the process: its threads build sections, too


@contextlib.contextmanager
def scripts(*, refused: bool) -> Iterator[None]:
    """Refuse mesh scripts of the user inside, or run them; those of the library always run."""
    global _refused
    before, _refused = _refused, refused
    try:
        yield
    finally:
        _refused = before


def is_ours(path: Path) -> bool:
    """Tell whether a file is one of the library."""
    return Path(__file__).resolve().parents[1] / "meshes" in path.resolve().parents


def is_refused(path: Path) -> bool:
    """Tell whether a file of the user is a script, and those are refused."""
    return _refused and path.suffix in SUFFIXES and not is_ours(path)


def load_script(path: Path) -> ModuleType:
    """Import a file by its path."""
    spec = importlib.util.spec_from_file_location(f"plymotion_script_{path.stem}", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


# Along this direction the nodes of a regular grid are apart.
DIRECTION = np.sqrt([2.0, 3.0, 5.0])


def coincident(points: Array, distance: float) -> IntArray:
    """Pairs of points that are not farther apart than a distance, (p, 2), rising.

    Points as near as this are neighbours in their order along any direction, so few are compared.

    Parameters
    ----------
    points : (n, 2 or 3) [m]
    distance : small against those between most of the points [m]
    """
    direction = DIRECTION[: points.shape[1]]
    along = points @ (direction / np.linalg.norm(direction))
    order = np.argsort(along)
    along, near = along[order], [np.zeros((0, 2), dtype=np.int64)]
    slack = distance + 1e-15 * float(np.abs(along).max(initial=0.0))
    for step in range(1, len(points)):
        first = np.flatnonzero(along[step:] - along[:-step] <= slack)
        if not first.size:
            break
        pairs = np.sort(order[np.stack([first, first + step], axis=1)], axis=1)
        apart = np.linalg.norm(points[pairs[:, 0]] - points[pairs[:, 1]], axis=1)
        near.append(pairs[apart <= distance])
    every = np.concatenate(near)
    return every[np.lexsort(every.T[::-1])]
