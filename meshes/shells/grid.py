"""Structured triangles on mapped rectangles, and their way into gmsh's current model.

A `Grid` is a rectangle of (n_u + 1) x (n_v + 1) nodes; each of its cells is cut into two triangles
whose normal is d/du x d/dv. Nodes of several grids that lie at one place become one. The scripts
beside this file give grids, physical curves and physical points of one shape each.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]

ONE_WAY, ALTERNATING, OTHER_WAY = 0, 1, 2  # parameter `diagonals`


class Grid(NamedTuple):
    """Nodes of one mapped rectangle."""

    region: str
    places: Array  # (n_u + 1, n_v + 1, 3) [m]
    diagonals: int  # ONE_WAY: from (0, 0) to (1, 1) of each cell; ALTERNATING; OTHER_WAY


def mapped(
    region: str,
    place: Callable[[Array, Array], tuple[Any, Any, Any]],
    n: tuple[int, int],
    table: Mapping[str, Any],
    still: tuple[int, int] | None = None,
) -> Grid:
    """A grid of equal steps of u and v, from 0 to 1, put in space by place(u, v) -> x, y, z.

    Parameters
    ----------
    n : cells along u and v
    table : `diagonals`; `distortion`, the largest shift of an inner node over the length of a
        cell; `seed` of these random shifts
    still : an inner node that is not shifted

    Raises
    ------
    ValueError : no cells, or shifts that could fold a cell.
    """
    for count in n:
        if count < 1:
            raise ValueError(f"{count} cells: expected at least 1")
    distortion = float(table.get("distortion", 0.0))
    if not 0.0 <= distortion < 0.35:
        raise ValueError(f"distortion = {distortion:g}: expected 0 to 0.35")
    u, v = np.meshgrid(*(np.arange(count + 1.0) for count in n), indexing="ij")
    shift = np.random.default_rng(int(table.get("seed", 1))).uniform(-1.0, 1.0, (2, *u.shape))
    inside = np.zeros(u.shape)
    inside[1:-1, 1:-1] = distortion
    if still is not None:
        inside[still] = 0.0
    x, y, z = place((u + inside * shift[0]) / n[0], (v + inside * shift[1]) / n[1])
    places = np.stack(np.broadcast_arrays(x, y, z), axis=-1).astype(float)
    return Grid(region, places, int(table.get("diagonals", ALTERNATING)))


def triangles(grid: Grid) -> IntArray:
    """Corners of its triangles, (c, 3) rows of its nodes counted along v first."""
    n_u, n_v = grid.places.shape[0] - 1, grid.places.shape[1] - 1
    i, j = (k.ravel() for k in np.meshgrid(np.arange(n_u), np.arange(n_v), indexing="ij"))
    a = i * (n_v + 1) + j
    b, c, d = a + n_v + 1, a + n_v + 2, a + 1
    forward = np.stack([a, b, c, a, c, d], axis=1)
    backward = np.stack([a, b, d, b, c, d], axis=1)
    if grid.diagonals == ALTERNATING:
        chosen = np.where(((i + j) % 2 == 0)[:, None], forward, backward)
    else:
        chosen = forward if grid.diagonals == ONE_WAY else backward
    return np.asarray(chosen.reshape(-1, 3))


def write(
    gmsh: Any,
    grids: Sequence[Grid],
    curves: Mapping[str, Sequence[Array]],
    points: Mapping[str, Sequence[float]],
) -> None:
    """Hand everything to gmsh's current model.

    Parameters
    ----------
    gmsh : the module, initialised
    curves : physical curve -> polylines (k, 3) through neighbouring nodes [m]
    points : physical point -> place of a node [m]; one where no node lies is left out
    """
    places = np.concatenate([grid.places.reshape(-1, 3) for grid in grids])
    first = np.cumsum([0] + [grid.places[..., 0].size for grid in grids])
    near = 1e-8 * float(np.ptp(places, axis=0).max())
    pairs = cKDTree(places).query_pairs(near, output_type="ndarray")
    graph = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(len(places),) * 2)
    n_node, number = connected_components(graph, directed=False)
    merged = np.zeros((n_node, 3))
    merged[number] = places
    tree = cKDTree(merged)
    cells: dict[str, list[IntArray]] = {}
    for grid, start in zip(grids, first, strict=False):
        cells.setdefault(grid.region, []).append(number[start + triangles(grid)] + 1)
    mesh = gmsh.model.mesh
    for row, (region, tables) in enumerate(cells.items(), start=1):
        gmsh.model.addDiscreteEntity(2, row)
        if row == 1:
            mesh.addNodes(2, row, list(range(1, n_node + 1)), merged.ravel().tolist())
        mesh.addElementsByType(row, 2, [], np.concatenate(tables).ravel().tolist())
        gmsh.model.setPhysicalName(2, gmsh.model.addPhysicalGroup(2, [row]), region)
    for row, (name, polylines) in enumerate(curves.items(), start=1):
        gmsh.model.addDiscreteEntity(1, row)
        for polyline in polylines:
            rows = tree.query(polyline)[1] + 1
            mesh.addElementsByType(row, 1, [], np.repeat(rows, 2)[1:-1].tolist())
        gmsh.model.setPhysicalName(1, gmsh.model.addPhysicalGroup(1, [row]), name)
    row = 0
    for name, place in points.items():
        distance, node = tree.query(np.asarray(place, float))
        if distance > near:
            continue
        row += 1
        gmsh.model.addDiscreteEntity(0, row)
        mesh.addElementsByType(row, 15, [], [int(node) + 1])
        gmsh.model.setPhysicalName(0, gmsh.model.addPhysicalGroup(0, [row]), name)


def checked(defaults: Mapping[str, Any], parameters: Mapping[str, Any]) -> dict[str, Any]:
    """Defaults and the values given for them; raises ValueError for an unknown parameter."""
    for key in parameters:
        if key not in defaults:
            raise ValueError(f"no parameter {key}: expected {', '.join(defaults)}")
    return {**defaults, **parameters}


def show(build: Callable[[Any, Mapping[str, Any]], None], arguments: Sequence[str]) -> None:
    """Show a shape with its defaults in gmsh's window, or write it to a file."""
    import gmsh

    gmsh.initialize()
    build(gmsh, {})
    if arguments:
        gmsh.write(arguments[0])
    else:
        gmsh.fltk.run()
    gmsh.finalize()
