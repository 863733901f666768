"""A body for package tests: a lumped cantilever whose numbers all come from its own sums."""

import dataclasses

import numpy as np
from samples.recovery_samples import PLY, PLY_STRENGTH, plies_of, rectangle_recovery

from plymotion.solver.package import Interface, ModalPackage, SectionData, from_stations
from plymotion.solver.package.body.invariants import second_order_from_stations
from plymotion.solver.package.body.package_schema import BodyRecovery

EI = 5.6e4


def cantilever(n: int = 17, m: int = 4, length: float = 1.5) -> ModalPackage:
    """Clamped bar of lumped masses, polynomial shapes, orthonormal in its own mass."""
    x = np.linspace(0.0, length, n)
    nodes = np.column_stack([x, 0.02 * x**2, np.zeros(n)])
    node_mass = np.full(n, 2.43 / n)
    inertia = np.einsum("k,ab->kab", node_mass, np.diag([8e-4, 6e-4, 3e-4]))
    s = x / length
    shapes = np.zeros((m, n, 6))
    for i in range(m):
        shapes[i, :, 1] = s ** (i + 2)
        shapes[i, :, 5] = (i + 2) * s ** (i + 1) / length
    K = np.zeros((m, m))
    for i in range(m):
        for j in range(m):  # integral of EI v_i'' v_j''
            a, b = i + 2, j + 2
            K[i, j] = EI * a * (a - 1) * b * (b - 1) / (a + b - 3) / length**3
    M = np.einsum("k,ika,jka->ij", node_mass, shapes[..., :3], shapes[..., :3])
    M += np.einsum("ika,kab,jkb->ij", shapes[..., 3:], inertia, shapes[..., 3:])
    resultants = np.zeros((n, 6, m))
    for i in range(m):
        a = i + 2
        resultants[:, 5, i] = EI * a * (a - 1) * s ** (a - 2) / length**2
        if a > 2:
            resultants[:, 1, i] = -EI * a * (a - 1) * (a - 2) * s ** (a - 3) / length**3
    L_inv = np.linalg.inv(np.linalg.cholesky(M))
    values, vectors = np.linalg.eigh(L_inv @ K @ L_inv.T)
    X = L_inv.T @ vectors
    shapes = np.einsum("ij,ikd->jkd", X, shapes)
    h = np.zeros((n, 3, m, m))  # drawn in by bending: - integral of v_i' v_j'
    for i in range(m):
        for j in range(m):
            a, b = i + 2, j + 2
            h[:, 0, i, j] = -a * b * s ** (a + b - 1) / (a + b - 1) / length
    h = np.einsum("kapq,pi,qj->kaij", h, X, X)
    h = 0.5 * (h + h.swapaxes(2, 3))
    plies = plies_of(("cfrp", 0.0), ("cfrp", 45.0), ("cfrp", 0.0))
    materials = {"cfrp": {**PLY, "strength": PLY_STRENGTH}}
    phi, psi = (np.moveaxis(part, 0, 2) for part in (shapes[..., :3], shapes[..., 3:]))
    ids = 10 + np.arange(n)
    F = [np.vstack([phi[k], psi[k]]) for k in (0, n - 1)]
    fields = np.concatenate([nodes, np.ones((n, 1))], axis=1)
    F.append(np.einsum("k,kb,kai->abi", node_mass, fields, phi).reshape(12, m))
    loads = np.vstack(F)
    compliance = loads @ np.diag(1.0 / values) @ loads.T
    ends = [("base", 0), ("tip", n - 1)]
    return ModalPackage(
        body="arm",
        nodes_B=nodes,
        node_ids=ids,
        connectivity=np.column_stack([np.arange(n - 1), np.arange(1, n)]).ravel(),
        offsets=np.arange(0, 2 * n, 2),
        cell_types=np.full(n - 1, 3),
        shapes_B=shapes,
        mode_kinds=("fixed_normal",) * m,
        frequencies=np.sqrt(values),
        mass=np.eye(m),
        stiffness=np.diag(values),
        damping=np.zeros((m, m)),
        node_mass=node_mass,
        node_inertia_B=inertia,
        invariants=from_stations(node_mass, nodes, phi, psi, inertia, "lumped"),
        interfaces=tuple(
            Interface(
                name=name,
                kind="node",
                node_ids=ids[[k]],
                weights=np.ones(1),
                position_B=nodes[k],
                A_BI=np.eye(3),
                phi_B=phi[k],
                psi_B=psi[k],
                H_B=h[k],
                H_psi_B=np.zeros((3, m, m)),
            )
            for name, k in ends
        ),
        reference_condition="clamped",
        sections=(
            SectionData(
                "bar",
                np.diag([1e8, 3e7, 3e7, 2e4, 5e4, EI]),
                np.eye(6),
                "plies = 3",
                rectangle_recovery(0.06, 0.03, plies, materials),
                np.diag([2e-10, 1e-9, 1e-9, 1e-6, 8e-7, 3e-7]),
            ),
        ),
        recovery=BodyRecovery(x, np.zeros(n, dtype=np.int64), resultants @ X, np.eye(3)),
        mode_labels=tuple(f"bending-xy {i + 1}" for i in range(m)),
        second_order=second_order_from_stations(node_mass, nodes, phi, h, nodes[:, 0]),
        compliance=0.5 * (compliance + compliance.T),
        provenance={"tools": {"numpy": np.__version__}, "ranks": 1},
    )


def same(a: object, b: object) -> bool:
    """Compare dataclasses of arrays, values exactly."""
    if dataclasses.is_dataclass(a):
        names = [f.name for f in dataclasses.fields(a)]
        return type(a) is type(b) and all(same(getattr(a, n), getattr(b, n)) for n in names)
    if isinstance(a, tuple):
        return isinstance(b, tuple) and len(a) == len(b) and all(map(same, a, b))
    if isinstance(a, dict):
        return isinstance(b, dict) and a.keys() == b.keys() and all(same(a[k], b[k]) for k in a)
    if isinstance(a, np.ndarray):
        return np.asarray(b).shape == a.shape and np.array_equal(a, b)
    return a == b
