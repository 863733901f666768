"""Whether modal damping means in the mechanism what it means for the body by itself."""

from typing import Any

import numpy as np

from ..dynamics.analysis.rank import free_motions
from ..dynamics.evaluation.dense_equations import assemble
from ..math.arrays import Array
from .finished import FinishedRun

MOST = 400  # velocity coordinates: the eigenproblem of more would be felt
# Share of the strain energy of a vibration that makes it one of a body: two like members of an arm
# have half each, so that a larger share would pass over their bending.
OWN = 0.25
RIGID = 1e-10  # eigenvalue of motions without strain, over the largest


def loaded_damping(run: FinishedRun) -> list[dict[str, Any]]:
    """Return, of each damped body, its damping ratio in the mechanism and by itself.

    Entries: `body`; `frequency_hz` and `damping_ratio` of the lowest vibration of the mechanism
    that is one of the body (more than a quarter of the strain energy); `own_frequency_hz` and
    `own_damping_ratio` of the mode that has most of it, of the body by itself. Vibrations are those
    of the mechanism at the start: elastic bodies with their joints and masses, drives held, without
    springs, weight and spin. Empty above 400 velocity coordinates.
    """
    packages, names = run.packages, run.built.body_names
    damped = [
        i for i, name in enumerate(names) if name in packages and packages[name].damping.any()
    ]
    if not damped or run.model.n_vel > MOST:
        return []
    found = _vibrations(run)
    if found is None:
        return []
    omega, shapes = found
    entries = []
    for i in damped:
        package = packages[names[i]]
        j = int(run.model.vel_start[i]) + 6
        q = shapes[j : j + package.n_mode]
        share = np.einsum("ak,ak->k", q, package.stiffness @ q) / omega**2
        of_body = np.flatnonzero(share > OWN)
        if not of_body.size:
            continue
        k = int(of_body[0])  # the lowest
        mode = int(np.argmax(q[:, k] ** 2 * np.diag(package.stiffness)))
        if not package.damping[mode, mode]:
            continue
        own = float(package.damping[mode, mode] / (2.0 * package.frequencies[mode]))
        loaded = float(q[:, k] @ package.damping @ q[:, k]) / (2.0 * float(omega[k]) * share[k])
        entries.append(
            {
                "body": names[i],
                "frequency_hz": float(omega[k]) / (2.0 * np.pi),
                "damping_ratio": float(loaded),
                "own_frequency_hz": float(package.frequencies[mode]) / (2.0 * np.pi),
                "own_damping_ratio": own,
            }
        )
    return entries


def _vibrations(run: FinishedRun) -> tuple[Array, Array] | None:
    """Return angular frequencies (v,), ascending, and velocities (n_vel, v) of unit modal mass.

    None if the mass matrix of the free motions is singular.
    """
    model = run.model
    equations = assemble(model, float(run.solution.t[0]), run.solution.y[0])
    Z = free_motions(equations, model.inertia_scale).Z
    K = np.zeros((model.n_vel, model.n_vel))
    for i, name in enumerate(run.built.body_names):
        if name in run.packages:
            j, package = int(model.vel_start[i]) + 6, run.packages[name]
            K[j : j + package.n_mode, j : j + package.n_mode] = package.stiffness
    try:
        inverse = np.linalg.inv(np.linalg.cholesky(Z.T @ equations.M @ Z))
    except np.linalg.LinAlgError:
        return None
    values, vectors = np.linalg.eigh(inverse @ (Z.T @ K @ Z) @ inverse.T)
    elastic = values > RIGID * values[-1]
    return np.sqrt(values[elastic]), (Z @ inverse.T @ vectors)[:, elastic]
