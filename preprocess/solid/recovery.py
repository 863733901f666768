"""Stress at the surface of a solid in its modes.

A free surface carries no traction, so its three stresses in the plane of the surface are all. They
are stored as the forces of a thin skin of one ply: strength, its history, the report and ParaView
treat the surface of a solid as they treat a shell. The skin has neither stiffness nor mass.
"""

from typing import Any, NamedTuple

import numpy as np

from ...solver.math.arrays import Array, IntArray
from ...solver.package.body.schema import CellResultants, LaminateData
from ...solver.package.section.recovery_data import rounded
from ..laminate import laminate_from_dict, laminate_stiffness
from ..materials import bond, material_from_dict
from .cells import derivatives, face_centre
from .model import SolidModel

SKIN = 1e-3  # thickness of the skin [m]
STEEP = 0.9  # cosine between normal and x above which e1 follows y


class Surface(NamedTuple):
    """Outer faces of a solid as flat cells, and what a package has for their stresses."""

    corners: IntArray  # (f, 3 or 4)
    laminates: tuple[LaminateData, ...]
    cells: CellResultants | None


def face_stress(model: SolidModel, u: Array) -> Array:
    """Stress 11 22 33 23 13 12 in body axes at the middle of all outer faces, (f, 6, m) [Pa].

    Parameters
    ----------
    u : (n, 3, m) displacements of the nodes [m]
    """
    mesh = model.mesh
    plain = mesh.plain
    out = np.empty((len(mesh.faces), 6, u.shape[2]))
    for number in np.unique(mesh.local):
        own = np.flatnonzero(mesh.local == number)
        slope = derivatives(plain.cell, face_centre(plain.cell, int(number)))  # (3, k)
        cells = plain.cells[mesh.owner[own]]
        J = np.einsum("ak,ckx->cax", slope, plain.points[cells])
        gradient = np.linalg.solve(
            J, np.einsum("ak,ckum->caum", slope, u[cells]).reshape(len(own), 3, -1)
        ).reshape(len(own), 3, 3, -1)  # d u_b / d x_a
        e = np.stack(
            [gradient[:, k, k] for k in range(3)]
            + [gradient[:, a, b] + gradient[:, b, a] for a, b in ((1, 2), (0, 2), (0, 1))],
            axis=1,
        )
        out[own] = np.einsum("cij,cjm->cim", model.materials.C[mesh.owner[own]], e)
    return out


def face_axes(model: SolidModel) -> Array:
    """Axes of the outer faces, (f, 3, 3): e3 outwards, e1 along x or y of the body."""
    x = model.mesh.plain.points[model.mesh.corners]
    normal = np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    first = np.where(np.abs(normal[:, :1]) < STEEP, [[1.0, 0.0, 0.0]], [[0.0, 1.0, 0.0]])
    first = first - np.einsum("fi,fi->f", first, normal)[:, None] * normal
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    return np.stack([first, np.cross(normal, first), normal], axis=2)


def surface(model: SolidModel, materials: dict[str, Any], u: Array) -> Surface:
    """Cells and stresses of the surface in modes u (n, 3, m).

    Faces of orthotropic regions have no recovery: their strengths belong to material axes that
    need not lie in the surface.
    """
    mesh, names = model.mesh, model.materials.names
    used = [name for name in dict.fromkeys(names) if materials[name]["kind"] == "isotropic"]
    number = np.array([used.index(name) if name in used else -1 for name in names])
    of_face = number[mesh.plain.region[mesh.owner]]
    own = np.flatnonzero(of_face >= 0)
    if not len(own):
        return Surface(mesh.corners, (), None)
    axes = face_axes(model)[own]
    stress = np.einsum("fij,fjm->fim", bond(axes.transpose(0, 2, 1)), face_stress(model, u)[own])
    resultants = np.zeros((len(own), 8, u.shape[2]))
    resultants[:, :3] = SKIN * stress[:, [0, 1, 5]]
    laminates = []
    for name in used:
        spec = laminate_from_dict(
            {"plies": [{"material": name, "angle_deg": 0.0, "thickness": SKIN}]},
            {name: material_from_dict(materials[name], name)},
            name,
        )
        stiffness = laminate_stiffness(spec.laminate, spec.shear)
        laminates.append(spec.data(f"surface {name}", stiffness, materials))
    found = CellResultants(own, of_face[own], axes, rounded(resultants))
    return Surface(mesh.corners, tuple(laminates), found)
