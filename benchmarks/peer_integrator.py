"""Integrators of other codes behind the contract of ours: they choose the steps."""

from abc import abstractmethod
from typing import Any

import numpy as np

from plymotion.solver.integrators.generic.base import Integrator
from plymotion.solver.math.arrays import Array


class Peer(Integrator):
    """An integrator whose steps another program's solver takes; for comparison.

    What differs from our own: the error norm is that program's (one root mean square over all
    components, `block_starts` is of no effect), it has no fixed step, steps that it takes back
    are not reported (`counters.rejected` stays 0), and a step that cannot be projected onto the
    invariants ends the run, because it cannot be asked for a shorter one.

    A peer provides `_begin` (make the solver, at the first step), `_step_within` (one step of it),
    `_shift` (tell it that its last state was moved) and `_dense`.
    """

    on_any_failure = (
        "This code is there for comparison: take gear, radau, rk8 or generalized-alpha, which say "
        "more of their trouble"
    )

    def __init__(self, *args: Any, **options: Any) -> None:
        if options.get("fixed_step") is not None:
            raise ValueError(f"fixed_step: {self.name} chooses its own steps; expected none")
        self._began = False
        self._error_in_f: BaseException | None = None
        self._f_not_finite = False  # in the step under way
        super().__init__(*args, **options)

    def _advance(self) -> None:
        self._raised, self._trouble, self._f_not_finite = "", "", False
        t_y = self._guarded_step()
        if t_y is None:
            if self._f_not_finite:
                self._refuse_not_finite("the derivative")
            self._fail(f"{self.name} gives up at t = {self.t:.9g} s")
            return
        t_new, y_new = t_y
        h, floor = t_new - self.t, self._smallest_step()
        if not np.isfinite(y_new).all():
            self._refuse_not_finite("the derivative" if self._f_not_finite else "the new state")
            self._fail(f"{self.name} gives up at t = {self.t:.9g} s")
        elif h < floor and t_new < self._stop:
            self._fail(f"The step at t = {self.t:.9g} s fell to {h:.3g} s, below {floor:.3g} s")
        else:
            nearest = self.project(t_new, y_new)
            if nearest is None:
                self._fail(f"{self.name} gives up at t = {self.t:.9g} s")
                return
            if self._project is not None:
                self._shift(t_new, nearest)
            self._accept(t_new, nearest, h)

    def _guarded_step(self) -> tuple[float, Array] | None:
        """Time and state after one step, or None with `_trouble`; errors raised in f pass through.

        A compiled solver may lose an exception of f on its way, or replace it by its own.
        """
        try:
            if not self._began:
                self._begin()
                self._began = True
            t_y = self._step_within()
        except Exception as error:
            if self._error_in_f is None:
                self._trouble = f"{type(error).__name__}: {error}"
                return None
        if self._error_in_f is not None:
            error_in_f, self._error_in_f = self._error_in_f, None
            raise error_in_f
        return t_y

    def _f_within(self, t: float, y: Array) -> Array:
        """Evaluate f for the solver within: a copy, which it may keep.

        f gets y in one piece: compiled, it would be compiled again for a strided one.
        """
        try:
            value = np.array(self.derivative(float(t), np.ascontiguousarray(y)), dtype=float)
        except BaseException as error:
            self._error_in_f = error
            raise
        if not np.isfinite(value).all():
            self._f_not_finite = True
        return value

    def _first_step(self, first_step: float | None) -> float:
        span = self.t_end - self.t0
        return 0.0 if first_step is None else min(first_step, span)  # 0: left to the solver within

    def _go_behind(self, *, jump: bool) -> None:
        self._began, self._h_next = False, 0.0
        self._f_start = np.array(self.derivative(self.t, self.y))

    @abstractmethod
    def _begin(self) -> None:
        """Make the solver within."""

    @abstractmethod
    def _step_within(self) -> tuple[float, Array] | None:
        """Time and state after one step of it; None with `_trouble` set."""

    @abstractmethod
    def _shift(self, t: float, y: Array) -> None:
        """Go on from y (n,), the projection of the state that the last step ended with."""
