"""A shell body for package tests: a lumped cantilever strip of triangles, from its own sums."""

import dataclasses

import numpy as np
from samples.package_samples import cantilever
from samples.recovery_samples import STEEL, STEEL_STRENGTH

from plymotion.solver.package import Interface, ModalPackage, from_stations
from plymotion.solver.package.body.package_schema import CellResultants, FaceStresses, LaminateData
from plymotion.solver.package.common.recovery_schema import ShellPly

WIDTH, THICKNESS = 0.08, 0.01
E = STEEL["E"]


def steel_laminate() -> LaminateData:
    """One ply of steel in which nothing contracts across: closed forms for every number."""
    h, half = THICKNESS, 0.5 * THICKNESS
    stiffness = E * np.diag([1.0, 1.0, 0.5])
    ABD = np.zeros((6, 6))
    ABD[:3, :3], ABD[3:, 3:] = h * stiffness, h**3 / 12.0 * stiffness
    stress_M = np.zeros((1, 3, 6, 8))
    for level, z in enumerate((-half, 0.0, half)):
        for row, column in ((0, 0), (1, 1), (5, 2)):
            stress_M[0, level, row, column] = 1.0 / h
            stress_M[0, level, row, 3 + column] = 12.0 * z / h**3
        stress_M[0, level, 4, 6] = stress_M[0, level, 3, 7] = 1.5 / h * (1.0 - (z / half) ** 2)
    materials = {"steel": {**STEEL, "strength": STEEL_STRENGTH}}
    Ds = 5.0 / 6.0 * E / 2.0 * h * np.eye(2)
    plies = (ShellPly("steel", 0.0, -half, half),)
    return LaminateData("wall", plies, ABD, Ds, stress_M, materials)


def panel(n: int = 17, m: int = 3, length: float = 1.5) -> ModalPackage:
    """Strip of 2 (n - 1) triangles in z = 0, polynomial bending out of its plane."""
    x, y = (
        part.ravel()
        for part in np.meshgrid(np.linspace(0.0, length, n), [0.0, WIDTH], indexing="ij")
    )
    nodes = np.column_stack([x, y, np.zeros(2 * n)])
    a = 2 * np.arange(n - 1)
    cells = np.concatenate([np.stack([a, a + 2, a + 3], 1), np.stack([a, a + 3, a + 1], 1)])
    laminate = steel_laminate()
    EI = E * WIDTH * THICKNESS**3 / 12.0
    s, node_mass = x / length, np.full(2 * n, 2.43 / (2 * n))
    inertia = np.einsum("k,ab->kab", node_mass, 8e-6 * np.eye(3))
    shapes, K = np.zeros((m, 2 * n, 6)), np.zeros((m, m))
    middle = nodes[cells].mean(axis=1)[:, 0] / length
    resultants = np.zeros((len(cells), 8, m))
    for i in range(m):
        p = i + 2
        shapes[i, :, 2] = s**p
        shapes[i, :, 4] = -p * s ** (p - 1) / length
        curvature = -p * (p - 1) * middle ** (p - 2) / length**2
        resultants[:, 3, i] = laminate.ABD[3, 3] * curvature
        for j in range(m):
            r = j + 2
            K[i, j] = EI * p * (p - 1) * r * (r - 1) / (p + r - 3) / length**3
    M = np.einsum("k,ika,jka->ij", node_mass, shapes[..., :3], shapes[..., :3])
    M += np.einsum("ika,kab,jkb->ij", shapes[..., 3:], inertia, shapes[..., 3:])
    L_inv = np.linalg.inv(np.linalg.cholesky(M))
    values, vectors = np.linalg.eigh(L_inv @ K @ L_inv.T)
    X = L_inv.T @ vectors
    shapes = np.einsum("ij,ikd->jkd", X, shapes)
    phi, psi = (np.moveaxis(part, 0, 2) for part in (shapes[..., :3], shapes[..., 3:]))
    ids, tip = 5 + np.arange(2 * n), np.array([2 * n - 2, 2 * n - 1])
    return dataclasses.replace(
        cantilever(n, m),
        body="panel",
        nodes_B=nodes,
        node_ids=ids,
        connectivity=cells.ravel(),
        offsets=np.arange(0, 3 * len(cells) + 1, 3),
        cell_types=np.full(len(cells), 5),
        shapes_B=shapes,
        frequencies=np.sqrt(values),
        mass=np.eye(m),
        stiffness=np.diag(values),
        node_mass=node_mass,
        node_inertia_B=inertia,
        invariants=from_stations(node_mass, nodes, phi, psi, inertia, "lumped"),
        interfaces=(
            Interface(
                "tip",
                "average",
                ids[tip],
                np.full(2, 0.5),
                nodes[tip].mean(axis=0),
                np.eye(3),
                phi[tip].mean(axis=0),
                psi[tip].mean(axis=0),
            ),
        ),
        sections=(),
        recovery=None,
        second_order=None,
        compliance=None,
        laminates=(laminate,),
        cell_resultants=CellResultants(
            np.arange(len(cells)),
            np.zeros(len(cells), dtype=np.int64),
            np.tile(np.eye(3), (len(cells), 1, 1)),
            resultants @ X,
        ),
        mode_labels=tuple(f"along z {i + 1}" for i in range(m)),
    )


def with_face_stresses() -> ModalPackage:
    """The same nodes and modes with the stresses at the top of the strip, as a solid has them."""
    shell = panel()
    cells, laminate = shell.cell_resultants, shell.laminates[0]
    assert cells is not None
    stress = laminate.stress_M[0, 2] @ cells.resultants_E
    faces = FaceStresses(
        cells.cell,
        cells.laminate,
        cells.A_BE,
        stress,
        laminate.materials,
        ("lift",),
        stress[..., 0][None],
    )
    return dataclasses.replace(shell, laminates=(), cell_resultants=None, face_stresses=faces)
