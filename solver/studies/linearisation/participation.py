"""What moves in a mode: share of each body in the kinetic energy, main coordinate, whirl."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ...dynamics.model.model import Model
from ...math.arrays import Array
from ...math.rotations import frame_from_axis, rotation_matrix, skew
from ...package import ModalPackage
from .modes import Modes
from .state_space import StateSpace

_FRAME = ("x", "y", "z", "rotation x", "rotation y", "rotation z")
_ELASTIC = 0.3  # share of strain energy from which the coordinate is one of elastic motion
ALONG = -1.0  # motion along the axis in place of a share
_CIRCULAR = 0.95  # share of one direction from which a motion is called a whirl


@dataclass(frozen=True)
class Participation:
    """Participation in k modes."""

    bodies: Array  # (nb, k) share of the kinetic energy of the displacements' rates
    coordinates: Array  # (n_vel, k) size of each coordinate, weighted by its inertia, sum 1
    main: list[str]  # coordinate with the largest strain energy, or share in stiff motion
    # (k,) share of motion that circles the axis with the spin; -1: along the axis, nan: no spin
    forward: Array


def participation(
    model: Model,
    space: StateSpace,
    modes: Modes,
    body_names: Sequence[str],
    packages: Mapping[str, ModalPackage],
    axis: Array | None = None,
) -> Participation:
    """Return what moves in each mode; `axis` (3,) is that of the spin, global."""
    x = modes.x
    k = x.shape[1]
    bodies = np.zeros((model.n_body, k))
    for i in range(model.n_body):
        part = slice(int(model.vel_start[i]), int(model.vel_start[i]) + 6 + int(model.n_mode[i]))
        M = space.mass[part, part]
        bodies[i] = (x[part].conj() * (M @ x[part])).sum(axis=0).real
    bodies /= np.maximum(bodies.sum(axis=0), 1e-300)
    weights = np.abs(x) ** 2 * model.inertia_scale[:, None]
    weights /= np.maximum(weights.sum(axis=0), 1e-300)
    names = coordinate_names(model, body_names, packages)
    strain = _strain(model, x)
    whole = np.abs(modes.eigenvalues) ** 2  # of unit modal mass: twice the largest energy
    elastic = strain.sum(axis=0) > _ELASTIC * whole
    top = np.where(elastic, strain.argmax(axis=0), weights.argmax(axis=0)) if k else []
    main = [names[int(j)] for j in top]
    return Participation(bodies, weights, main, _forward(model, space.y, x, axis))


def _strain(model: Model, x: Array) -> Array:
    """Twice the strain energy of each modal coordinate, (n_vel, k)."""
    out = np.zeros(x.shape)
    for i in range(model.n_body):
        j, m, two = int(model.vel_start[i]) + 6, int(model.n_mode[i]), int(model.square_start[i])
        stiffness = model.K_qq[two : two + m * m].reshape(m, m).diagonal()
        out[j : j + m] = stiffness[:, None] * np.abs(x[j : j + m]) ** 2
    return out


def coordinate_names(
    model: Model, body_names: Sequence[str], packages: Mapping[str, ModalPackage]
) -> list[str]:
    """Return the names of the velocity coordinates, (n_vel,): "arm x", "arm bending-xy 1"."""
    names: list[str] = []
    for i in range(model.n_body):
        body = body_names[i] if i < len(body_names) else f"virtual {i - len(body_names) + 1}"
        names += [f"{body} {word}" for word in _FRAME]
        package = packages.get(body)
        labels = (package.mode_labels or package.mode_kinds) if package is not None else ()
        names += [
            f"{body} {labels[m] if m < len(labels) else f'mode {m + 1}'}"
            for m in range(int(model.n_mode[i]))
        ]
    return names


def whirl_rates(modes: Modes, forward: Array, rate: float) -> Array:
    """Return the angular frequencies (k,) seen from axes at rest [rad/s]; nan: not circular.

    A motion that circles the axis at w in axes turning at W does so at W + w in axes at rest, or
    at W - w if it circles against the spin. Motion along the axis has the same frequency in both.
    """
    w = modes.frequencies
    out = np.full(w.shape, np.nan)
    out = np.where(forward >= _CIRCULAR, rate + w, out)
    out = np.where((forward >= 0.0) & (forward <= 1.0 - _CIRCULAR), rate - w, out)
    out = np.where(forward == ALONG, w, out)
    return np.where(modes.still, np.nan, out)


def _forward(model: Model, y: Array, x: Array, axis: Array | None) -> Array:
    """Share (k,) of the motion across the axis that circles it forward, by mass."""
    if axis is None:
        return np.full(x.shape[1], np.nan)
    E = frame_from_axis(axis)  # third column along the axis
    G = np.zeros((x.shape[1], 3, 3), dtype=complex)
    for i in range(model.n_body):
        A = E.T @ rotation_matrix(y[model.pos_start[i] + 3 : model.pos_start[i] + 7])
        G += np.einsum("ab,kbc,dc->kad", A, _moments(model, i, y, x), A)
    both = (G[:, 0, 0] + G[:, 1, 1]).real
    turning = -2.0 * G[:, 1, 0].imag
    total = np.trace(G, axis1=1, axis2=2).real
    found = np.full(x.shape[1], ALONG)
    across = both > 1e-3 * total
    found[across] = np.clip(0.5 * (1.0 + turning[across] / both[across]), 0.0, 1.0)
    return found


def _moments(model: Model, i: int, y: Array, x: Array) -> Array:
    """Sum of m X_a conj(X_b) over body i for its displacement X, body axes, (k, 3, 3)."""
    a, j, m = int(model.pos_start[i]), int(model.vel_start[i]), int(model.n_mode[i])
    A = rotation_matrix(y[a + 3 : a + 7])
    r, theta, q = A.T @ x[j : j + 3], x[j + 3 : j + 6], x[j + 6 : j + 6 + m]
    one, two = int(model.mode_start[i]), int(model.square_start[i])
    S = model.S[3 * one : 3 * (one + m)].reshape(3, m)
    T01 = model.T01[9 * one : 9 * (one + m)].reshape(3, 3, m)
    T11 = model.T11[9 * two : 9 * (two + m * m)].reshape(3, 3, m, m)
    J = model.J0[i]
    T00 = model.T00[i] + 0.5 * np.trace(J) * np.eye(3) - J
    out = np.zeros((x.shape[1], 3, 3), dtype=complex)
    for k in range(x.shape[1]):
        # X = r + theta x b + phi q
        R, W, Q = r[:, k], skew(theta[:, k]), q[:, k]
        first = W @ model.S0[i] + S @ Q  # sum of m (X - r)
        mixed = W @ (T01 @ Q.conj())
        second = W @ T00 @ W.conj().T + mixed + mixed.conj().T
        second = second + (T11 @ Q) @ Q.conj()
        out[k] = (
            model.mass[i] * np.outer(R, R.conj())
            + np.outer(first, R.conj())
            + np.outer(R, first.conj())
            + second
        )
    return out
