"""Lay-up and axes of every region of a shell.

A region has the cells of one physical surface that are of one kind: a surface of triangles and
quadrilaterals gives two regions of one name.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ....solver.errors import check_known, did_you_mean, few
from ....solver.math.arrays import Array, IntArray
from ....solver.package.common.cells import NONE, corner_counts
from ....solver.package.common.materials import material_from_dict
from ... import fenicsx
from ...laminate.laminate_specification import LaminateSpec, laminate_from_dict
from ...laminate.stiffness import LaminateStiffness, computed, laminate_stiffness
from ..groups import KEYS as AXES
from ..groups import cell_directions
from ..shell_cells import (
    NORMAL,
    CellError,
    CellGeometry,
    ShellError,
    ShellMesh,
    cell_geometry,
    width_ratios,
)

ALL = "all"


@dataclass(frozen=True)
class Region:
    """Cells of one kind in one physical surface, their geometry and their laminate.

    `cells` (m,) are rows of the mesh's cells, `nodes` (m, 3|4) their corners and `geometry` their
    geometry in that order; the axes E of a cell are those of its laminate.
    """

    name: str
    cells: IntArray
    nodes: IntArray
    geometry: CellGeometry
    laminate_name: str
    laminate: LaminateSpec
    stiffness: LaminateStiffness


def read_regions(spec: Mapping[str, Any], mesh: ShellMesh, where: str) -> list[Region]:
    """Every region of the mesh with the laminate that the specification gives it.

    Parameters
    ----------
    spec : description of the shell
    mesh : of the shell
    where : file or shell, for messages

    Raises
    ------
    ShellError : a region of the mesh without laminate, a region that the mesh does not have, an
        unknown laminate, wrong axes.
        LaminateError, MaterialError : their descriptions are wrong.
    """
    laminated, given = _Laminated(spec, where), spec["regions"]
    for name in given:
        if name != ALL and name not in mesh.regions:
            raise ShellError(
                f"{where}.regions.{name}: the mesh has no physical surface of that name, it has "
                + few(mesh.regions)
                + did_you_mean(name, (*mesh.regions, ALL))
            )
    regions = []
    counts, ratios = corner_counts(mesh.cells), width_ratios(mesh.points_G, mesh.cells)
    for row, name in enumerate(mesh.regions):
        key = name if name in given else ALL
        if key not in given:
            raise ShellError(
                f"{where}.regions: physical surface {name!r} of the mesh has no laminate; "
                f"expected a table regions.{name}, or regions.{ALL} for all that are not named"
            )
        place = f"{where}.regions.{key}"
        laminate_name, laminate, stiffness = laminated.of(key)
        flip = given[key].get("flip", False)
        if not isinstance(flip, bool):
            raise ShellError(f"{place}.flip = {flip!r}: expected true or false")
        for count in (3, 4):
            cells = np.flatnonzero((mesh.region == row) & (counts == count))
            if not cells.size:
                continue
            direction = cell_directions(mesh, given[key], cells, place)
            nodes = np.ascontiguousarray(mesh.cells[cells, :count])
            try:
                own = ratios[cells, :count]
                geometry = cell_geometry(mesh.points_G, nodes, direction, flip, own)
            except CellError as error:
                axes = [name for name in AXES if given[key].get(name) is not None]
                at = f"{place}.{axes[0]}" if axes and error.fault == NORMAL else place
                raise ShellError(f"{at}: {_where_in_file(mesh, cells, error)}") from error
            regions.append(Region(name, cells, nodes, geometry, laminate_name, laminate, stiffness))
    return regions


def _where_in_file(mesh: ShellMesh, cells: IntArray, error: CellError) -> str:
    """The fault of some of the cells, with number and place of the first as the mesh file has
    them."""
    first = cells[error.rows[0]]
    nodes = mesh.cells[first][mesh.cells[first] != NONE]
    x, y, z = mesh.points_G[nodes].mean(axis=0)
    tags = ", ".join(str(tag) for tag in mesh.node_tags[nodes])
    return (
        f"{len(error.rows)} of {len(cells)} {error.kind}: each {error.fault}; the first has the "
        f"nodes {tags}, at ({x:.4g}, {y:.4g}, {z:.4g}) m"
    )


class _Laminated:
    """The laminates that a specification gives to its regions."""

    def __init__(self, spec: Mapping[str, Any], where: str) -> None:
        self._given, self._where = spec["regions"], where
        self._materials = {
            name: material_from_dict(entry, f"{where}.materials.{name}")
            for name, entry in spec["materials"].items()
        }
        self._laminates = {
            name: laminate_from_dict(table, self._materials, f"{where}.laminates.{name}")
            for name, table in spec.get("laminates", {}).items()
        }

    def of(self, key: str) -> tuple[str, LaminateSpec, LaminateStiffness]:
        """Name, plies and stiffness of the laminate of a table of `regions`."""
        place, table = f"{self._where}.regions.{key}", self._given[key]
        if "laminate" in table:
            name, known = table["laminate"], few(self._laminates) or "those of a table laminates"
            text = f"no such laminate; expected one of {known}"
            check_known(name, self._laminates, f"{place}.laminate", ShellError, text)
            laminate = self._laminates[name]
        elif "material" in table and "thickness" in table:
            name = f"{key}: {table['material']}"
            plain = {"plies": [{word: table[word] for word in ("material", "thickness")}]}
            plain |= {word: table[word] for word in ("offset", "shear_correction") if word in table}
            laminate = laminate_from_dict(plain, self._materials, place)
        else:
            raise ShellError(
                f"{place}: expected laminate = ..., or material = ... and thickness = ..."
            )
        with computed(f"{self._where}.laminates.{name}"):
            return name, laminate, laminate_stiffness(laminate.laminate, laminate.shear)


def relaid(regions: Sequence[Region], spec: Mapping[str, Any], where: str) -> list[Region]:
    """The regions with the laminates of another specification.

    Parameters
    ----------
    regions : of the shell
    spec : description that differs from theirs in numbers of laminates only
    where : file or shell, for messages
    """
    laminated, given = _Laminated(spec, where), spec["regions"]
    laminates = {
        name: laminated.of(name if name in given else ALL) for name in {r.name for r in regions}
    }
    return [
        replace(region, laminate=laminates[region.name][1], stiffness=laminates[region.name][2])
        for region in regions
    ]


def cell_axes(mesh: ShellMesh, regions: Sequence[Region]) -> Array:
    """Axes A_GE of the laminate of every cell of the mesh, (c, 3, 3)."""
    axes = np.empty((len(mesh.cells), 3, 3))
    for region in regions:
        axes[region.cells] = region.geometry.A_GE
    return axes


def own_cells(regions: Sequence[Region], mesh: ShellMesh, team: fenicsx.Team) -> list[Region]:
    """The cells of this process of a team: a slice of the mesh across its longest direction.

    Parameters
    ----------
    regions : all cells
    mesh : of the shell
    team : processes that share the cells
    """
    if team.size == 1:
        return list(regions)
    own = np.zeros(len(mesh.cells), dtype=bool)
    own[team.slice_of(mesh.centres_G)] = True
    parts = [(region, np.flatnonzero(own[region.cells])) for region in regions]
    return [
        replace(r, cells=r.cells[some], nodes=r.nodes[some], geometry=r.geometry[some])
        for r, some in parts
        if len(some)
    ]
