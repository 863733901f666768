"""Meshes of other programs, such as MED: read by meshio, written as meshes of gmsh."""

from pathlib import Path
from typing import Any

import numpy as np

from ...errors import InputError, few
from ...math.arrays import IntArray
from ...package.common.temporary import temporary_sibling
from ..common.gmsh_file import content_sha256
from ..section.foreign import named_sets, read_mesh, region_sets

BUILD = Path("build/solids")  # folder of the meshes
# Cells in the opposite order of nodes: MED counts those of solids the other way round.
MIRRORED = {
    "tetra": [0, 2, 1, 3],
    "tetra10": [0, 2, 1, 3, 6, 5, 4, 7, 9, 8],
    "hexahedron": [0, 3, 2, 1, 4, 7, 6, 5],
}


def gmsh_mesh(file: Path, where: str) -> Path:
    """Write a mesh with its named sets of cells, faces and lines for gmsh; returns the file.

    Raises
    ------
    InputError : no mesh, cells in no region or in two.
    """
    target = BUILD / f"{file.stem}-{content_sha256(file)[:12]}.msh"
    if target.is_file():
        return target
    import meshio

    mesh = read_mesh(file, where)
    names: dict[str, IntArray] = {}
    cells: list[tuple[str, IntArray]] = []
    tags: list[IntArray] = []
    for dimension in (3, 2, 1):
        blocks = [i for i, block in enumerate(mesh.cells) if block.dim == dimension]
        if not blocks:
            continue
        if dimension == 3:
            sets = region_sets(mesh, blocks, file.name, None)
            _check_regions(np.sum(list(sets.values()), axis=0), sets, where)
        else:
            sets = named_sets(mesh, blocks)
        starts = np.cumsum([0, *(len(mesh.cells[i].data) for i in blocks)])
        for name, members in sets.items():
            label = name if name not in names else f"{name} {dimension}"
            names[label] = np.array([len(names) + 1, dimension])
            for k, i in enumerate(blocks):
                own = mesh.cells[i].data[members[starts[k] : starts[k + 1]]]
                cells.append((mesh.cells[i].type, _outwards(own, mesh, i)))
                tags.append(np.full(len(own), len(names)))
    if not any(int(dimension) == 3 for _, dimension in names.values()):
        raise InputError(f"{where}: it has no solid cells; expected tetrahedra or hexahedra")
    there = [k for k, tag in enumerate(tags) if len(tag)]
    data = [tags[k] for k in there]
    found = meshio.Mesh(
        np.asarray(mesh.points, dtype=float),
        [cells[k] for k in there],
        cell_data={"gmsh:physical": data, "gmsh:geometrical": data},
        field_data=names,
    )
    BUILD.mkdir(parents=True, exist_ok=True)
    with temporary_sibling(target) as temporary:
        meshio.write(temporary, found, file_format="gmsh22")
    return target


def _check_regions(count: IntArray, sets: dict[str, Any], where: str) -> None:
    wrong = np.flatnonzero(count != 1)
    if len(wrong):
        cell = int(wrong[0])
        of = [name for name, members in sets.items() if members[cell]]
        raise InputError(
            f"{where}: solid cell {cell + 1} is in {count[cell]} sets ({few(of) or 'none'}), "
            "expected exactly one, the region of its material"
        )


def _outwards(cells: IntArray, mesh: Any, block: int) -> IntArray:
    """Cells of a block with a positive volume, as gmsh counts their nodes."""
    order = MIRRORED.get(mesh.cells[block].type)
    if order is None or not len(cells):
        return cells
    near = (1, 3, 4) if len(order) == 8 else (1, 2, 3)  # corners along the edges of the first one
    a, b, c = (mesh.points[cells[:, k]] - mesh.points[cells[:, 0]] for k in near)
    turned = np.einsum("ci,ci->c", np.cross(a, b), c) < 0.0
    return np.where(turned[:, None], cells[:, order], cells)
