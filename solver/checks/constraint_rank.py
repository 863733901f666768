"""Rank of the constraints along a run: the smallest singular value that counts, and its minimum."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..dynamics.analysis.rank import (
    Independence,
    certificate,
    difference,
    new_independence,
    new_spectrum,
    scaled_jacobian_into,
    smallest_at,
)
from ..dynamics.evaluation.energies import energies_into
from ..dynamics.evaluation.evaluation import evaluate
from ..dynamics.model.model import Model, Workspace, new_workspace
from ..integrators.generic.base import Dense, Integrator
from ..math.arrays import Array, IntArray
from ..math.compiled import inlined, lean, structure
from .tolerances import AHEAD, LEAST_PART, MINIMUM_FOUND, NAMED, NEARLY_SINGULAR, ONE_MINIMUM

LOW, HIGH = 0, 1  # entries of `limits`


@structure
class Observation(NamedTuple):
    """Memory of a run that is watched."""

    work: Workspace
    rows: Independence
    energy: Array  # (k, 3) kinetic, strain, potential, at ends of steps noted one by one [J]
    pivots: Array  # (k,) of their certificates
    noted: IntArray  # (1,) how many they are
    limits: Array  # (2,) pivots between which a step needs no look
    safe: Array  # (nb,) square of the spin below which it needs none [rad2/s2]
    regular: Array  # (1,) pivot of every step of a mechanism without loops; 0: to be found


def new_observation(model: Model, most: int) -> Observation:
    """Return memory for a model, and `most` steps noted one by one; spins need no look."""
    return Observation(
        new_workspace(model),
        new_independence(model),
        np.zeros((most, 3)),
        np.zeros(most),
        np.zeros(1, dtype=np.int64),
        np.array([-np.inf, np.inf]),
        np.full(model.n_body, np.inf),
        np.zeros(1),
    )


@lean
def observe(
    model: Model, seen: Observation, t: Array, y: Array, energy: Array, pivots: Array
) -> None:
    """Fill energy (k, 3) and pivots (k,) of steps that end at t (k,), y (k, n).

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    seen : memory of the observation
    t : ends of the steps (k,) [s]
    y : states there (k, n)
    energy : energies (k, 3), to fill
    pivots : least pivots (k,), to fill
    """
    for s in range(t.shape[0]):
        pivots[s] = _observe(model, seen, t[s], y[s], energy[s])


@lean
def note(model: Model, seen: Observation, t: float, y: Array) -> bool:
    """Keep energy and pivot of the step that ends at t, y (n,); return whether it needs a look.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    seen : memory of the observation
    t : end of the step [s]
    y : state (n,), as in dynamics/model/model.py
    """
    k = seen.noted[0]
    pivot = _observe(model, seen, t, y, seen.energy[k])
    seen.pivots[k] = pivot
    seen.noted[0] = k + 1
    doubt = not (pivot > seen.limits[LOW] and pivot < seen.limits[HIGH])
    for i in range(model.n_body):
        j = model.n_pos + model.vel_start[i] + 3
        spin = y[j] * y[j] + y[j + 1] * y[j + 1] + y[j + 2] * y[j + 2]
        doubt = doubt or spin >= seen.safe[i]
    return doubt


@inlined
def _observe(model: Model, seen: Observation, t: float, y: Array, energy: Array) -> float:
    evaluate(model, seen.work, t, y)
    energies_into(model, seen.work, y, energy)
    if seen.regular[0] > 0.0:
        return seen.regular[0]
    return certificate(model, seen.work, seen.rows, t, y)


GOLDEN = 0.5 * (5.0**0.5 - 1.0)


@dataclass(eq=False, repr=False)
class Rank:
    """Scaled Jacobian of a state, and the smallest singular value that counts."""

    t: float
    C: Array  # (nb, r, n) by body
    sigma: float


class ConstraintRank:
    """Decompose the scaled Jacobian of constraints in states of a run.

    Parameters
    ----------
    model : a mechanism
    seen : its memory, shared with the monitor
    joint_names : of the model's joints
    """

    def __init__(self, model: Model, seen: Observation, joint_names: list[str]) -> None:
        self.model, self._seen, self._joint_names = model, seen, joint_names
        self.count = min(model.n_constraint - model.redundant, model.n_vel)
        self._spectrum = new_spectrum(seen.rows)
        self.typical = 0.0  # largest of the smallest singular values so far

    def scaled_jacobian(self, t: float, y: Array) -> Array:
        """C (n_c, n_vel) of a state, dense."""
        seen = self._seen
        C = np.zeros((self.model.n_constraint, self.model.n_vel))
        scaled_jacobian_into(self.model, seen.work, seen.rows, float(t), y, C)
        return C

    def independent(self, t: float, y: Array) -> list[int]:
        """Return rows, as many as count: each the farthest from the span of those before.

        The pivots of a QR decomposition, without the 0.2 s that SciPy's takes to import.
        """
        C, chosen = self.scaled_jacobian(t, y), []
        for _ in range(self.count):
            chosen.append(int(np.argmax(np.einsum("ij,ij->i", C, C))))
            along = C[chosen[-1]] / np.linalg.norm(C[chosen[-1]])
            C -= np.outer(C @ along, along)
            C[chosen] = 0.0
        return chosen

    def decompose(self, t: float, y: Array) -> Rank:
        """Return the rank of a state y (n,) at t [s]."""
        seen, null = self._seen, self.model.n_constraint - self.count
        C = np.zeros_like(seen.rows.C)
        sigma = smallest_at(self.model, seen.work, seen.rows, self._spectrum, null, float(t), y, C)
        self.typical = max(self.typical, sigma)
        return Rank(float(t), C, sigma)

    def _at(self, t: float, dense: Dense) -> Rank:
        return self.decompose(t, dense(t))

    def valley(self, a: Rank, b: Rank, integrator: Integrator) -> tuple[float, float] | None:
        """Return times between which sigma may go through zero; None if it does not.

        Parameters
        ----------
        a : rank at an earlier time
        b : rank at a later time
        integrator : gives the states between them
        """
        change = difference(self.model, self._spectrum, a.C, b.C)
        if a.sigma + b.sigma > change:
            return None
        dense = integrator.dense_output()
        if change > ONE_MINIMUM and b.t - a.t > LEAST_PART * integrator.h:
            middle = self._at(0.5 * (a.t + b.t), dense)
            return self.valley(a, middle, integrator) or self.valley(middle, b, integrator)
        ahead = AHEAD * (b.t - a.t)
        fall = (a.sigma - self._at(a.t + ahead, dense).sigma) / ahead
        rise = (b.sigma - self._at(b.t - ahead, dense).sigma) / ahead
        if fall <= 0.0 or rise <= 0.0:
            return None
        # where the tangents at both ends meet
        bottom = (rise * a.sigma + fall * b.sigma - fall * rise * (b.t - a.t)) / (fall + rise)
        return (a.t, b.t) if bottom < NEARLY_SINGULAR * self.typical else None

    def smallest(self, t: float, y: Array) -> tuple[float, list[str]]:
        """Smallest singular value that counts, and the joints whose rows make it."""
        U, s, _ = np.linalg.svd(self.scaled_jacobian(t, y), full_matrices=False)
        least = max(NEARLY_SINGULAR * self.typical, s[self.count - 1])
        small = np.flatnonzero(s[: self.count] < least)
        share = np.abs(U[:, [*small, self.count - 1]]).max(axis=1)
        row = self.model.joint_row
        names = [
            name
            for k, name in enumerate(self._joint_names)
            if share[row[k] : row[k + 1]].max() > NAMED * share.max()
        ]
        return float(s[self.count - 1]), names

    def least(self, a: float, b: float, dense: Dense) -> tuple[float, float]:
        """Return the smallest singular value between times a and b, and its time.

        By golden sections; SciPy's search would take 0.3 s to import.

        Parameters
        ----------
        a : begin of the interval [s]
        b : its end [s]
        dense : states between them
        """
        inner = [b - GOLDEN * (b - a), a + GOLDEN * (b - a)]
        sigma = [self._at(t, dense).sigma for t in inner]
        shortest = MINIMUM_FOUND * (b - a)
        while b - a > shortest:
            if sigma[0] < sigma[1]:
                b = inner[1]
                inner = [b - GOLDEN * (b - a), inner[0]]
                sigma = [self._at(inner[0], dense).sigma, sigma[0]]
            else:
                a = inner[0]
                inner = [inner[1], a + GOLDEN * (b - a)]
                sigma = [sigma[1], self._at(inner[1], dense).sigma]
        return min(zip(sigma, inner, strict=True))
