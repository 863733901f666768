"""Derivatives of a few numbers of a run by many parameters: its tangent transposed.

Along the steps the tangent is S' = L S + G p (tangent.py), where p are derivatives of the terms of
the equations by the parameters. The numbers have derivatives by the states at output times. One
pass from the last step to the first carries these back, with the transposed matrices of the same
steps. It leaves derivatives by the terms at each state, and by the start. What a parameter changes
of the terms is then summed over the states: no equation is solved for it.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ...dynamics.evaluation.evaluation import Instants
from ...errors import InputError
from ...integrators.compiled.radau_stages import POWERS, A
from ...integrators.generic.drive import Steps
from ...math.arrays import Array, IntArray
from ...run.preparation import Prepared, output_times
from ...signals import HELD, Recording
from .execution import bends_of, beside_motion, change_of, cuts_of, sides
from .linear import Column, Partials
from .parameters import Parameter, Variant
from .tangent import Equations, Tangent

TRIED, LEAST = 1e-5, 1e-4  # of the largest motion of a coordinate, and of the mechanism's size
# Of a mechanism in some motion: arrays (..., n_t) at the output times.
Read = Callable[[Variant, Recording], Sequence[Array]]
Weights = Sequence[tuple[Array, str]]  # (v, ..., n_t) of each array in v numbers; its unit


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
        prepared: Prepared,
        columns: Sequence[Column],
        count: int,
    ) -> None:
        model = prepared.model
        self._at = _Terms(Partials(model, columns).rows)
        none = np.zeros((2 * model.n_vel + model.n_aux, count))
        super().__init__(
            model, columns, prepared.y0, none, bends_of(prepared), cuts_of(prepared), self._at
        )
        self.gradient = np.zeros((len(columns), count))

    def back(self, steps: Steps, times: Array, by_state: Array) -> None:
        """Carry them back over steps without a jump; by_state (m, 2 n_vel + n_aux, v) at times."""
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
        answer = np.linalg.solve(self._matrix(at(linear.J), h).transpose(0, 2, 1), right)
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


def gradients(
    prepared: Prepared,
    parameters: Sequence[Parameter],
    steps: Sequence[Steps],
    y: Array,
    read: Read,
    weights: Weights,
) -> Array:
    """Return the derivatives (P, v) of v numbers of a run by its parameters.

    Parameters
    ----------
    steps : of its trace
    y : (n_t, n) at the output times
    read : what the numbers are made of, each value by the state at its own time
    weights : derivatives of the numbers by what `read` returns, at the run itself

    Raises
    ------
    InputError
        As `sides`; a run with impacts or sampled states, which have no adjoint.
    """
    model, solver = prepared.model, prepared.mechanism.solver
    if model.quantities.event_state.size or Instants(model, solver.t_end).t.size:
        raise InputError(
            "the adjoint of runs with impacts or sampled states is not implemented; expected the "
            "tangent, without an objective"
        )
    pairs, columns, start = sides(prepared, parameters)
    times, held = output_times(solver.t_end, solver.output_step), dict[str, Any]()
    itself = Variant(replace(prepared.built, model=model), prepared.y0)
    read(itself, Recording(model, times, y, {HELD: held}))  # notes which plies govern

    def change(S: Array, h: float, pair: tuple[Variant, Variant]) -> Array:
        """Derivatives (n_t, v) of the summands of the numbers along S and between mechanisms."""
        beside = beside_motion(prepared, times, y, S, h, pair, held)
        rows = (read(each, recording) for each, recording in beside)
        return np.asarray(
            sum(
                np.einsum(
                    "vst,st->tv",
                    w.reshape(len(w), -1, times.size),
                    change_of(low, high, unit).reshape(-1, times.size) / (2.0 * h),
                )
                for low, high, (w, unit) in zip(*rows, weights, strict=True)
            )
        )

    adjoint = Adjoint(prepared, columns, len(weights[0][0]))
    spans = _spans(prepared, times, y, adjoint.units)
    by_state = np.stack(
        [
            change(row, TRIED * span, (itself, itself))
            for row, span in zip(np.eye(spans.size), spans, strict=True)
        ],
        axis=1,
    )
    for each in reversed(steps):
        adjoint.back(each, times, by_state)
    direct = [
        change(np.zeros(spans.size), parameter.h, pair).sum(axis=0)
        for parameter, pair in zip(parameters, pairs, strict=True)
    ]
    return np.asarray(adjoint.gradient + start.T @ (adjoint.S + by_state[0]) + np.array(direct))


def _spans(prepared: Prepared, t: Array, y: Array, units: Array) -> Array:
    """Return the sizes (2 n_vel + n_aux,) of the motion of all coordinates and their rates.

    Modes by their own motion: stresses are not linear over a larger one.
    """
    model, size = prepared.model, 1.0 / units
    for a, j, m in zip(model.pos_start, model.vel_start, model.n_mode, strict=True):
        modes = slice(j + 6, j + 6 + m)
        moved = np.abs(y[:, a + 7 : a + 7 + m]).max(axis=0)
        size[modes] = np.maximum(moved, LEAST * size[modes])
    rest = np.abs(y[:, model.n_pos : -1]).max(axis=0)
    least = LEAST * np.concatenate([size / t[-1], np.ones(model.n_aux)])
    return np.concatenate([size, np.maximum(rest, least)])
