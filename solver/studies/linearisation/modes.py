"""Modes of a linearised mechanism: eigenvalues, vectors, and what moves in them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag, eig, qr

from ...dynamics.analysis.recovery import extent
from ...dynamics.evaluation.accelerations import assemble
from ...dynamics.model.model import Model, modal_matrix
from ...math.arrays import Array
from ...math.rotations import frame_from_axis, rotation_matrix, skew
from ...mechanism.built_mechanism import BuiltMechanism
from ...package import ModalPackage
from .differences import STEP, units_of
from .state_space import StateSpace

BoolArray = NDArray[np.bool_]

_STILL = 1e-6  # [rad/s] eigenvalues below are zero, whatever the mechanism
_ROUND_OFF = 100.0  # safety on the round-off of a double eigenvalue zero
_DOUBLE = 30.0  # safety on what the eigenvalue solver makes of a double zero [sqrt(rad/s)]
_TERMS = 10.0  # safety on the round-off of sums whose terms cancel
_HELD = 1e-9  # what constraints take of a motion, relative
_REAL = 1e-9  # imaginary part of a real eigenvalue, relative


@dataclass(frozen=True)
class Modes:
    """k modes, one of each conjugate pair, by rising frequency.

    Motions without oscillation (real eigenvalues) come first, those of zero eigenvalues before.
    """

    eigenvalues: Array  # (k,) complex [1/s], imaginary part >= 0
    right: Array  # (m, k) columns of A r = lambda r; of unit modal mass
    left: Array  # (m, k) l^H A = lambda l^H, with l^H r = 1
    still: BoolArray  # (k,): zero but for round-off
    x: Array  # (n_vel, k) displacements along the velocity coordinates, of unit modal mass

    @property
    def frequencies(self) -> Array:
        """Damped angular frequencies (k,) [rad/s]."""
        return np.where(self.still, 0.0, self.eigenvalues.imag)

    @property
    def damping(self) -> Array:
        """Damping ratios (k,) [-]: -Re / |lambda|; negative: unstable; 0 for zero eigenvalues."""
        size = np.where(self.still, 1.0, np.abs(self.eigenvalues))
        return np.where(self.still, 0.0, -self.eigenvalues.real / size)

    @property
    def unstable(self) -> BoolArray:
        """Which modes grow, (k,); slower than round-off does not count."""
        return np.asarray(self.growth > 0.0)

    @property
    def growth(self) -> Array:
        """Rates of growth (k,) [1/s], 0 where a mode does not grow."""
        significant = self.eigenvalues.real > 1e-6 * np.abs(self.eigenvalues)
        return np.where(significant & ~self.still, self.eigenvalues.real, 0.0)


def modes_of(
    model: Model, space: StateSpace, t: float = 0.0, turning: Array | None = None
) -> Modes:
    """Return the modes of linearised equations of a model at time t.

    `turning` (n_vel,) is a displacement that is known to leave the equations as they are: the turn
    of a mechanism in steady spin. Its eigenvalue is set to zero: as computed, it has the round-off
    of the stiff terms of the accelerations.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    space : linearised equations about a state
    t : time [s]
    turning : displacement (n_vel,) that leaves the equations as they are; its eigenvalue is set to
        zero
    """
    if not space.A_free.size:
        none = np.zeros((0, 0), dtype=complex)
        x = np.zeros((model.n_vel, 0), dtype=complex)
        return Modes(np.zeros(0, dtype=complex), none, none, np.zeros(0, dtype=bool), x)
    values, left, right = _eigen(space, turning)
    largest = float(np.abs(values).max())
    real = np.abs(values.imag) <= _REAL * np.abs(values)
    values = np.where(real, values.real, values)
    eps = float(np.finfo(float).eps)
    # What round-off makes of a double eigenvalue of zero [rad/s].
    forces = np.abs(assemble(model, t, space.y).f) / model.inertia_scale
    noise = eps * float((forces * units_of(model, extent(model, space.y))).max()) / STEP
    double = max(_ROUND_OFF * np.sqrt(noise), _DOUBLE * np.sqrt(eps * largest))
    # lambda^2 = l' A r / l' r with A the accelerations by displacements: its round-off is that of
    # the largest terms of the sums, which a rigid motion beside stiff modes cancels.
    n = space.n_free
    rows, r = left[n : 2 * n], right[:n]
    terms = (np.abs(rows) * (np.abs(space.A_free[n : 2 * n, :n]) @ np.abs(r))).sum(axis=0)
    product = np.abs(np.einsum("ik,ik->k", rows.conj(), r))
    own = np.divide(_TERMS * eps * terms, product, np.zeros_like(terms), where=product > 0)
    least = np.maximum(max(_STILL, double), np.sqrt(own))
    still = np.abs(values) <= least
    # Of a pair one is kept; of a double zero, which has one vector, also one.
    keep = [k for k in range(values.size) if values[k].imag > 0.0 or real[k]]
    keep = _single_zeros(keep, still, right)
    keep.sort(key=lambda k: (not still[k], values[k].imag, values[k].real))
    values, left, right, still = values[keep], left[:, keep], right[:, keep], still[keep]
    x = space.displacements(right)
    # The displacement of unit modal mass whose largest component is real and positive.
    size = np.sqrt((x.conj() * (space.mass @ x)).sum(axis=0).real)
    weighted = x * np.sqrt(model.inertia_scale)[:, None]
    top = weighted[np.abs(weighted).argmax(axis=0), np.arange(x.shape[1])]
    scale = np.exp(-1j * np.angle(top)) / np.where(size > 0.0, size, 1.0)
    right, x = right * scale, x * scale
    product = np.einsum("ik,ik->k", left.conj(), right)
    left = left / np.where(np.abs(product) > 0.0, product.conj(), 1.0)
    return Modes(values, right, left, still, x)


def _eigen(space: StateSpace, turning: Array | None) -> tuple[Array, Array, Array]:
    """Return eigenvalues, left and right vectors, with those of a known motion of zero stiffness.

    In a basis that begins with that motion s, A = [0, a'; 0, A_2]. The others follow from A_2:
    its right vector r_2 has the share a' r_2 / lambda of s, its left vector none.
    """
    A, n = space.A_free, space.n_free
    s = np.zeros(len(A))
    if turning is not None:
        s[:n] = space.free.Z_left @ turning
        away = np.abs(space.free.Z @ s[:n] - turning).max()
        if away > _HELD * np.abs(turning).max():  # a drive holds it
            turning = None
    if turning is None:
        return tuple(eig(A, left=True, right=True))
    Q = qr(s[:, None])[0]
    others = Q.T @ A @ Q[:, 1:]
    values, left, right = eig(others[1:], left=True, right=True)
    along = others[0] @ right
    # Beside a second eigenvalue of zero the displacement is s alone.
    share = along / np.where(np.abs(values) > np.abs(along) * _REAL, values, _REAL)
    first = np.linalg.lstsq(others[1:].T, -others[0], rcond=None)[0]
    return (
        np.concatenate([[0.0], values]),
        Q @ np.block([[np.ones((1, 1)), np.zeros((1, values.size))], [first[:, None], left]]),
        Q @ np.block([[np.ones((1, 1)), share[None]], [np.zeros((values.size, 1)), right]]),
    )


def _single_zeros(keep: list[int], still: BoolArray, right: Array) -> list[int]:
    """Leave out, of zero eigenvalues, those whose vectors are combinations of others kept."""
    n, chosen, basis = right.shape[0] // 2, list[int](), list[Array]()
    for k in keep:
        if still[k]:
            rest = right[:n, k].copy()
            for b in basis:
                rest -= (b.conj() @ rest) * b
            size = float(np.linalg.norm(rest))
            if size < 1e-4 * float(np.linalg.norm(right[:n, k])):
                continue
            basis.append(rest / size)
        chosen.append(k)
    return chosen


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
    model: Model, built: BuiltMechanism, space: StateSpace, modes: Modes, axis: Array | None = None
) -> Participation:
    """Return what moves in each mode; `axis` (3,) is that of the spin, global.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py), in this state
    built : the mechanism, for names of its coordinates
    space : linearised equations about a state
    modes : modes of the linearised equations
    axis : axis of the spin (3,), global
    """
    x = modes.x
    k = x.shape[1]
    bodies, strain = np.zeros((model.n_body, k)), np.zeros(x.shape)  # twice the strain energies
    for i in range(model.n_body):
        j, m = int(model.vel_start[i]), int(model.n_mode[i])
        part, own = slice(j, j + 6 + m), slice(j + 6, j + 6 + m)
        bodies[i] = (x[part].conj() * (space.mass[part, part] @ x[part])).sum(axis=0).real
        stiffness = modal_matrix(model, model.K_qq, i).diagonal()
        strain[own] = stiffness[:, None] * np.abs(x[own]) ** 2
    bodies /= np.maximum(bodies.sum(axis=0), 1e-300)
    weights = np.abs(x) ** 2 * model.inertia_scale[:, None]
    weights /= np.maximum(weights.sum(axis=0), 1e-300)
    names = coordinate_names(model, built.body_names, built.packages)
    whole = np.abs(modes.eigenvalues) ** 2  # of unit modal mass: twice the largest energy
    elastic = strain.sum(axis=0) > _ELASTIC * whole
    top = np.where(elastic, strain.argmax(axis=0), weights.argmax(axis=0)) if k else []
    main = [names[int(j)] for j in top]
    return Participation(bodies, weights, main, _forward(model, space.y, x, axis))


def coordinate_names(
    model: Model, body_names: Sequence[str], packages: Mapping[str, ModalPackage]
) -> list[str]:
    """Return the names of the velocity coordinates, (n_vel,): "arm x", "arm bending-xy 1".

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    body_names : names of the bodies of the model
    packages : modal packages by name
    """
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

    Parameters
    ----------
    modes : modes of the linearised equations
    forward : share of each mode that circles with the spin (k,)
    rate : angular velocity of the spin [rad/s]
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
    shares = np.full(x.shape[1], ALONG)
    across = both > 1e-3 * total
    shares[across] = np.clip(0.5 * (1.0 + turning[across] / both[across]), 0.0, 1.0)
    return shares


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
    # X = r + theta x b + phi q
    R, Q, W = r.T, q.T, np.array([skew(turn) for turn in theta.T]).reshape(-1, 3, 3)
    first = W @ model.S0[i] + Q @ S.T  # sum of m (X - r)
    mixed = W @ np.einsum("abm,km->kab", T01, Q.conj())
    turned = W @ T00 @ W.conj().transpose(0, 2, 1)
    half = 0.5 * turned + mixed + first[:, :, None] * R.conj()[:, None]
    moving = np.einsum("abmn,kn,km->kab", T11, Q, Q.conj(), optimize=True)
    whole = model.mass[i] * R[:, :, None] * R.conj()[:, None] + moving
    return np.asarray(whole + half + half.conj().transpose(0, 2, 1))


def change_when_turned(
    model: Model, space: StateSpace, modes: Modes, later: StateSpace, A: Array, rate: float
) -> float:
    """Return how much the equations change when the mechanism has turned by A (3, 3).

    Largest element of the change of the system matrix between two modes, over the largest of their
    eigenvalues and the spin: a whirl at the speed itself has eigenvalue zero in turning axes. The
    eigenvalues alone do not tell: on supports that differ in two directions, those of an
    axisymmetric rotor are the same at any angle, though its equations are not.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    space : linearised equations about a state
    modes : modes of the linearised equations
    later : equations after the turn
    A : rotation matrix of the turn (3, 3)
    rate : angular velocity of the spin [rad/s]
    """
    moving = ~modes.still
    if not moving.any():
        return 0.0
    turn = np.eye(model.n_vel)
    for j in model.vel_start:
        turn[j : j + 3, j : j + 3] = A
    both = block_diag(turn, turn, np.eye(space.auxiliary.size))
    into = _sides(space)[0] @ both.T @ _sides(later)[1]
    back = _sides(later)[0] @ both @ _sides(space)[1]
    change = into @ later.A_free @ back - space.A_free
    values = np.abs(modes.eigenvalues[moving])
    left, right = modes.left[:, moving], modes.right[:, moving]
    changes = np.maximum(np.abs(left.conj().T @ change @ right), np.abs(left.T @ change @ right))
    return float((changes / np.maximum(np.maximum.outer(values, values), rate)).max())


def _sides(space: StateSpace) -> tuple[Array, Array]:
    """Return what takes states without drives out of the coordinates, and into them."""
    Z, left, others = space.free.Z, space.free.Z_left, np.eye(space.auxiliary.size)
    moving = np.block([[Z, np.zeros_like(Z)], [space.velocity, Z]])
    return np.asarray(block_diag(left, left, others)), np.asarray(block_diag(moving, others))
