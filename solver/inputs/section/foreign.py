"""Meshes of other programs with the sets of cells that their files name.

Those of sections become arrays, those of shells and solids meshes of gmsh.
"""

import contextlib
import hashlib
import io
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import InputError, few, nearest, refuse
from ...math.arrays import Array, IntArray
from ...package.common.files import temporary_sibling
from ...system.platform import limited
from ..common.mesh_files import ALL, content_sha256

# Sets of cells that a mesh file names: the regions and curves of a section.

Mask = NDArray[np.bool_]

WHOLE = "section"  # name of the only region of a mesh without named regions


def region_sets(
    mesh: Any, blocks: list[int], file: str, region_data: str | None
) -> dict[str, Mask]:
    """Return the regions of a mesh as masks over its plane cells; they may overlap.

    Regions are its named cell sets or groups. Without these, they are the values of its integer
    cell data, named "NAME-VALUE". Without cell data, the whole mesh is the region "section".

    Parameters
    ----------
    mesh : as meshio read it
    blocks : rows of mesh.cells with the plane cells
    file : its name, for messages
    region_data : name of the cell data to take the regions from

    Raises
    ------
    InputError
        No such cell data, or several candidates.
    """
    data = {}
    for name, values in mesh.cell_data.items():
        of_cells = np.concatenate([np.asarray(values[i]) for i in blocks])
        if of_cells.size == len(of_cells):  # one value per cell
            data[name] = of_cells.ravel()
    if region_data is not None:
        if region_data not in data:
            raise InputError(
                f'mesh.region_data = "{region_data}": {file} has no such cell data'
                f"{nearest(region_data, data)}"
            )
        return _by_value(region_data, data[region_data])
    sets = named_sets(mesh, blocks)
    if sets:
        return sets
    whole = [name for name, values in data.items() if values.dtype.kind in "iu"]
    if len(whole) > 1:
        raise InputError(
            f"mesh.region_data: missing; {file} has several integer cell data, expected one "
            f"of {few(sorted(whole))}"
        )
    if whole:
        return _by_value(whole[0], data[whole[0]])
    return {WHOLE: np.ones(sum(len(mesh.cells[i].data) for i in blocks), dtype=bool)}


def _by_value(name: str, values: Array) -> dict[str, Mask]:
    short = name.rpartition(":")[2]
    return {f"{short}-{value:g}": values == value for value in np.unique(values)}


def in_one_region(sets: Mapping[str, Mask], what: str) -> IntArray:
    """Return the region of each cell as a row of `sets`, (c,).

    Raises InputError, which begins with `what`: a cell in none or in several.
    """
    count = np.sum(list(sets.values()), axis=0)
    for cell in np.flatnonzero(count != 1)[:1].tolist():
        of = few(name for name, members in sets.items() if members[cell]) or "none"
        raise InputError(
            f"{what} {cell + 1} is in {count[cell]} sets ({of}), expected exactly one, its region"
        )
    return np.asarray(np.argmax(list(sets.values()), axis=0), dtype=np.int64)


def named_sets(mesh: Any, blocks: list[int]) -> dict[str, Mask]:
    """Return cell sets, groups (MED) and physical names as masks over the cells of `blocks`."""
    sizes = [len(mesh.cells[i].data) for i in blocks]
    sets: dict[str, Mask] = {}
    for name, members in mesh.cell_sets.items():
        if name.startswith("gmsh:"):  # data that meshio adds
            continue
        masks = [np.zeros(size, dtype=bool) for size in sizes]
        for mask, i in zip(masks, blocks, strict=True):
            if members[i] is not None:
                mask[np.asarray(members[i], dtype=np.int64)] = True
        sets[name] = np.concatenate([np.zeros(0, dtype=bool), *masks])
    for number, groups in getattr(mesh, "cell_tags", {}).items():
        tags = [np.asarray(mesh.cell_data["cell_tags"][i]) for i in blocks]
        for group in groups:
            mask = np.concatenate([np.zeros(0), *tags]) == number
            sets[group] = sets.get(group, np.zeros(mask.size, dtype=bool)) | mask
    return {name: mask for name, mask in sets.items() if mask.any()}


# Meshes of other programs, read by meshio into plain arrays with named regions.

# Reversed cell: the same cell with its nodes in the opposite order.
_TURNED = {
    "triangle": [0, 2, 1],
    "triangle6": [0, 2, 1, 5, 4, 3],
    "quad": [0, 3, 2, 1],
    "quad9": [0, 3, 2, 1, 7, 6, 5, 4, 8],
}
_PLANE = (*_TURNED, "quad8")
_LINES = ("line", "line3")
_CORNERS = {"line": 2, "triangle": 3, "quad": 4, "tetra": 4, "hexahedron": 8}
FLAT = 1e-9  # of the size of the mesh
# CPU seconds for each megabyte, 20 times what meshio takes: some readers never end on a cut file.
READ_S = 2.0


@dataclass(frozen=True)
class ForeignMesh:
    """A plane mesh with the named sets of cells in its file; sets may overlap.

    `n` counts nodes, `c` cells of `k` nodes, `m` line cells.
    """

    file: Path
    points: Array  # (n, 2)
    cells: IntArray  # (c, k)
    cell_type: str
    sets: dict[str, Mask]  # (c,)
    lines: IntArray  # (m, 2 or 3)
    curves: dict[str, Mask]  # (m,)


def read_foreign(file: Path, where: str, region_data: str | None = None) -> ForeignMesh:
    """Read a mesh of any format that meshio knows; regions by the rules of `region_sets`.

    Parameters
    ----------
    file : the mesh; its x and y are x2 and x3
    where : its key, for messages
    region_data : name of the cell data to take the regions from

    Raises
    ------
    InputError
        No mesh, no plane mesh, cells of several types, several candidates for regions.
    """
    mesh = read_mesh(file, where)
    plane = [i for i, block in enumerate(mesh.cells) if block.type in _PLANE]
    solid = sorted({b.type for b in mesh.cells if b.dim == 3})
    if not plane or solid:
        types = ", ".join(sorted({b.type for b in mesh.cells})) or "none"
        raise InputError(
            f"{where}: its cells are of type {types}, expected plane cells of type "
            + ", ".join(_PLANE)
        )
    counts: dict[str, int] = {}
    for i in plane:
        counts[mesh.cells[i].type] = counts.get(mesh.cells[i].type, 0) + len(mesh.cells[i].data)
    if len(counts) > 1:
        listed = ", ".join(f"{n} {name}" for name, n in counts.items())
        raise InputError(f"{where}: cells of several types ({listed}), expected one type")
    cell_type = next(iter(counts))
    cells = np.concatenate([mesh.cells[i].data for i in plane]).astype(np.int64)
    line_blocks, lines = _lines(mesh, where)
    points, (cells, lines) = _plane_points(where, np.asarray(mesh.points, float), cells, lines)
    if cell_type == "quad8":
        points, cells, cell_type = *_with_centre(points, cells), "quad9"
    # Clockwise cells are reversed: a mesh seen from behind is valid.
    corners = points[cells[:, : 3 if cell_type.startswith("tri") else 4]]
    x, y = corners[..., 0], corners[..., 1]
    area = (x * np.roll(y, -1, axis=1) - y * np.roll(x, -1, axis=1)).sum(axis=1)
    turned = cells[:, _TURNED[cell_type]]
    cells = np.where((area < 0)[:, None], turned, cells)
    return ForeignMesh(
        file,
        points,
        cells,
        cell_type,
        region_sets(mesh, plane, file.name, region_data),
        lines,
        named_sets(mesh, line_blocks),
    )


def read_mesh(file: Path, where: str) -> Any:
    """Read a file by meshio. Raises InputError if it cannot."""
    import meshio  # imported here: takes 0.1 s and only this command needs it

    said = io.StringIO()  # meshio prints the reason and exits the interpreter
    try:
        with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
            with limited(READ_S * (1 + file.stat().st_size / 1e6), "its reader does not end"):
                mesh = meshio.read(file)
            _check_nodes(mesh)
            return mesh
    except (Exception, SystemExit) as error:  # its readers raise all kinds of errors
        reason = " ".join(said.getvalue().split()) or str(error) or type(error).__name__
        raise InputError(f"{where}: meshio cannot read it: {reason}") from error


def _check_nodes(mesh: Any) -> None:
    """Raise ValueError for nodes without a place, cells without nodes, sets without a name."""
    mesh.points = np.asarray(mesh.points, float)
    if mesh.points.shape[1:] not in ((2,), (3,)):
        raise ValueError("its nodes have neither two nor three coordinates")
    for block in mesh.cells:
        shape = block.type.rstrip("0123456789")
        width = int(block.type[len(shape) :] or _CORNERS.get(shape, 0))
        whole = np.shape(block.data)[1:] == (width,) or shape not in _CORNERS
        if not whole or not np.isin(block.data, np.arange(len(mesh.points))).all():
            raise ValueError(f"nodes of its cells of type {block.type} are missing")
    if not all(isinstance(name, str) for name in (*mesh.cell_sets, *mesh.point_sets)):
        raise ValueError("one of its sets has no name")


def _lines(mesh: Any, where: str) -> tuple[list[int], IntArray]:
    """Return the blocks of line cells and their nodes."""
    blocks = [i for i, block in enumerate(mesh.cells) if block.type in _LINES]
    types = {mesh.cells[i].type for i in blocks}
    if len(types) > 1:
        raise InputError(f"{where}: line cells of types {', '.join(sorted(types))}: expected one")
    if not blocks:
        return [], np.zeros((0, 2), dtype=np.int64)
    return blocks, np.concatenate([mesh.cells[i].data for i in blocks]).astype(np.int64)


def _plane_points(where: str, points: Array, *cells: IntArray) -> tuple[Array, list[IntArray]]:
    """Return the points in use, (n, 2), and the cells with their new numbers."""
    used = np.unique(np.concatenate([c.ravel() for c in cells]))
    number = np.zeros(len(points), dtype=np.int64)
    number[used] = np.arange(len(used))
    points = points[used]
    wrong = np.flatnonzero(~np.isfinite(points).all(axis=1))
    if wrong.size:
        raise InputError(
            f"{where}: node {used[wrong[0]] + 1} of the file, in its order, at "
            f"{points[wrong[0]].tolist()}: expected finite coordinates; wrong nodes: {wrong.size}"
        )
    height = points[:, 2:]
    if height.size and np.ptp(height) > FLAT * np.ptp(points[:, :2], axis=0).max():
        raise InputError(
            f"{where}: its points have third coordinates from {height.min():g} to "
            f"{height.max():g}: expected a flat mesh, x = x2 and y = x3"
        )
    return np.ascontiguousarray(points[:, :2]), [number[c] for c in cells]


def _with_centre(points: Array, cells: IntArray) -> tuple[Array, IntArray]:
    """Add the middle node to eight-node quadrilaterals; their geometry does not change."""
    corners, sides = points[cells[:, :4]].sum(axis=1), points[cells[:, 4:]].sum(axis=1)
    centre = 0.5 * sides - 0.25 * corners
    number = len(points) + np.arange(len(cells))
    return np.concatenate([points, centre]), np.column_stack([cells, number])


# Arrays of such a mesh for the preprocessor, each cell in one described region.


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
    errors = []
    region = np.full(len(mesh.cells), -1, dtype=np.int64)
    for row, name in enumerate(names):
        if name not in mesh.sets:
            errors.append(
                f"regions.{name}: {mesh.file.name} has no such region{nearest(name, mesh.sets)}"
            )
            continue
        for other in np.unique(region[mesh.sets[name] & (region >= 0)]):
            both = int(np.count_nonzero(mesh.sets[name] & (region == other)))
            errors.append(
                f"regions.{name}: {both} of its cells in {mesh.file.name} are in region "
                f"{names[other]} too: expected each cell in one region"
            )
        region[mesh.sets[name]] = row
    bare = region < 0
    if default is None and bare.any() and not errors:
        left = [name for name, mask in mesh.sets.items() if (mask & bare).any()]
        listed = f"; they are in {few(left)}" if left else ""
        errors.append(
            f"regions: {np.count_nonzero(bare)} of {bare.size} cells of {mesh.file.name} belong to "
            f"no described region{listed}: expected a table for each, or regions.all"
        )
    refuse(errors)
    region[bare] = len(names)
    return region


def write_arrays(
    mesh: ForeignMesh, names: Iterable[str], region: IntArray, folder: Path
) -> tuple[Path, str]:
    """Write the arrays beside the specification; return the file and its SHA-256.

    The name contains the hash, so that equal content is written once. An .npz file with

        points        (n, 2)  x2, x3, in the unit of the source
        cells         (c, k)  rows of points, in gmsh's order of nodes
        cell_type     "triangle", "triangle6", "quad" or "quad9"
        region        (c,)    row of region_names
        region_names  (r,)    text
        lines         (m, 2 or 3)  line cells of the named curves: ends, then the middle
        curve         (m,)    row of curve_names
        curve_names   (s,)    text

    Parameters
    ----------
    mesh : the mesh
    names : names of the regions
    region : region of each cell (c,)
    folder : folder for relative names of files
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
    """Write named arrays to a file whose name ends in its hash; return file and SHA-256.

    Parameters
    ----------
    folder : folder for relative names of files
    name : begin of the file's name
    arrays : arrays by name
    """
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


# Meshes of shells and solids, as files of gmsh.

# Cells in the opposite order of nodes: MED counts those of solids the other way round.
MIRRORED = {
    "tetra": [0, 2, 1, 3],
    "tetra10": [0, 2, 1, 3, 6, 5, 4, 7, 9, 8],
    "hexahedron": [0, 3, 2, 1, 4, 7, 6, 5],
}
SURFACE = ("triangle", "quad")


def gmsh_mesh(
    file: Path, where: str, folder: Path, dimension: int, regions: Collection[str]
) -> Path:
    """Write a mesh with its named sets of cells and nodes for gmsh; return the file.

    Parameters
    ----------
    where : its key, for messages
    dimension : of the cells that are analysed, 2 or 3, each of which must be in one region
    regions : names of the description; of sets that overlap, as a set of all cells does, these
        count

    Raises
    ------
    InputError : no mesh, cells of other kinds, cells in no region or in two.
    """
    digest = hashlib.sha256(repr((content_sha256(file), sorted(regions))).encode()).hexdigest()
    target = folder / f"{file.stem}-{digest[:12]}.msh"
    if target.is_file():
        return target
    import meshio

    mesh = read_mesh(file, where)
    kinds = {block.type: block.dim for block in mesh.cells if block.dim >= dimension}
    others = sorted(set(kinds) - set(SURFACE)) if dimension == 2 else []
    if others or not kinds:
        expected = "tetrahedra or hexahedra"
        if dimension == 2:
            expected = "triangle and quad, of degree 1, in space"
        content = f"its cells are of type {', '.join(others) or 'none'}"
        raise InputError(f"{where}: {content}, expected {expected}")
    names: dict[str, IntArray] = {}
    cells: list[tuple[str, IntArray]] = []
    tags: list[IntArray] = []

    def add(name: str, dimension: int, parts: Iterable[tuple[str, IntArray]]) -> None:
        label = name if name not in names else f"{name} {dimension}"
        names[label] = np.array([len(names) + 1, dimension])
        for kind, own in parts:
            if len(own):
                cells.append((kind, own))
                tags.append(np.full(len(own), len(names)))

    for d in range(dimension, 0, -1):
        blocks = [i for i, block in enumerate(mesh.cells) if block.dim == d]
        if not blocks:
            continue
        if d == dimension:
            sets = region_sets(mesh, blocks, file.name, None)
            count = np.sum(list(sets.values()), axis=0)
            if count.max() > 1 and not {ALL, *sets}.isdisjoint(regions):
                sets = {name: mask for name, mask in sets.items() if name in regions}
                others = np.sum([0 * count, *sets.values()], axis=0) == 0
                sets |= {"other cells": others} if ALL in regions and others.any() else {}
            in_one_region(sets, f"{where}: {'solid ' if d == 3 else ''}cell")
        else:
            sets = named_sets(mesh, blocks)
        ends = np.cumsum([len(mesh.cells[i].data) for i in blocks])[:-1]
        for name, members in sets.items():
            own = zip(blocks, np.split(members, ends), strict=True)
            kept = ((mesh.cells[i].type, _outwards(mesh, i)[rows]) for i, rows in own)
            add(name, d, kept)
    if dimension == 2:
        for name, nodes in mesh.point_sets.items():
            add(name, 0, [("vertex", np.asarray(nodes, dtype=np.int64)[:, None])])
    points = np.zeros((len(mesh.points), 3))
    points[:, : np.shape(mesh.points)[1]] = mesh.points
    data = {"gmsh:physical": tags, "gmsh:geometrical": tags}
    made = meshio.Mesh(points, cells, cell_data=data, field_data=names)
    folder.mkdir(parents=True, exist_ok=True)
    with temporary_sibling(target) as temporary:
        meshio.write(temporary, made, file_format="gmsh22")
    return target


def _outwards(mesh: Any, block: int) -> IntArray:
    """Cells of a block; solid ones with a positive volume, as gmsh counts their nodes."""
    cells = np.asarray(mesh.cells[block].data)
    order = MIRRORED.get(mesh.cells[block].type)
    if order is None or not len(cells):
        return cells
    near = (1, 3, 4) if len(order) == 8 else (1, 2, 3)  # corners along the edges of the first one
    a, b, c = (mesh.points[cells[:, k]] - mesh.points[cells[:, 0]] for k in near)
    turned = np.einsum("ci,ci->c", np.cross(a, b), c) < 0.0
    return np.where(turned[:, None], cells[:, order], cells)
