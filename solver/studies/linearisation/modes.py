"""Modes of a linearised mechanism: eigenvalues, frequencies, damping, left and right vectors."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eig

from ...dynamics.analysis.scales import extent
from ...dynamics.evaluation.dense_equations import assemble
from ...dynamics.model.model import Model
from ...math.arrays import Array
from .differences import STEP, units_of
from .state_space import StateSpace

BoolArray = NDArray[np.bool_]

_STILL = 1e-6  # [rad/s] eigenvalues below are zero, whatever the mechanism
_ROUND_OFF = 100.0  # safety on the round-off of a double eigenvalue zero
_DOUBLE = 30.0  # safety on what the eigenvalue solver makes of a double zero [sqrt(rad/s)]
_TERMS = 10.0  # safety on the round-off of sums whose terms cancel
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


def modes_of(model: Model, space: StateSpace, t: float = 0.0) -> Modes:
    """Return the modes of linearised equations of a model at time t."""
    if not space.A_free.size:
        none = np.zeros((0, 0), dtype=complex)
        x = np.zeros((model.n_vel, 0), dtype=complex)
        return Modes(np.zeros(0, dtype=complex), none, none, np.zeros(0, dtype=bool), x)
    values, left, right = eig(space.A_free, left=True, right=True)
    largest = float(np.abs(values).max())
    real = np.abs(values.imag) <= _REAL * np.abs(values)
    values = np.where(real, values.real, values)
    double = _DOUBLE * float(np.sqrt(np.finfo(float).eps * largest))
    least = np.maximum(max(_STILL, _still(model, space, t), double), _cancelled(space, left, right))
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


def _still(model: Model, space: StateSpace, t: float) -> float:
    """Return what round-off makes of a double eigenvalue of zero [rad/s]."""
    size = extent(model, space.y)
    forces = np.abs(assemble(model, t, space.y).f) / model.inertia_scale
    noise = np.finfo(float).eps * float((forces * units_of(model, size)).max()) / STEP
    return float(_ROUND_OFF * np.sqrt(noise))


def _cancelled(space: StateSpace, left: Array, right: Array) -> Array:
    """Return what round-off makes of each eigenvalue if stiff terms cancel to zero in it [rad/s].

    lambda^2 = l' A r / l' r with A the accelerations by displacements: its round-off is that of
    the largest terms of the sums, which a rigid motion beside stiff modes cancels.
    """
    n = space.n_free
    rows, r = left[n : 2 * n], right[:n]
    terms = (np.abs(rows) * (np.abs(space.A_free[n : 2 * n, :n]) @ np.abs(r))).sum(axis=0)
    product = np.abs(np.einsum("ik,ik->k", rows.conj(), r))
    noise = _TERMS * np.finfo(float).eps * terms
    return np.asarray(np.sqrt(np.divide(noise, product, np.zeros_like(noise), where=product > 0)))


def _single_zeros(keep: list[int], still: BoolArray, right: Array) -> list[int]:
    """Leave out, of zero eigenvalues, those whose vectors are combinations of others kept."""
    chosen: list[int] = []
    basis: list[Array] = []
    for k in keep:
        if still[k]:
            n = right.shape[0] // 2
            rest = right[:n, k].copy()
            for b in basis:
                rest -= (b.conj() @ rest) * b
            size = float(np.linalg.norm(rest))
            if size < 1e-4 * float(np.linalg.norm(right[:n, k])):
                continue
            basis.append(rest / size)
        chosen.append(k)
    return chosen
