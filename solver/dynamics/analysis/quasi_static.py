"""Quasi-static deformation of bodies by the loads of a motion, which they follow as if rigid."""

from contextlib import suppress

import numpy as np

from ...math.arrays import Array
from ..elements.constraints.treatment import scaled_jacobian
from ..evaluation.accelerations import assemble
from ..evaluation.elimination import is_tree
from ..evaluation.series import along_solution
from ..model.model import Model, modal_matrix
from ..tolerances import RANK_TOLERANCE, STANDS_STILL, WITHOUT_STRAIN
from .rank import free_motions, rank_of

# Modal mass over that of the model: bodies then move as if rigid. The inertia that the first of 16
# segments carries is 1e7 of its modal mass; beyond 1e16, nothing changes up to rounding.
_HEAVY = 1e14


def quasi_static_deformations(model: Model, t: float, y: Array) -> list[Array]:
    """Return, for each body, the change of its modal coordinates (m,) that its loads call for.

    The mechanism moves from state y (n,) with the shapes that its bodies have there. The loads
    on the modes are those of this motion: weight, forces, inertia, and reactions of the joints.
    The change is K^-1 times these loads; of a body in static equilibrium it is zero.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    t : time [s]
    y : state (n,), as in dynamics/model/model.py
    """
    return _deformations(model, _heavy(model, t, y), t, y)


def _deformations(model: Model, heavy: Model, t: float, y: Array) -> list[Array]:
    rates, _ = along_solution(heavy, np.array([t]), y[None, :])
    deformations: list[Array] = []
    for i in range(model.n_body):
        loads = modal_matrix(model, heavy.M_qq, i) @ rates[0, model.n_pos :][_modes(model, i)]
        deformations.append(np.asarray(np.linalg.solve(modal_matrix(model, model.K_qq, i), loads)))
    return deformations


def _heavy(model: Model, t: float, y: Array) -> Model:
    """Return the model whose bodies move from state y as if rigid."""
    heavy = model._replace(M_qq=_HEAVY * model.M_qq, alpha=0.0, beta=0.0, penalty=0.0)
    if model.n_constraint and not is_tree(model):  # a planar loop of hinges has dependent rows
        C = scaled_jacobian(assemble(model, t, y).Phi_q, model.inertia_scale)
        s = np.linalg.svd(C, compute_uv=False)
        rank = int(np.sum(s > RANK_TOLERANCE * s[0]))
        heavy = heavy._replace(redundant=model.n_constraint - rank)
    return heavy


_STEP = 0.1  # over the least frequency: the loads of a slow motion change by little
MOST = 400  # velocity coordinates: the eigenproblem of more would be felt


def quasi_static_rates(model: Model, t: float, y: Array) -> tuple[list[Array], float]:
    """Return the modal rates (m,) of each body whose shapes follow the loads of a motion.

    They are the changes of `quasi_static_deformations` along two short steps of the motion that
    begins in state y (n,) with shapes at rest. Then how much they change from one step to the
    next, of the rates in the norm of the strain energy: much beside stiff springs and dampers,
    friction, and loads that begin.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    t : time [s]
    y : state (n,), as in dynamics/model/model.py
    """
    heavy, slowest = _heavy(model, t, y), 0.0
    for i in np.flatnonzero(model.n_mode[: model.n_body]).tolist():
        K, M = (modal_matrix(model, flat, i) for flat in (model.K_qq, model.M_qq))
        slowest = max(slowest, float(np.linalg.eigvals(np.linalg.solve(K, M)).real.max()))
    if model.n_vel <= MOST:  # with what the bodies carry
        equations = assemble(model, t, y)
        with suppress(np.linalg.LinAlgError):  # a free motion moves no mass
            Z = free_motions(equations, model.inertia_scale).Z
            values = vibrations(model, Z, equations.M)[1]
            elastic = values[values > WITHOUT_STRAIN * values.max(initial=0.0)]
            slowest = max(slowest, 1.0 / float(elastic.min(initial=np.inf)))
    h, z = _STEP * np.sqrt(slowest), y
    shapes = [_deformations(model, heavy, t, y)]
    for begin in (t, t + h):
        slopes: list[Array] = []
        for part in (0.0, 0.5, 0.5, 1.0):  # Runge and Kutta's method
            at = z + part * h * slopes[-1] if slopes else z
            rates, _ = along_solution(heavy, np.array([begin + part * h]), at[None, :])
            slopes.append(np.asarray(rates[0]))
        z = z + h / 6.0 * (slopes[0] + 2.0 * (slopes[1] + slopes[2]) + slopes[3])
        shapes.append(_deformations(model, heavy, begin + h, z))
    size, changed, found = 0.0, 0.0, list[Array]()
    for i, (one, two, three) in enumerate(zip(*shapes, strict=True)):
        first, second, K = (two - one) / h, (three - two) / h, modal_matrix(model, model.K_qq, i)
        size += float(first @ K @ first)
        changed += float((second - first) @ K @ (second - first))
        found.append(1.5 * first - 0.5 * second)
    return found, float(np.sqrt(changed / size)) if size > 0.0 else 0.0


def motions_without_strain(model: Model, t: float, y: Array) -> int:
    """Return how many independent motions the joints leave to bodies that do not deform.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    t : time [s]
    y : state (n,), as in dynamics/model/model.py
    """
    frames = np.ravel(np.asarray(model.vel_start)[: model.n_body, None] + np.arange(6))
    Phi_q = assemble(model, t, y).Phi_q[:, frames]
    if not Phi_q.size:
        return int(frames.size)
    C = scaled_jacobian(Phi_q, model.inertia_scale[frames])
    s: Array = np.asarray(np.linalg.svd(C, compute_uv=False), dtype=float)
    return int(frames.size) - rank_of(s, len(Phi_q)).value


def quasi_static_deformations_of_loops(model: Model, t: float, y: Array, rigid: int) -> list[Array]:
    """Return `quasi_static_deformations` that keep the joints of an over-constrained loop closed.

    What such joints share of a load follows from the deformation of the bodies: by the joints of
    bodies that hold their shape it is not determined, and no motion is left once they have
    deformed. So the shapes change along vibrations of the mechanism. The `rigid` slowest of them
    are its motion: see `motions_without_strain`, of a state before the deformation. Dense.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    t : time [s]
    y : state (n,), as in dynamics/model/model.py
    rigid : number of vibrations that are the motion of the mechanism
    """
    equations = assemble(model, t, y)
    motions, M = free_motions(equations, model.inertia_scale), equations.M
    K, values, X = vibrations(model, motions.Z, M)
    X, stiffness = X[:, rigid:], values[rigid:]
    a = motions.P @ equations.gamma  # what joints and drives prescribe, with least deformation
    a -= X @ ((X.T @ (K @ a)) / stiffness)
    change = X @ ((X.T @ (equations.f - M @ a)) / stiffness)
    return [np.asarray(change[_modes(model, i)]) for i in range(model.n_body)]


def vibrations(model: Model, Z: Array, M: Array) -> tuple[Array, Array, Array]:
    """Return the stiffness of the modes of all bodies, and the vibrations with it.

    Z (n_vel, f) are the motions that the joints leave free, M (n_vel, n_vel) is the mass. Stiffness
    (n_vel, n_vel); squared angular frequencies (f,), ascending; velocities (n_vel, f) of unit mass.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    Z : free motions (n_vel, f)
    M : mass matrix (n_vel, n_vel)

    Raises
    ------
    numpy.linalg.LinAlgError
        A free motion moves no mass.
    """
    K = np.zeros((model.n_vel, model.n_vel))
    for i in range(model.n_body):
        K[_modes(model, i), _modes(model, i)] = modal_matrix(model, model.K_qq, i)
    root = np.linalg.inv(np.linalg.cholesky(Z.T @ M @ Z))
    values, vectors = np.linalg.eigh(root @ (Z.T @ K @ Z) @ root.T)
    return K, values, Z @ root.T @ vectors


def _modes(model: Model, i: int) -> slice:
    """Return the modal rates of body i among the velocities."""
    first = int(model.vel_start[i]) + 6
    return slice(first, first + int(model.n_mode[i]))


def is_moving(model: Model, y: Array) -> bool:
    """Return whether a body moves in state y (n,): speed above 1e-9 [m/s, rad/s, 1/s]."""
    velocities = y[model.n_pos : model.n_pos + model.n_vel]
    return bool(np.max(np.abs(velocities), initial=0.0) > STANDS_STILL)
