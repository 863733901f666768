"""SciPy's integrators behind our contract, for comparison: BDF, Radau, LSODA, DOP853."""

import warnings
from typing import Any, ClassVar

import numpy as np
from peer_integrator import Peer
from scipy import integrate

from plymotion.solver.integrators.generic.base import Dense
from plymotion.solver.math.arrays import Array


class _ScipyPeer(Peer):
    """A class of scipy.integrate stepped by hand."""

    kind: ClassVar[str]  # name of the class in scipy.integrate
    implicit: ClassVar[bool] = True
    order = 1

    def _begin(self) -> None:
        options: dict[str, Any] = {
            "rtol": self.norm.rtol,
            "atol": self.norm.atol,
            "max_step": self.max_step,
            "first_step": self._h_next or None,
        }
        if self.implicit:
            options["jac"] = self.jacobian
        kind = getattr(integrate, self.kind)
        self._within = kind(self._f_within, self.t, self.y, self._stop, **options)

    def _step_within(self) -> tuple[float, Array] | None:
        order = self._order()
        message = self._within.step()
        self.counters.jacobians = self._within.njev
        self.counters.factorisations = self._within.nlu
        if self._within.status == "failed":
            self._trouble = str(message).rstrip(".")
            return None
        self.order = order
        return float(self._within.t), np.array(self._within.y)

    def _dense(self) -> Dense:
        inside = self._within.dense_output()
        return lambda t: np.ascontiguousarray(inside(np.asarray(t, dtype=float)).T)

    def _order(self) -> int:
        """Order of the step to come."""
        return type(self).order


class ScipyBdf(_ScipyPeer):
    """SciPy's BDF: orders 1 to 5 in differences at equal steps, NDF corrections up to order 3."""

    name = "scipy-bdf"
    meaning = "SciPy's BDF, to compare with"
    kind = "BDF"

    def _shift(self, t: float, y: Array) -> None:
        # Earlier points stay: a difference of any order changes by as much as the newest value.
        self._within.D[: self._within.order + 1] += y - self._within.y
        self._within.y = y.copy()

    def _order(self) -> int:
        return int(self._within.order)


class ScipyRadau(_ScipyPeer):
    """SciPy's Radau IIA of order 5."""

    name = "scipy-radau"
    meaning = "SciPy's Radau, to compare with"
    kind = "Radau"
    order = 5

    def _shift(self, t: float, y: Array) -> None:
        self._within.y, self._within.f = y.copy(), self._f_within(t, y)


class ScipyDop853(_ScipyPeer):
    """SciPy's explicit Runge-Kutta of Dormand and Prince, order 8(5,3)."""

    name = "scipy-dop853"
    meaning = "SciPy's rk8, to compare with"
    kind = "DOP853"
    implicit = False
    order = 8
    limited_above = 2.0

    def _shift(self, t: float, y: Array) -> None:
        f = self._f_within(t, y)
        self._within.y, self._within.f = y.copy(), f
        self._within.K[-1] = f


class ScipyLsoda(_ScipyPeer):
    """SciPy's LSODA of ODEPACK: Adams or BDF, changed over by itself."""

    name = "scipy-lsoda"
    meaning = "SciPy's LSODA, to compare with"
    kind = "LSODA"

    def _step_within(self) -> tuple[float, Array] | None:
        with warnings.catch_warnings(action="ignore"):  # its failures are our message
            reached = super()._step_within()
        if reached is None:
            code = self._code
            self._trouble = code.messages.get(code.istate, f"istate {code.istate}").rstrip(".")
            return None
        self.order = int(self._code.iwork[13])
        return reached

    def _shift(self, t: float, y: Array) -> None:
        # The first n numbers of its history, from the 21st on, are the state.
        self._code.rwork[20 : 20 + self.n] += y - self._within.y
        self._within.y = y.copy()

    @property
    def _code(self) -> Any:
        """The wrapper of ODEPACK's work arrays."""
        return self._within._lsoda_solver._integrator


SCIPY = {kind.name: kind for kind in (ScipyBdf, ScipyRadau, ScipyLsoda, ScipyDop853)}
