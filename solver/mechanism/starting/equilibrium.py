"""Static equilibrium: positions in which a mechanism stays at rest under its loads.

Newton's method for the independent positions: Z'(f - Phi_q' lambda) = 0, where the
columns of Z span the null space of Phi_q. The joints are closed again after each step. If
the stiffness has a negative eigenvalue, the step still reduces the potential energy. The search
therefore ends in a minimum, not in an unstable equilibrium. Following loads have no potential; for
them, the work along the step is used.
"""

from dataclasses import replace

import numpy as np

from ...dynamics.analysis.rank import free_motions
from ...dynamics.evaluation.dense_equations import Equations, assemble
from ...dynamics.evaluation.events import started
from ...dynamics.evaluation.laws import law_values, with_laws
from ...dynamics.model.coordinates import moved
from ...dynamics.model.model import Model
from ...errors import InputError
from ...math.arrays import Array
from ..consistent.initial import Start

_TOLERANCE = (
    1e-10  # tolerance of the unbalanced accelerations, relative to the largest due to the loads
)
_NEUTRAL = 1e-6  # [1/s2] stiffness over inertia that is treated as zero
_MAX_STEP = 0.3  # [m, rad, modes]
_MAX_ITERATIONS = 200
_NUDGE = 0.05  # [m, rad, modes] step away from an unstable equilibrium
_CLOSED = 1e-12
_DIFFERENCE = 1e-6  # [m, rad, modes] increment for the stiffness by finite differences


def resting_state(model: Model, start: Start, body_names: list[str]) -> tuple[Model, Array]:
    """Return the state y (n,) at rest in static equilibrium, and the model with laws that hold it.

    Drives and loads keep what they have at t = 0.

    Raises
    ------
    InputError
        As `equilibrium`.
    """
    found = equilibrium(model, start, body_names)
    values = law_values(model, 0.0)
    values[:, 1:] = 0.0
    still = with_laws(model, 0.0, values)
    return still, started(still, 0.0, resting(model, found.positions, np.zeros(model.n_vel)))


def equilibrium(model: Model, start: Start, body_names: list[str], t: float = 0.0) -> Start:
    """Return the start with positions of static equilibrium at time t; velocities do not change.

    Gravity, springs, bushings and loads have their values at t; drives keep their positions
    at t.

    Raises
    ------
    InputError
        No equilibrium found, or joints cannot be closed; names the body with unbalanced forces.
    """
    positions = closed(model, start.positions, t)
    largest = 0.0
    for _ in range(_MAX_ITERATIONS):
        here = _Balance(model, positions, t)
        largest = max(largest, float(np.max(np.abs(here.equations.f) / model.inertia_scale)))
        K = here.stiffness(positions)
        stiffness, directions = np.linalg.eigh(0.5 * (K + K.T))
        if np.max(np.abs(here.push), initial=0.0) <= _TOLERANCE * max(largest, 1e-12):
            if stiffness.size == 0 or stiffness[0] > -_NEUTRAL:
                return replace(start, positions=positions)
            step = here.Z @ directions[:, 0]
            positions = closed(model, moved(model, positions, _sized(step, _NUDGE)), t)
            continue
        if stiffness[0] > _NEUTRAL:
            step = here.Z @ np.linalg.solve(K, here.unbalanced)
        else:
            along = directions.T @ here.unbalanced
            step = here.Z @ (directions @ (along / np.maximum(np.abs(stiffness), _NEUTRAL)))
        positions = _downhill(model, here, positions, limited(step), t)
    raise InputError(
        f"solver.start: no static equilibrium within {_MAX_ITERATIONS} steps; "
        f"{pushed(model, here.push, body_names)}. Expected loads that joints, springs and "
        "elasticity can balance"
    )


class _Balance:
    """Unbalanced forces at rest in a position, and the free directions."""

    def __init__(self, model: Model, positions: Array, t: float) -> None:
        self.model, self.t = model, t
        self.equations = _at_rest(model, positions, t)
        free = free_motions(self.equations, model.inertia_scale)
        self.Z = free.Z
        # least squares in the metric of the inertia
        self.multipliers = free.P.T @ self.equations.f
        self.unbalanced = self.Z.T @ self.equations.f  # (n_free,)
        self.push = self.Z @ self.unbalanced  # (n_vel,) as accelerations

    def force(self, positions: Array) -> Array:
        """Return f - Phi_q' lambda (n_vel,) in another position, at these multipliers."""
        equations = _at_rest(self.model, positions, self.t)
        return np.asarray(equations.f - equations.Phi_q.T @ self.multipliers)

    def stiffness(self, positions: Array) -> Array:
        """Return the stiffness over inertia (n_free, n_free) along Z [1/s2]."""
        K = np.zeros((self.Z.shape[1], self.Z.shape[1]))
        for k, z in enumerate(self.Z.T):
            h = _DIFFERENCE / np.max(np.abs(z))
            ahead = self.force(moved(self.model, positions, h * z))
            behind = self.force(moved(self.model, positions, -h * z))
            K[:, k] = self.Z.T @ (behind - ahead) / (2.0 * h)
        return K


def resting(model: Model, positions: Array, velocities: Array) -> Array:
    """Return the state y (n,) of positions and velocities; angles turn as at the given start."""
    return np.concatenate([positions, velocities, model.quantities.start, [0.0]])


def _at_rest(model: Model, positions: Array, t: float) -> Equations:
    return assemble(model, t, started(model, t, resting(model, positions, np.zeros(model.n_vel))))


def _downhill(model: Model, here: _Balance, positions: Array, step: Array, t: float) -> Array:
    """Return the position after a step, shortened until the unbalanced forces do work along it."""
    for _ in range(30):
        there = closed(model, moved(model, positions, step), t)
        before = here.equations.f @ step
        after = here.force(there) @ step
        if before + after >= 0.0:
            break
        step = 0.5 * step
    return there


def closed(model: Model, positions: Array, t: float) -> Array:
    """Return positions with the joints closed by the least change, elastic motion included."""
    for _ in range(50):
        equations = _at_rest(model, positions, t)
        if np.max(np.abs(equations.Phi), initial=0.0) < _CLOSED:
            return positions
        step = -free_motions(equations, model.inertia_scale).P @ equations.Phi
        positions = moved(model, positions, limited(step))
    raise InputError(
        "solver.start: the joints cannot be closed during the search for equilibrium "
        f"({np.max(np.abs(equations.Phi)):.2g} m or rad apart); give initial positions closer to it"
    )


def limited(step: Array) -> Array:
    """Return a step (n_vel,) that moves no coordinate by more than 0.3 m, rad or modal units."""
    return step * min(1.0, _MAX_STEP / max(float(np.max(np.abs(step))), 1e-300))


def _sized(step: Array, size: float) -> Array:
    return step * (size / float(np.max(np.abs(step))))


def pushed(model: Model, push: Array, body_names: list[str]) -> str:
    """Describe the largest unbalanced acceleration and its body."""
    largest, text = -1.0, ""
    for i, name in enumerate(body_names):
        j = int(model.vel_start[i])
        parts = {
            "m/s2": np.linalg.norm(push[j : j + 3]),
            "rad/s2": np.linalg.norm(push[j + 3 : j + 6]),
            "1/s2 in a mode": np.max(
                np.abs(push[j + 6 : j + 6 + int(model.n_mode[i])]), initial=0.0
            ),
        }
        for unit, size in parts.items():
            if size > largest:
                largest, text = (
                    float(size),
                    f"body {name} still has an unbalanced acceleration of {size:.3g} {unit}",
                )
    return text
