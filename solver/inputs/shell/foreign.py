"""Surface meshes of other programs, read by meshio into arrays for the preprocessor.

An .npz file with `points` (n, 3), `cells` (c, 3), or (c, 4) with -1 as fourth node of a triangle,
`region` (c,) rows of `regions`, and for each named curve and point `curve:NAME` (s, 2) and
`point:NAME` (k,). Its name has the hash of its content.
"""

import hashlib
from pathlib import Path
from typing import Any

import numpy as np

from ...errors import InputError, few
from ...math.arrays import Array, IntArray
from ...package.common.temporary import temporary_sibling
from ..section.cell_sets import named_sets, region_sets
from ..section.foreign import read_mesh

BUILD = Path("build/shells")  # folder of the arrays
PLANE = {"triangle": 3, "quad": 4}


def shell_arrays(file: Path, where: str) -> tuple[Path, str]:
    """Write the arrays of a mesh; return their file and its SHA-256.

    Regions and curves are the named sets of cells and lines, points the named sets of nodes.

    Raises
    ------
    InputError : no mesh, cells of other kinds, cells in no region or in two.
    """
    mesh = read_mesh(file, where)
    blocks = [i for i, block in enumerate(mesh.cells) if block.type in PLANE]
    others = sorted({b.type for b in mesh.cells if b.dim >= 2} - set(PLANE))
    if others or not blocks:
        raise InputError(
            f"{where}: its cells are of type {', '.join(others) or 'none'}, expected triangle and "
            "quad, of degree 1, in space"
        )
    wide = max(PLANE[mesh.cells[i].type] for i in blocks)
    cells = np.concatenate([_padded(mesh.cells[i].data, wide) for i in blocks])
    regions, region = _regions(mesh, blocks, file.name, where)
    points = np.zeros((len(mesh.points), 3))
    points[:, : np.shape(mesh.points)[1]] = mesh.points
    used = np.unique(cells[cells >= 0])
    row = np.full(len(points), -1)
    row[used] = np.arange(len(used))
    arrays: dict[str, Any] = {
        "points": points[used],
        "cells": np.where(cells < 0, -1, row[np.maximum(cells, 0)]),
        "region": region,
        "regions": np.array(regions),
    }
    arrays |= {f"curve:{name}": row[lines] for name, lines in _curves(mesh).items()}
    arrays |= {f"point:{name}": row[np.asarray(n)] for name, n in mesh.point_sets.items()}
    return _written(arrays, file)


def _padded(data: Any, wide: int) -> IntArray:
    data = np.asarray(data, dtype=np.int64)
    return np.pad(data, ((0, 0), (0, wide - data.shape[1])), constant_values=-1)


def _regions(mesh: Any, blocks: list[int], name: str, where: str) -> tuple[list[str], IntArray]:
    """Names of the regions, and the region of each cell."""
    sets = region_sets(mesh, blocks, name, None)
    members = np.array(list(sets.values()))
    count = members.sum(axis=0)
    if not (count == 1).all():
        cell = int(np.flatnonzero(count != 1)[0])
        of = [of for of, mask in sets.items() if mask[cell]]
        raise InputError(
            f"{where}: cell {cell + 1} is in {count[cell]} sets ({few(of) or 'none'}), expected "
            "exactly one, its region"
        )
    return list(sets), np.asarray(members.argmax(axis=0), dtype=np.int64)


def _curves(mesh: Any) -> dict[str, IntArray]:
    lines = [i for i, block in enumerate(mesh.cells) if block.type == "line"]
    if not lines:
        return {}
    ends = np.concatenate([mesh.cells[i].data for i in lines]).astype(np.int64)
    return {name: ends[mask] for name, mask in named_sets(mesh, lines).items()}


def _written(arrays: dict[str, Array | IntArray], file: Path) -> tuple[Path, str]:
    digest = hashlib.sha256()
    for name in sorted(arrays):
        digest.update(f"{name}\0{arrays[name].dtype}{arrays[name].shape}\0".encode())
        digest.update(np.ascontiguousarray(arrays[name]).tobytes())
    content = digest.hexdigest()
    target = BUILD / f"{file.stem}-{content[:12]}.npz"
    if not target.is_file():
        BUILD.mkdir(parents=True, exist_ok=True)
        with temporary_sibling(target) as temporary, temporary.open("wb") as stream:
            np.savez(stream, **arrays)  # type: ignore[arg-type]
    return target, content
