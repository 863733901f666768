"""Stresses at the surface of a solid in modes and load cases, and the work of second-order strains.

Surface stresses are in the axes of the materials."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import ufl

from ...solver.math.arrays import Array
from ...solver.package.body.package_schema import FaceStresses
from ...solver.package.common.materials import bond
from ..modes.reduced import pairs
from .forms import strain
from .model import SolidModel
from .solid_mesh import derivatives, face_centre

BITS = 16  # of the largest value of a mode: an error below 8e-6 of it, small files


def rounded(values: Array, axes: tuple[int, ...]) -> Array:
    """Values to the last of `BITS` below the largest along axes."""
    largest = np.abs(values).max(axis=axes, keepdims=True)
    last = np.ldexp(1.0, np.frexp(largest)[1] - 1 - BITS)
    return np.asarray(np.round(values / last) * last)


def face_stress(model: SolidModel, u: Array) -> Array:
    """Stress 11 22 33 23 13 12 in material axes at the middle of all outer faces, (f, 6, m) [Pa].

    Parameters
    ----------
    u : (n, 3, m) displacements of the nodes [m]
    """
    mesh = model.mesh
    plain, A_BM = mesh.plain, face_axes(model)
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
        C_M, T = model.materials.C_M[mesh.owner[own]], bond(A_BM[own])
        out[own] = C_M @ T.transpose(0, 2, 1) @ e
    return out


def face_axes(model: SolidModel) -> Array:
    """Axes A_BM (f, 3, 3) of the material at the middle of all outer faces."""
    mesh = model.mesh
    return model.materials.axes(mesh.plain.points[mesh.faces].mean(axis=1), mesh.owner)


def face_stresses(
    model: SolidModel, materials: Mapping[str, Any], u: Array, cases: Mapping[str, Array]
) -> FaceStresses:
    """Stresses of all outer faces in modes and in load cases.

    Parameters
    ----------
    model : the solid
    materials : tables of its description, by name
    u : (n, 3, m) modes
    cases : displacements (n, 3) by load case [m]
    """
    mesh, names = model.mesh, sorted(set(model.materials.names))
    of_region = np.array([names.index(name) for name in model.materials.names])
    held = face_stress(model, np.stack([*cases.values()], axis=2)) if cases else None
    return FaceStresses(
        cell=np.arange(len(mesh.faces)),
        material=of_region[mesh.plain.region[mesh.owner]],
        A_BM=face_axes(model),
        stress_M=rounded(face_stress(model, u), (0, 1)),
        materials={name: dict(materials[name]) for name in names},
        cases=tuple(cases),
        case_stress_M=None if held is None else rounded(np.moveaxis(held, 2, 0), (1, 2)),
    )


def second_order_forces(model: SolidModel, U: Array) -> Array:
    """Forces g of each pair of modes i <= j, (3 n, pairs): see exchange/inertia.py.

    Parameters
    ----------
    U : (3 n, m) displacements of the nodes in the modes
    """
    space = model.space
    v, one, other = ufl.TestFunction(space.space), space.field(), space.field()
    product = ufl.sym(ufl.grad(one).T * ufl.grad(other))
    vector = space.vectors(model.elasticity(space).work(strain(v), product))
    forces = np.empty((len(U), len(pairs(U.shape[1])[0])))
    for k, (i, j) in enumerate(zip(*pairs(U.shape[1]), strict=True)):
        space.fill(one, U[:, i].reshape(-1, 3))
        space.fill(other, U[:, j].reshape(-1, 3))
        forces[:, k] = vector()
    return forces
