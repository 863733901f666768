"""Geometric stiffness of the bodies of a run, and the doubts that follow from it.

The accelerations of a state are held while a body bends a little further. What its elastic forces
then gain beside K q is the geometric stiffness: of its own inertia loads and weight (Z0, Z1, G3),
and of the forces and moments at its markers (H). A stiffened body that has lost all its stiffness
buckles; a linear body whose geometric stiffness is not small should have been stiffened.
"""

from collections.abc import Iterator
from typing import Any

import numpy as np

from ..dynamics.bodies.second_order import stiffening_matrix
from ..dynamics.model import Model
from ..dynamics.system import accelerations, assemble
from ..math.arrays import Array
from ..math.rotations import rotation_matrix
from ..mechanism import BuiltMechanism, build
from ..monitors.spin import SpinMonitor
from ..signals.reactions import marker_loads
from ..signals.recover import stiffened
from .findings import Finding, finding

BUCKLING_CODE = "buckling-by-motion"
INDEFINITE_CODE = "stiffened-mass-indefinite"
MATTERS_CODE = "stiffening-matters"
MISSING_CODE = "stiffening-without-data"
MATTERS = 0.05  # largest eigenvalue of K^-1 Kg that a linear body may neglect
LOOKED_AT = 401  # states at most


def stiffening_findings(
    built: BuiltMechanism, mechanism: dict[str, Any], t: Array, y: Array
) -> list[Finding]:
    """Doubts about stiffened bodies, and about linear ones that ought to be, at states y (k, n)."""
    asked = bool(mechanism["solver"].get("geometric_stiffening", False))
    found = [_without_data(name) for name in _lacking(built)] if asked else []
    with_data = {n: p for n, p in built.packages.items() if p.second_order is not None}
    if not with_data:
        return found
    solver = {**mechanism["solver"], "geometric_stiffening": True}
    tables = built if asked else build({**mechanism, "solver": solver}, built.packages)
    some = np.unique(np.linspace(0, t.size - 1, LOOKED_AT).astype(int))
    spin = SpinMonitor(built.model, built.body_names, stop=False)
    for i, name in enumerate(built.body_names):
        if name not in with_data:
            continue
        if stiffened(built.model, i):
            found += _of_stiffened(built, tables.model, spin, i, t[some], y[some])
        else:
            found += _of_linear(built, tables.model, i, t[some], y[some])
    return found


def _lacking(built: BuiltMechanism) -> Iterator[str]:
    for name, package in built.packages.items():
        if package.second_order is None and package.n_mode:
            yield name


def _without_data(name: str) -> Finding:
    return finding(
        MISSING_CODE,
        f"{name}: geometric_stiffening was asked for, but the package of the body has no "
        "second-order data: the body stays linear. Beams of up to 16 modes have them since format "
        "1.3 of the package: build it again",
    )


def _of_stiffened(
    built: BuiltMechanism, tables: Model, spin: SpinMonitor, i: int, t: Array, y: Array
) -> list[Finding]:
    name = built.body_names[i]
    found: dict[str, str] = {}
    j, m = int(built.model.vel_start[i]), int(built.model.n_mode[i])
    for k in range(t.size):
        equations = assemble(built.model, t[k], y[k])
        if INDEFINITE_CODE not in found and not _definite(
            equations.M[j : j + 6 + m, j : j + 6 + m]
        ):
            found[INDEFINITE_CODE] = (
                f"{name}: at t = {t[k]:.4g} s the mass matrix of the body alone is not positive: "
                "it has moved too far from its frame for second-order displacements. A chord or "
                "mean-axis frame, or splitting the body, helps"
            )
        K, lost = spin.matrices(i, y[k])
        Kg = geometric_stiffness(built.model, tables, i, t[k], y[k])
        if BUCKLING_CODE not in found and np.linalg.eigvalsh(K - lost + Kg)[0] <= 0.0:
            found[BUCKLING_CODE] = (
                f"{name}: at t = {t[k]:.4g} s the loads of the motion and of the joints press the "
                "body so much that it has no stiffness left in one of its modes: it buckles, and "
                "second-order displacements do not follow it far. Split the body or stiffen it"
            )
    return [finding(code, text) for code, text in found.items()]


def _definite(M: Array) -> bool:
    """Tell whether a mass matrix, scaled to a unit diagonal, has no eigenvalue below round-off."""
    scale = 1.0 / np.sqrt(np.abs(np.diag(M)))
    return bool(np.linalg.eigvalsh(M * np.outer(scale, scale))[0] > -1e-12)


def _of_linear(built: BuiltMechanism, tables: Model, i: int, t: Array, y: Array) -> list[Finding]:
    model = built.model
    m, two = int(model.n_mode[i]), int(model.square_start[i])
    K = model.K_qq[two : two + m * m].reshape(m, m)
    values, vectors = np.linalg.eigh(K)
    if values[0] <= 1e-12 * values[-1]:
        return []
    scale = vectors / np.sqrt(values)
    largest, when = 0.0, 0.0
    for k in range(t.size):
        if not np.isfinite(y[k]).all():
            break
        Kg = scale.T @ geometric_stiffness(model, tables, i, t[k], y[k]) @ scale
        share = float(np.abs(np.linalg.eigvalsh(Kg)).max()) if np.isfinite(Kg).all() else 0.0
        if share > largest:
            largest, when = share, float(t[k])
    if largest <= MATTERS:
        return []
    text = (
        f"{built.body_names[i]}: at t = {when:.4g} s the geometric stiffness of the loads is "
        f"{largest:.2g} of the elastic one (a linear body neglects it: expected below "
        f"{MATTERS:g}): solver.geometric_stiffening = true takes it in"
    )
    return [finding(MATTERS_CODE, text)]


def geometric_stiffness(model: Model, tables: Model, i: int, t: float, y: Array) -> Array:
    """Return the geometric stiffness (m, m) of body i at time t and state y (n,) [N m].

    `tables` is a model of the same mechanism whose body i is of second order; accelerations and
    joint forces are those of `model`.
    """
    m, a, j = int(model.n_mode[i]), int(model.pos_start[i]), int(model.vel_start[i])
    equations = assemble(model, t, y)
    v_d, multipliers = accelerations(model, equations, y)
    A = rotation_matrix(y[a + 3 : a + 7])
    w = y[model.n_pos + j + 3 : model.n_pos + j + 6]
    pull = A.T @ (v_d[j : j + 3] - model.gravity_G)
    Kg = stiffening_matrix(tables, i, w, v_d[j + 3 : j + 6], pull, v_d[j + 6 : j + 6 + m])
    for marker, force, moment in marker_loads(model, t, y, equations.C, multipliers):
        start = int(tables.marker_second[marker])
        if model.marker_body[marker] == i and start >= 0:
            H = tables.marker_H[start : start + 6 * m * m].reshape(6, m, m)
            load_B = np.concatenate([A.T @ force, A.T @ moment])
            Kg = Kg - np.einsum("a,aij->ij", load_B, H)
    return np.asarray(0.5 * (Kg + Kg.T))
