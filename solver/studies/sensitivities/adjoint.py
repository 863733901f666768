"""Derivatives of a few numbers of a run by many parameters: its tangent transposed.

Along the steps the tangent is S' = L S + G p (tangent.py), where p are derivatives of the terms of
the equations by the parameters. The numbers have derivatives by the states at output times. One
pass from the last step to the first carries these back, with the transposed matrices of the same
steps. It leaves derivatives by the terms at each state, and by the start. What a parameter changes
of the terms is then summed over the states: no equation is solved for it.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from ...dynamics.model.model import Model
from ...integrators.compiled.radau_stages import POWERS, A
from ...integrators.generic.drive import Steps
from ...math.arrays import Array, IntArray
from .linear import Column, Partials
from .tangent import Equations, Tangent


class _Terms:
    """Derivatives of the terms by those that parameters change, `rows` (r,); keeps the states."""

    def __init__(self, rows: IntArray | None) -> None:
        self.rows = rows

    def __call__(self, t: Array, y: Array, a: Array, multipliers: Array, base: Array) -> Array:
        self.at = t, y, a, multipliers, base
        own = np.eye(base.shape[1])
        return np.tile(own if self.rows is None else own[self.rows], (t.size, 1, 1))


class Adjoint(Tangent):
    """Carries derivatives of v numbers by the state back along steps.

    Attributes
    ----------
    S : (2 n_vel + n_aux, v) derivatives by the state at the beginning of the steps
    gradient : (P, v) derivatives by the parameters, by way of the equations of these steps
    """

    def __init__(
        self,
        model: Model,
        columns: Sequence[Column],
        y0: Array,
        count: int,
        bends: Sequence[tuple[int, float]],
        cuts: Array | None,
    ) -> None:
        self._at = _Terms(Partials(model, columns).rows)
        none = np.zeros((2 * model.n_vel + model.n_aux, count))
        super().__init__(model, columns, y0, none, bends, cuts, self._at)
        self.gradient = np.zeros((len(columns), count))

    def back(self, steps: Steps, times: Array, by_state: Array) -> None:
        """Carry the derivatives back over steps without a jump.

        Parameters
        ----------
        steps : of the integrator, with stages
        times : (m,) output times within them [s]
        by_state : (m, 2 n_vel + n_aux, v) derivatives of the v numbers by the states at these
        """
        for equations in self.equations(steps, backwards=True):
            own = equations.own(times)
            self._back(equations, times[own], by_state[own])

    def _back(self, equations: Equations, times: Array, by_state: Array) -> None:
        t, linear, weights = equations
        h, n, at = np.diff(t), self.model.n_vel, equations.at
        k, m, v = h.size, linear.J.shape[1], self.S.shape[1]
        # By the states at the stages: of output times within steps, and of the last stage.
        i = np.clip(np.searchsorted(t, times) - 1, 0, k - 1)
        powers = ((times - t[i]) / h[i])[:, None] ** np.arange(1, 4) @ POWERS
        stages, old = np.zeros((k + 1, 3, *self.S.shape)), 1.0 - powers.sum(axis=1)
        np.add.at(stages[1:], i, powers[:, :, None, None] * by_state[:, None])
        np.add.at(stages[:, 2], i, old[:, None, None] * by_state)  # before the step
        stages[-1, 2] += self.S
        start, stages = stages[0, 2], stages[1:].reshape(3 * k, -1, v)
        x, u, z = stages[:, :n], stages[:, n : 2 * n], stages[:, 2 * n :]
        by_w = at(linear.x).transpose(0, 2, 1) @ x + at(linear.v).transpose(0, 2, 1) @ u
        by_w[:, 2 * linear.n_free :] += z
        # Steps: w = M^-1 (last state of the step before, and h A g).
        hA, end = h[:, None, None] * A, np.zeros((k, 3 * m, m))
        end[:, 2 * m :] = np.eye(m)
        right = np.concatenate([by_w.reshape(k, 3 * m, v), end], axis=2)
        rows = np.einsum("kab,kbij->kbjai", hA, at(linear.J).reshape(k, 3, m, m))
        answer = np.linalg.solve(np.eye(3 * m) - rows.reshape(k, 3 * m, 3 * m), right)
        last, by_load = np.zeros((m, v)), np.empty((k, 3, m, v))
        for step in range(k)[::-1]:
            by_load[step] = (answer[step, :, :v] + answer[step, :, v:] @ last).reshape(3, m, v)
            last = by_load[step].sum(axis=0)
        start[linear.kept] += last
        self.S = start
        by_g = np.einsum("kab,kaiv->kbiv", hA, by_load).reshape(3 * k, m, v)
        parts = (linear.g, by_g), (linear.x_p, x), (linear.v_p, u)
        by_terms: Any = sum(
            part.transpose(0, 2, 1)
            @ np.asarray(weights.T @ by.reshape(3 * k, -1)).reshape(len(part), -1, v)
            for part, by in parts
        )
        weights_of = np.zeros((len(by_terms), self._at.at[-1].shape[1], v))
        weights_of[:, slice(None) if self._at.rows is None else self._at.rows] = by_terms
        self.gradient += self._partials.summed(*self._at.at, weights_of)
