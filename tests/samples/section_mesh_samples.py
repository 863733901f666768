"""Meshes of the library's sections, and their moments by quadrature."""

from typing import Any

import numpy as np

from plymotion.preprocess import fenicsx
from plymotion.preprocess.section.space.section_cells import KINDS as CELL_KINDS
from plymotion.preprocess.section.space.section_cells import full_basis
from plymotion.preprocess.section.space.section_mesh import SectionMesh, section_mesh
from plymotion.solver.inputs.section.shapes.library import expand
from plymotion.solver.math.arrays import Array

ISOTROPIC = {"kind": "isotropic", "E": 1.0, "nu": 0.3, "rho": 1.0}


CFRP = {
    "kind": "orthotropic",
    **{"E1": 1.42e11, "E2": 9.8e9, "E3": 9.8e9, "G12": 6e9, "G13": 6e9, "G23": 4.8e9},
    **{"nu12": 0.42, "nu13": 0.42, "nu23": 0.42, "rho": 1600.0},
}


SIZES: dict[str, dict[str, Any]] = {
    "rectangle": {"width": 0.06, "height": 0.015},
    "strip": {"width": 0.06, "height": 0.002},
    "split-rectangle": {"width": 0.1, "height": 0.08, "interface": 0.02},
    "ellipse": {"radius_2": 0.02, "radius_3": 0.01},
    "tube": {"outer_radius": 0.1, "wall": 0.01},
    "box": {"width": 0.03, "height": 0.02, "wall": 0.001, "wall_left": 0.002, "wall_top": 0.0015},
    "two-cell": {"width": 0.05, "height": 0.02, "web_position": 0.01, "wall": 0.001},
    "i": {"height": 0.2, "top_width": 0.1, "bottom_width": 0.08, "wall": 0.01, "wall_web": 0.006},
    "channel": {"height": 0.025, "top_width": 0.012, "bottom_width": 0.025, "wall": 0.0015},
    "polyline": {"x2": [0.0, 0.05, 0.05, 0.0], "x3": [0.1, 0.1, 0.0, 0.0], "wall": 0.002},
    "airfoil": {"contour": "naca4415", "chord": 0.3, "skin": 0.001, "webs": [0.2, 0.5]},
}


def library(name: str, **sizes: Any) -> SectionMesh:
    return section_mesh(expand(name, {**SIZES[name], **sizes}), f"{name}.mesh")


def moments(mesh: SectionMesh) -> Array:
    """Area, first and second moments by quadrature on the cells' own map."""
    ((kind, _),), (corners,) = mesh.cells.of_kinds, mesh.cells.shapes
    points, weights = fenicsx.quadrature(CELL_KINDS[kind], 8)
    values, slopes = full_basis(kind, points)
    x, y = np.moveaxis(values @ corners, -1, 0)
    jacobian = np.einsum("cka,qkg->cqag", corners, slopes)
    dA = weights * np.abs(np.linalg.det(jacobian))
    return np.array([np.sum(dA * f) for f in (1.0, x, y, x * x, y * y, x * y)])


def nodes_of(mesh: SectionMesh, region: str) -> Array:
    """Nodes of the cells of a region, (c, k, 2)."""
    (corners,) = mesh.cells.shapes
    return corners[mesh.cells.region == mesh.cells.regions.index(region)]
