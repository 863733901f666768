"""Finer meshes of a shell: more cells from its script, or each cell split in four."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from ....solver.math.arrays import IntArray
from ....solver.package.common.cells import NONE
from ...fenicsx import PlainMesh
from .edges import Edges

COUNT = "n_"  # scripts of meshes/shells: parameters that count the cells of a direction


def finer_parameters(
    script: ModuleType, parameters: Mapping[str, Any], times: int
) -> dict[str, Any] | None:
    """Parameters with twice as many cells in each direction, `times` times.

    None for a script that is not of this library: its parameters may count other things. Nodes of
    a script lie on the surface that it describes; those of split cells lie between its nodes.
    """
    if not is_ours(script):
        return None
    counts = {key: n for key, n in script.DEFAULTS.items() if key.startswith(COUNT)}
    counts |= {key: n for key, n in parameters.items() if key in counts}
    if not all(isinstance(n, int | float) for n in counts.values()):
        return dict(parameters)  # the script says what is wrong
    return {**parameters, **{key: n * 2**times for key, n in counts.items()}}


def is_ours(script: ModuleType) -> bool:
    """Whether a script is one of meshes/shells."""
    ours = Path(__file__).resolve().parents[3] / "meshes" / "shells"
    return Path(str(script.__file__)).resolve().parent == ours


def split(plain: PlainMesh) -> PlainMesh:
    """The mesh with each cell in four: at the middles of its sides, quadrilaterals at a centre.

    New nodes lie on the straight sides of the old cells. Cells keep their sense and region, four
    after four; curves get the middles of their segments, and physical points stay.

    Parameters
    ----------
    plain : cells of degree 1
    """
    cells, n = plain.cells, len(plain.points)
    there = cells != NONE
    edges = Edges(cells)
    middles = np.full(cells.shape, NONE)
    middles[there] = n + edges.number
    points = [plain.points, plain.points[edges.nodes].mean(axis=1)]
    parts = np.full((len(cells), 4, cells.shape[1]), NONE)
    quads = there.all(axis=1) & (cells.shape[1] == 4)
    # triangles: a corner and the middles beside it, and the triangle between the middles
    c, m = cells[~quads, :3].T, middles[~quads, :3].T
    for part, corners in enumerate(
        [(c[0], m[0], m[2]), (m[0], c[1], m[1]), (m[2], m[1], c[2]), (m[0], m[1], m[2])]
    ):
        parts[~quads, part, :3] = np.stack(corners, axis=1)
    if quads.any():
        centre = n + len(edges.nodes) + np.arange(int(quads.sum()))
        points.append(plain.points[cells[quads]].mean(axis=1))
        c, m = cells[quads].T, middles[quads].T
        for part in range(4):
            around = np.stack([c[part], m[part], centre, m[part - 1]], axis=1)
            parts[quads, part] = np.roll(around, part, axis=1)
    new = np.concatenate(points)
    named = plain.named
    if named is not None:
        tags = np.concatenate([named.tags, named.tags.max() + 1 + np.arange(len(new) - n)])
        curves = {name: _halves(rows, edges, n) for name, rows in named.curves.items()}
        named = named._replace(tags=tags, curves=curves)
    return replace(
        plain,
        points=new,
        cells=parts.reshape(-1, cells.shape[1]),
        region=np.repeat(plain.region, 4),
        curves={},
        named=named,
    )


def _halves(curve: IntArray, edges: Edges, n: int) -> IntArray:
    """Segments (s, 2) of a curve in halves; those that are no side of a cell stay whole."""
    row = edges.find(curve)
    middle = np.where(row < 0, curve[:, 1], n + row)
    halves = np.stack([curve[:, 0], middle, middle, curve[:, 1]], axis=1).reshape(-1, 2, 2)
    return np.asarray(halves[np.stack([row >= -1, row >= 0], axis=1)])
