"""Ply and ply axes of each point of a section, along curves of the mesh."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ....solver.errors import check_known, coded, did_you_mean, few
from ....solver.math.arrays import Array
from ....solver.package.common.materials import Anisotropic, Orthotropic, bond, elastic_from_dict
from ....solver.package.common.recovery_schema import Ply
from ..section_specification import OF_MESH, SectionError
from .mesh_checks import checked
from .section_cells import edges_of
from .section_mesh import SectionMesh
from .space import SectionSpace
from .tolerances import BOWED, STRAIGHT

SAMPLES = 8  # per element, to find the nearest element
CANDIDATES = 4  # candidate elements for each point
NEWTON_STEPS = 8


def nearest_on_curve(segments: Array, x: Array) -> Array:
    """Nearest point on a curve for each of some points, (p, 2).

    Parameters
    ----------
    segments : (s, 2 or 3, 2) end points of the line elements, then the middle node
    x : (p, 2) points
    """
    from scipy.spatial import cKDTree  # here: few sections have curves

    a, b = segments[:, 0], segments[:, 1]
    # position = mean + half s + bow s^2 for s from -1 to 1
    middle = segments[:, 2] if segments.shape[1] == 3 else 0.5 * (a + b)
    half, bow = 0.5 * (b - a), 0.5 * (a + b) - middle
    s = np.linspace(-1.0, 1.0, SAMPLES + 1)[:, None, None]
    samples = middle + half * s + bow * s**2  # (SAMPLES + 1, s, 2)
    tree = cKDTree(samples.reshape(-1, 2))
    _, near = tree.query(x, k=min(CANDIDATES * 2, samples.shape[0] * samples.shape[1]))
    element = near % len(segments)
    s0 = -1.0 + 2.0 * (near // len(segments)) / SAMPLES
    c, h, w = middle[element], half[element], bow[element]  # (p, candidates, 2)
    for _ in range(NEWTON_STEPS):
        away = c + h * s0[..., None] + w * s0[..., None] ** 2 - x[:, None]
        slope = h + 2.0 * w * s0[..., None]
        first = np.einsum("pki,pki->pk", away, slope)
        second = np.einsum("pki,pki->pk", slope, slope) + 2.0 * np.einsum("pki,pki->pk", away, w)
        # where the distance is not convex, a Gauss-Newton step still reduces it
        convex = np.einsum("pki,pki->pk", slope, slope)
        s0 = np.clip(s0 - first / np.where(second > 0.1 * convex, second, convex), -1.0, 1.0)
    feet = c + h * s0[..., None] + w * s0[..., None] ** 2
    best = np.argmin(np.linalg.norm(feet - x[:, None], axis=-1), axis=1)
    return np.asarray(feet[np.arange(len(x)), best])


ALL = "all"  # the region that describes those without a table of their own
CONVENTIONS = ("contour", "cartesian")
THICKNESS = 1e-3  # tolerance of the thickness of a laminate relative to its wall


@dataclass(frozen=True)
class Layup:
    """Ply and layer direction of every integration point of a space.

    Attributes
    ----------
    ply : (c, q) row of plies
    y2 : (c, q, 2) layer direction, towards which ply angles are measured [-]
    plies, materials : the plies and the material of each one
    uniform : True if each cell has one ply and one layer direction
    reversing : (c,) cells inside which a Cartesian layer direction would change its sense; it is
        the one of most of their area
    warnings : {"code", "message"}
    """

    ply: NDArray[np.int64]
    y2: Array
    plies: tuple[Ply, ...]
    materials: tuple[Orthotropic | Anisotropic, ...]
    uniform: bool
    reversing: NDArray[np.bool_]
    warnings: tuple[dict[str, str], ...]

    @cached_property
    def A_BM(self) -> Array:
        """Ply axes in section axes, (c, 1, 3, 3) or (c, q, 3, 3): v_B = A_BM v_M.

        Angles of plies turn from x1 towards y2.
        """
        y2, ply = (self.y2[:, :1], self.ply[:, :1]) if self.uniform else (self.y2, self.ply)
        angle = np.radians([p.angle_deg for p in self.plies])[ply][..., None]
        cos, sin = np.cos(angle), np.sin(angle)
        A = np.zeros((*ply.shape, 3, 3))
        A[..., 0, :1], A[..., 0, 1:2] = cos, -sin
        A[..., 1:, 0], A[..., 1:, 1] = sin * y2, cos * y2
        A[..., 1, 2], A[..., 2, 2] = -y2[..., 1], y2[..., 0]
        return A

    def reversed_there(self) -> "Layup":
        """The plies with the other sense of the layer direction in the cells `reversing`."""
        sign = np.where(self.reversing, -1.0, 1.0)[:, None, None]
        return replace(self, y2=sign * self.y2)

    @cached_property
    def stiffness_M(self) -> Array:
        """Stiffness of each ply in its own axes, (k, 6, 6) [Pa]."""
        return np.array([material.stiffness_M for material in self.materials])

    @cached_property
    def T(self) -> Array:
        """Rotations of stresses, (c, 1 or q, 6, 6): stress_B = T stress_M."""
        return bond(self.A_BM)

    @property
    def stiffness(self) -> Array:
        """Stiffness in section axes, (c, 1, 6, 6) or (c, q, 6, 6) [Pa]."""
        return self.in_section(self.stiffness_M)

    def in_section(self, of_plies: Array, cells: Any = slice(None)) -> Array:
        """Stiffness in section axes at points of some cells, plies having `of_plies` (k, 6, 6)."""
        T = self.T[cells]
        C = T @ of_plies[self.ply[cells][:, : T.shape[1]]] @ np.swapaxes(T, -1, -2)
        return np.asarray(0.5 * (C + np.swapaxes(C, -1, -2)))

    @property
    def density(self) -> Array:
        """(c, q) [kg/m3]."""
        return np.array([material.rho for material in self.materials])[self.ply]


def layup(spec: Mapping[str, Any], mesh: SectionMesh, space: SectionSpace, where: str) -> Layup:
    """Find the ply of every integration point.

    Parameters
    ----------
    spec : keys `materials`, `regions`, `convention` of a section's description
    mesh, space : the section's mesh and its integration points
    where : file and key for messages

    Raises
    ------
    SectionError : regions or materials that do not match the mesh, a laminate whose thickness
        differs from that of its wall.
    MaterialError : impossible constants.
    """
    convention = spec.get("convention", CONVENTIONS[0])
    check_known(convention, CONVENTIONS, f"{where}.convention", SectionError)
    names = mesh.cells.regions
    regions = _of_mesh(spec["regions"], names)
    _same_names(regions, names, where)
    massless = spec["mesh"].get("degree") == OF_MESH
    table = {
        name: elastic_from_dict(constants, f"{where}.materials.{name}", massless=massless)
        for name, constants in spec["materials"].items()
    }
    ply = np.full(space.weights.shape, -1)
    y2 = np.zeros((*space.weights.shape, 2))
    plies: list[Ply] = []
    materials: list[Orthotropic | Anisotropic] = []
    turning, mixed = False, 0
    for name, region in regions.items():
        place = f"{where}.regions.{name}"
        cells = np.flatnonzero(mesh.cells.region == names.index(name))
        turns = _Direction(region.get("direction"), mesh, place)
        if turns.kind == "cells":
            angle = np.radians(space.layer_angles()[cells])
            direction = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
            depth = np.zeros(angle.shape)
        else:
            direction, depth = turns.at(space.points[cells])
        nodes = mesh.cells.region_points(cells)
        index = _ply_index(region["plies"], depth, turns, nodes, place)
        ply[cells] = len(plies) + index
        y2[cells] = direction
        mixed += int(np.count_nonzero(index.min(axis=1) != index.max(axis=1)))
        turning |= turns.turning
        for i, entry in enumerate(region["plies"]):
            material, key = entry["material"], f"{place}.plies[{i}].material"
            check_known(material, table, key, SectionError, f"expected one of {few(table)}")
            plies.append(Ply(name, i, material, float(entry.get("angle_deg", 0.0))))
            materials.append(table[material])
    reversing = np.zeros(space.n_cell, dtype=bool)
    if convention == "cartesian":
        flip = (y2[..., 0] < -1e-9) | ((np.abs(y2[..., 0]) <= 1e-9) & (y2[..., 1] < 0.0))
        share = np.sum(space.weights * flip, axis=1) / np.sum(space.weights, axis=1)
        angles = np.array([p.angle_deg % 90.0 for p in plies])
        inside = (share > 1e-9) & (share < 1.0 - 1e-9)
        reversing = inside & np.any(angles[ply] != 0.0, axis=1)
        flip = np.where(reversing[:, None], share[:, None] > 0.5, flip)
        y2 = np.where(flip[..., None], -y2, y2)
    warnings = []
    if mixed:
        warnings += coded(
            "plies-not-resolved",
            f"{mixed} of {space.n_cell} cells contain more than one ply: the "
            "integration of their stiffness across the ply interface is inaccurate; let mesh "
            "lines follow the plies",
        )
    uniform = not turning and not mixed
    return Layup(ply, y2, tuple(plies), tuple(materials), uniform, reversing, tuple(warnings))


def along_walls(mesh: SectionMesh, regions: Mapping[str, Any], where: str) -> SectionMesh:
    """The mesh with edges inside laminates that are as curved as their walls.

    gmsh puts the middles of edges inside a surface half way between their ends. The plies between
    them would be too thick or too thin by the square of the length over 12 radii.

    Parameters
    ----------
    mesh : mesh of a file
    regions : table `regions` of the description
    where : file or section, for messages
    """
    cells = mesh.cells
    points, moved = cells.points.copy(), np.zeros(cells.points.shape)
    for name, region in _of_mesh(regions, cells.regions).items():
        direction = region.get("direction") or {}
        if len(region["plies"]) < 2 or not {"circle", "curve"} & set(direction):
            continue
        at = [row for row, known in enumerate(cells.regions) if known == name]
        ends, middle = edges_of(
            (kind, cells.nodes[rows[np.isin(cells.region[rows], at)]])
            for kind, rows in cells.of_kinds
        )
        number, first, count = np.unique(middle, return_index=True, return_counts=True)
        inside = (count == 2) & (number >= 0)
        number, ends = number[inside], ends[first[inside]]
        a, b, x = points[ends[:, 0]], points[ends[:, 1]], points[number]
        length = np.linalg.norm(b - a, axis=1)
        turns = _Direction(direction, mesh, f"{where}.regions.{name}")
        y2, depth = turns.at(x)
        bow = depth - 0.5 * (turns.at(a)[1] + turns.at(b)[1])
        straight = np.linalg.norm(x - 0.5 * (a + b), axis=1) < STRAIGHT * length
        follows = straight & (np.abs(bow) > STRAIGHT * length) & (np.abs(bow) < BOWED * length)
        bow = np.where(follows, bow, 0.0)[:, None]
        moved[number] = bow * np.column_stack([-y2[:, 1], y2[:, 0]])
    if not moved.any():
        return mesh
    points += moved
    whole = cells.nodes[cells.nodes[:, 8] >= 0]  # their centres follow
    points[whole[:, 8]] += 0.5 * moved[whole[:, 4:8]].sum(axis=1)
    try:
        return replace(mesh, cells=checked(replace(cells, points=points), where)[0])
    except SectionError:  # cells of a sharp corner would fold
        return mesh


def _of_mesh(regions: Mapping[str, Any], names: Sequence[str]) -> Mapping[str, Any]:
    """The regions with that of `all` for each name without its own, as gmsh knows them now."""
    if ALL not in regions or ALL in names:
        return regions
    others = {name: regions[ALL] for name in names if name not in regions}
    return {**{name: table for name, table in regions.items() if name != ALL}, **others}


def _same_names(regions: Mapping[str, Any], names: Sequence[str], where: str) -> None:
    for name in names:
        if name not in regions:
            raise SectionError(
                f"{where}.regions.{name}: missing, the mesh has a region of this name without "
                "material" + did_you_mean(name, regions)
            )
    for name in regions:
        if name not in names:
            raise SectionError(
                f"{where}.regions.{name}: the mesh has no such region, expected "
                + few(names)
                + did_you_mean(name, names)
            )


class _Direction:
    """Layer direction and depth below the outer surface, by vector, circle or curve."""

    def __init__(self, table: Mapping[str, Any] | None, mesh: SectionMesh, where: str) -> None:
        self.given = table is not None
        self.kind, self.value = next(iter((table or {"vector": [1.0, 0.0]}).items()))
        self.turning = self.kind in ("curve", "circle")
        if self.kind == "cells":
            if mesh.cells.layer_angle is None:
                raise SectionError(f"{where}.direction.cells: the mesh has no angles of its cells")
            self.turning = mesh.cells.layer_angle.shape[1] > 1
            return
        if self.kind == "curve":
            known = f"expected one of {few(mesh.curves) or 'none'}"
            text = f"the mesh has no such physical curve, {known}"
            check_known(self.value, mesh.curves, f"{where}.direction.curve", SectionError, text)
            self._segments = mesh.curves[self.value]
        elif self.kind == "vector":
            vector = np.asarray(self.value, dtype=float)
            self._y2 = vector / np.linalg.norm(vector)
        elif self.kind != "circle":
            raise SectionError(
                f"{where}.direction: expected vector, circle, curve or cells, found {self.kind!r}"
                + did_you_mean(self.kind, ("vector", "circle", "curve", "cells"))
            )

    def at(self, x: Array) -> tuple[Array, Array]:
        """y2 (..., 2) and depth (...) at points x (..., 2); the depth has an unknown offset."""
        if self.kind == "vector":
            y3 = np.array([-self._y2[1], self._y2[0]])
            return np.broadcast_to(self._y2, x.shape), -(x @ y3)
        if self.kind == "circle":
            outward = x - np.asarray(self.value, dtype=float)
            depth = -np.linalg.norm(outward, axis=-1)
            y3 = -outward / depth[..., None]
        else:
            outward = nearest_on_curve(self._segments, x.reshape(-1, 2)).reshape(x.shape) - x
            depth = np.linalg.norm(outward, axis=-1)
            y3 = outward / np.maximum(depth, np.finfo(float).tiny)[..., None]
        return np.stack([y3[..., 1], -y3[..., 0]], axis=-1), depth


def _ply_index(
    plies: Any, depth: Array, direction: _Direction, nodes: Array, where: str
) -> NDArray[np.int64]:
    """Row of the ply at each depth."""
    if len(plies) == 1 and plies[0].get("thickness") is None:
        return np.zeros(depth.shape, dtype=np.int64)
    if not direction.given:
        raise SectionError(f"{where}.direction: missing, a laminate of plies needs one")
    _, at_nodes = direction.at(nodes)
    # a curve is the outer surface itself; otherwise the outermost node lies on it
    top = 0.0 if direction.kind == "curve" else float(at_nodes.min())
    wall = float(at_nodes.max()) - top
    given = [entry.get("thickness") for entry in plies]
    thickness = np.array(
        [wall / len(plies)] * len(plies) if given[0] is None else given, dtype=float
    )
    total = float(thickness.sum())
    tapers = direction.kind == "curve"
    if total < wall * (1 - THICKNESS) or (not tapers and total > wall * (1 + THICKNESS)):
        raise SectionError(
            f"{where}.plies: {len(plies)} plies are {total:.6g} m thick in all, expected the "
            f"{wall:.6g} m of the wall in the mesh"
        )
    faces = np.cumsum(thickness)[:-1]
    return np.searchsorted(faces, depth - top).astype(np.int64)
