"""A foreign mesh as plain arrays for the preprocessor, each cell in one described region.

An .npz file with

    points        (n, 2)  x2, x3, in the unit of the source
    cells         (c, k)  rows of points, in gmsh's order of nodes
    cell_type     "triangle", "triangle6", "quad" or "quad9"
    region        (c,)    row of region_names
    region_names  (r,)    text
    lines         (m, 2 or 3)  line cells of the named curves: ends, then the middle
    curve         (m,)    row of curve_names
    curve_names   (s,)    text
"""

import hashlib
import io
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

from ...errors import InputError, few, nearest
from ...math.arrays import IntArray
from ...package.common.temporary import temporary_sibling
from .foreign import ForeignMesh


def assign_regions(mesh: ForeignMesh, names: Iterable[str], default: str | None) -> IntArray:
    """Return the region of every cell as a row of `names`, (c,); `default` comes after the last.

    Parameters
    ----------
    names : described regions, names of sets of the mesh
    default : name of the region of all other cells; None: there must be no other cell

    Raises
    ------
    InputError
        A name that the mesh does not have, cells in two regions or in none.
    """
    names = list(names)
    found = []
    region = np.full(len(mesh.cells), -1, dtype=np.int64)
    for row, name in enumerate(names):
        if name not in mesh.sets:
            found.append(
                f"regions.{name}: {mesh.file.name} has no such region{nearest(name, mesh.sets)}"
            )
            continue
        for other in np.unique(region[mesh.sets[name] & (region >= 0)]):
            both = int(np.count_nonzero(mesh.sets[name] & (region == other)))
            found.append(
                f"regions.{name}: {both} of its cells in {mesh.file.name} are in region "
                f"{names[other]} too: expected each cell in one region"
            )
        region[mesh.sets[name]] = row
    bare = region < 0
    if default is None and bare.any() and not found:
        left = [name for name, mask in mesh.sets.items() if (mask & bare).any()]
        listed = f"; they are in {few(left)}" if left else ""
        found.append(
            f"regions: {np.count_nonzero(bare)} of {bare.size} cells of {mesh.file.name} belong to "
            f"no described region{listed}: expected a table for each, or regions.all"
        )
    if found:
        raise InputError("\n".join(found))
    region[bare] = len(names)
    return region


def write_arrays(
    mesh: ForeignMesh, names: Iterable[str], region: IntArray, folder: Path
) -> tuple[Path, str]:
    """Write the arrays beside the specification; return the file and its SHA-256.

    The name contains the hash, so that equal content is written once.
    """
    rows, curve = np.nonzero(
        np.array(list(mesh.curves.values()), dtype=bool).T.reshape(
            len(mesh.lines), len(mesh.curves)
        )
    )
    return write_npz(
        folder,
        mesh.file.stem,
        points=mesh.points,
        cells=mesh.cells,
        cell_type=np.array(mesh.cell_type),
        region=region,
        region_names=np.array(list(names), dtype=str),
        lines=mesh.lines[rows],
        curve=curve,
        curve_names=np.array(list(mesh.curves), dtype=str),
    )


def write_npz(folder: Path, name: str, **arrays: Any) -> tuple[Path, str]:
    """Write named arrays to a file whose name ends in its hash; return file and SHA-256."""
    buffer = io.BytesIO()
    np.savez(buffer, **arrays)
    content = buffer.getvalue()
    digest = hashlib.sha256(content).hexdigest()
    file = folder / f"{name}-{digest[:12]}.npz"
    if not file.is_file():
        folder.mkdir(parents=True, exist_ok=True)
        with temporary_sibling(file) as temporary:
            temporary.write_bytes(content)
    return file, digest
