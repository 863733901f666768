"""Whether modal damping means in the mechanism what it means for the body by itself."""

from collections.abc import Iterator

import numpy as np

from ..dynamics.null_space import free_motions
from ..dynamics.system import assemble
from ..math.arrays import Array
from ..results.codes.motion import LOADED_DAMPING
from ..results.finding import Finding
from .finished import FinishedRun

MOST = 400  # velocity coordinates: the eigenproblem of more would be felt
OWN = 0.5  # share of the strain energy of a vibration that makes it that of a body
RIGID = 1e-10  # eigenvalue of motions without strain, over the largest


def damping_findings(run: FinishedRun) -> Iterator[Finding]:
    """Yield the body whose damping ratio changes most by what it carries, if it does much.

    Vibrations are those of the mechanism at the start: elastic bodies with their joints and
    masses, drives held, without springs, weight and spin.
    """
    packages, names = run.packages, run.built.body_names
    damped = [
        i for i, name in enumerate(names) if name in packages and packages[name].damping.any()
    ]
    if not damped or run.model.n_vel > MOST:
        return
    found = _vibrations(run)
    if found is None:
        return
    omega, shapes = found
    most, finding = LOADED_DAMPING.limit, None
    for i in damped:
        package = packages[names[i]]
        j = int(run.model.vel_start[i]) + 6
        q = shapes[j : j + package.n_mode]
        share = np.einsum("ak,ab,bk->k", q, package.stiffness, q) / omega**2
        own = np.flatnonzero(share > OWN)
        if not own.size:
            continue
        k = int(own[0])  # the lowest
        energies = q[:, k] ** 2 * np.diag(package.stiffness)
        mode = int(np.argmax(energies))
        by_itself = float(package.damping[mode, mode] / (2.0 * package.frequencies[mode]))
        loaded = float(q[:, k] @ package.damping @ q[:, k]) / (2.0 * float(omega[k]) * share[k])
        if not (loaded > 0.0 and by_itself > 0.0):
            continue
        change = min(loaded / by_itself, by_itself / loaded)
        if change < most:
            most = change
            finding = _finding(names[i], by_itself, package.frequencies[mode], loaded, omega[k])
    if finding is not None:
        yield finding


def _finding(body: str, own: float, of: float, loaded: float, omega: float) -> Finding:
    to_hertz = 0.5 / np.pi
    text = (
        f"{body}: its lowest vibration in the mechanism has {omega * to_hertz:.3g} Hz and gets a "
        f"damping ratio of {loaded:.2g} from it; {own:.2g} is that of its mode of "
        f"{of * to_hertz:.3g} Hz by itself. To have {own:.2g} in the mechanism, set damping_ratio "
        f"= {own * own / loaded:.2g}"
    )
    return LOADED_DAMPING.finding(
        text, body=body, t=0.0, value=float(min(loaded / own, own / loaded))
    )


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
