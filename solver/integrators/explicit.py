"""Explicit Runge-Kutta methods of Dormand and Prince, orders 8(5,3) and 5(4).

Of any equations y' = f(t, y), and of mechanisms with a step loop that is compiled whole. The step,
its control, the stiffness test and the dense output of both are those of compiled/explicit_loop.py;
generic/dormand_prince.py has the coefficients.
"""

from typing import Any, ClassVar

import numpy as np

from ..dynamics.evaluation.accelerations import derivative_into
from ..dynamics.model.model import Model, new_workspace
from ..math.arrays import Array
from ..math.compiled import rebound
from ..math.laws import Nested, Powers
from .compiled import step_control as codes
from .compiled.explicit_loop import (
    STIFF_STEP,
    STIFF_TIME,
    accept_step,
    advance_explicit,
    attempt_step,
    fill_polynomial,
    fill_stages,
    new_explicit_workspace,
)
from .compiled.step_control import Ends, Options
from .generic.advice import RATE_EVALUATIONS, SHORTER
from .generic.base import Dense, Integrator
from .generic.dormand_prince import ORDER_5, ORDER_8, Tableau
from .step_loop import ClosingLoop, projection

RATE_EVERY = 200  # steps: one per cent of the evaluations of rk8
# Of the limit of stability; and radians by which the direction of an eigenvalue may be wrong, as
# differences over ten tolerances see it.
STABLE, DOUBT = 0.97, 0.01
LIMITS = np.arange(0.05, 10.0, 0.01)  # |h lambda| that are tried
GROWTH = (
    "An explicit method amplifies what is faster than its step: |h w| of the highest mode must "
    "stay below 1.0 (rk5) or 5.9 (rk8), h alpha and h beta of Baumgarte's feedback below 2. "
    f"Take a shorter step ({SHORTER}), an implicit method (radau, generalized-alpha, or gear "
    'with max_order = 2), fewer modes, or constraints = "projection" instead of baumgarte'
)


def keep_stable(run: Integrator, tableau: Tableau) -> bool:
    """Bound the steps of a run by its fastest motion, every RATE_EVERY steps; True if it did.

    The error of a body at rest is none whatever the step: longer steps let rounding grow to the
    tolerance, which is relative to the mechanism and may be much of a small deflection.
    """
    steps = run.counters.steps
    if run.fixed_step is not None or not run.vibrates or steps < run.bounded_to:
        return False
    run.bounded_to = steps + RATE_EVERY
    fastest = run.fastest_motion()
    limit = STABLE * stability_limit(tableau, fastest.direction)
    run.max_step = min(run.longest_step, limit / fastest.rate if fastest.rate > 0.0 else np.inf)
    return True


def stability_limit(tableau: Tableau, direction: complex) -> float:
    """Return the first |h lambda| at which a solution with this direction of lambda grows.

    A direction near the imaginary axis is taken for less damped by DOUBT than it was found.
    """
    damped = min(direction.real + DOUBT, 0.0)
    z = LIMITS * (damped + 1j * (1.0 - damped**2) ** 0.5)
    power, growth = np.ones(tableau.B.size), np.ones(z.size, dtype=complex)
    for k in range(1, tableau.B.size + 1):  # B A^(k-1) 1 z^k
        growth += (tableau.B @ power) * z**k
        power = tableau.A @ power
    return float(LIMITS[np.argmax(np.abs(growth) > 1.0 + 1e-12)])


class Explicit(Integrator):
    """What the methods have for any equations and for mechanisms alike.

    A hint is left in `hints` when 15 steps without much pause were as large as stability on the
    real axis allows. It is meant for damped fast modes at usual tolerances: with tight ones the
    steps stay below that limit.
    """

    tableau: ClassVar[Tableau]
    on_growth = GROWTH
    _workspace: Any

    def _note_stiffness(self) -> None:
        t, h = self._workspace.clock[STIFF_TIME], self._workspace.clock[STIFF_STEP]
        if h > 0.0 and not self.hints:
            self.hints.append(
                f"stiff: at t = {t:.6g} s the step {h:.3g} s is limited by stability, not "
                "by accuracy; an implicit method (radau, gear) may need fewer steps"
            )

    def _polynomial(self) -> Dense:
        """Return the dense output of the last step, whose polynomial is filled."""
        kind, workspace = Powers if self.tableau.first_same_as_last else Nested, self._workspace
        return kind(self.t_old, self.h, workspace.y_old.copy(), workspace.F.copy())


def _derivative_into(
    run: Integrator, work: None, t: float, y: Array, out: Array, factorised: bool = False
) -> None:
    out[:] = run.derivative(t, y)


def _project(run: Integrator, work: None, t: float, y: Array, *memory: Array) -> bool:
    nearest = run.project(t, y)
    if nearest is not None:
        y[:] = nearest
    return nearest is not None


# The same source for the equations of an integrator in place of a model.
_of_run: dict[str, object] = {"derivative_into": _derivative_into, "project": _project}
_of_run["derivative_at"] = _derivative_into
_of_run["fill_stages"] = rebound(fill_stages, **_of_run)
_attempt_step: Any = rebound(attempt_step, **_of_run)
_fill_polynomial: Any = rebound(fill_polynomial, **_of_run)


class ExplicitRungeKutta(Explicit):
    """An explicit method for any equations."""

    def __init__(self, *args: Any, **options: Any) -> None:
        super().__init__(*args, **options)
        self._workspace = new_explicit_workspace(self.tableau, self.t, self.y, self._f_start)
        self._options = Options(
            float(self.norm.rtol),
            self.norm.atol,
            np.append(options.get("block_starts") or [0], self.n).astype(np.int64),
            float(self.max_step),
            float(self.min_step),
            float(self.fixed_step or 0.0),
            np.zeros(0),
            np.zeros(0, dtype=bool),
            np.zeros(0),
            self._project is not None,
        )

    def _go_behind(self, *, jump: bool) -> None:
        self._workspace.f[:] = self.derivative(self.t, self.y)

    def _advance(self) -> None:
        keep_stable(self, self.tableau)
        super()._advance()

    def _attempt(self, h: float, t_new: float) -> Array | None:
        workspace, options, tableau = self._workspace, self._options, self.tableau
        workspace.clock[codes.TIME] = self.t
        error, factor = _attempt_step(self, None, options, tableau, workspace, h, t_new)
        trouble = workspace.counts[codes.TROUBLE]
        if trouble == codes.NONE and not options.closes:
            nearest = self.project(t_new, workspace.y_new)  # not onto anything; finite, and seen
            trouble = codes.OFF if nearest is None else codes.NONE
        if trouble == codes.NONE:
            accept_step(options, tableau, workspace, float(error), h, t_new)
            self._h_next = float(workspace.clock[codes.NEXT])
            self._note_stiffness()
            return np.array(workspace.y)
        if trouble == codes.ILL:
            self._refuse_not_finite("the derivative or the error")
            factor = 0.1
        elif trouble == codes.TOO_ROUGH:
            self._trouble = f"local error {error:.3g} times the tolerance"
        self._h_next = h * factor
        return None

    def _dense(self) -> Dense:
        _fill_polynomial(self, None, self.tableau, self._workspace)
        return self._polynomial()


class ExplicitLoop(Explicit, ClosingLoop):
    """An explicit method for mechanisms that are solved by blocks.

    A step goes back onto the constraints before it is accepted unless `closed` is false.
    """

    method: ClassVar[type[ExplicitRungeKutta]]  # for those that are not
    fails_before_growth = False
    samples = True

    def __init__(self, model: Model, t0: float, y0: Array, t_end: float, **options: Any) -> None:
        super().__init__(model, t0, y0, t_end, **options)
        self._project = projection(model) if self._closed else None

    def _begin(self) -> Any:
        sizes = self._model.n_vel, self._model.n_pos
        made = new_explicit_workspace(self.tableau, self.t, self.y, self._f_start, sizes)
        made.clock[codes.NEXT], self._work = self._h_next, new_workspace(self._model)
        return made

    def stride(self, times: Array, rows: Array, filled: int, keep: bool = False) -> int:
        """See `StepLoop`.

        Parameters
        ----------
        times : output times (k,) [s]
        rows : solution at these times (k, n), to fill
        filled : number of rows filled before
        keep : keep what `steps_taken` needs
        """
        self._keep_stable()
        return super().stride(times, rows, filled, keep)

    def _advance(self) -> None:
        self._keep_stable()
        super()._advance()

    def _keep_stable(self) -> None:
        if keep_stable(self, self.tableau):
            self._evaluated += RATE_EVALUATIONS
            self._options = self._options._replace(max_step=float(self.max_step))

    def _restart(self) -> None:
        workspace = self._workspace
        derivative_into(self._model, self._work, self.t, workspace.y, workspace.f)

    def _call(
        self, most: int, times: Array, rows: Array, filled: int, ends: Ends
    ) -> tuple[int, int]:
        if (left := self.bounded_to - self.counters.steps) > 0:
            most = min(most, left)  # the next bound is found at the same step in any case
        at = self._model, self._work, self._options, self.tableau, self._workspace
        outcome = advance_explicit(*at, most, times, rows, filled, ends)
        self._note_stiffness()
        return outcome

    def _dense(self) -> Dense:
        fill_polynomial(self._model, self._work, self.tableau, self._workspace)
        self.counters.evaluations += self.tableau.C_extra.size
        return self._polynomial()


class _Order8(Explicit):
    """Dormand-Prince 8(5,3): twelve evaluations a step, dense output of order 7.

    Best where the highest frequency is resolved anyway and accuracy counts. Stable up to
    |h lambda| of about 6, on the imaginary axis as on the real one. The dense output costs
    three more evaluations, spent only in steps where it is asked for.
    """

    name = "rk8"
    local_share = 0.03  # unstable motions amplify errors (tests/verification/test_tumbling_body.py)
    meaning = "explicit Runge-Kutta of order 8"
    place = 3
    order = 8
    rates_fit = True
    tableau = ORDER_8
    points = tuple(sorted({*ORDER_8.C.tolist(), 1.0}))
    limited_above = 2.0


class _Order5(Explicit):
    """Dormand-Prince 5(4): six evaluations a step, dense output of order 4.

    Stable up to h lambda = -3.3 on the real axis, but only to |h w| of about 1 on the
    imaginary one.
    """

    name = "rk5"
    local_share = 0.03
    meaning = "explicit Runge-Kutta of order 5"
    place = 4
    order = 5
    rates_fit = True
    tableau = ORDER_5
    points = tuple(sorted({*ORDER_5.C.tolist(), 1.0}))
    limited_above = 0.8


class RungeKutta8(_Order8, ExplicitRungeKutta):
    """Dormand-Prince 8(5,3) of any equations."""


class RungeKutta5(_Order5, ExplicitRungeKutta):
    """Dormand-Prince 5(4) of any equations."""


class RungeKutta8Loop(_Order8, ExplicitLoop):
    """Dormand-Prince 8(5,3) of mechanisms."""

    method = RungeKutta8


class RungeKutta5Loop(_Order5, ExplicitLoop):
    """Dormand-Prince 5(4) of mechanisms."""

    method = RungeKutta5
