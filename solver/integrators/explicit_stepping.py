"""Explicit Runge-Kutta methods of mechanisms, with a step loop that is compiled whole."""

from typing import Any, ClassVar

from ..dynamics.model.model import Model
from ..math.arrays import Array
from .compiled.explicit import (
    STIFF_STEP,
    STIFF_TIME,
    advance_explicit,
    fill_polynomial,
    new_explicit_workspace,
)
from .compiled.step_control import Ends
from .generic.advice import RATE_EVALUATIONS
from .generic.base import Dense
from .generic.dormand_prince import Tableau
from .generic.explicit import (
    ExplicitRungeKutta,
    Nested,
    Powers,
    RungeKutta5,
    RungeKutta8,
    keep_stable,
    stiffness_hint,
)
from .step_loop import ClosingLoop, projection


class ExplicitLoop(ClosingLoop):
    """Step loop of an explicit method, for mechanisms that are solved by blocks.

    Steps, error estimate and dense output are those of `method`, which takes any equations; a
    step goes back onto the constraints before it is accepted unless `closed` is false.
    """

    method: ClassVar[type[ExplicitRungeKutta]]
    tableau: ClassVar[Tableau]
    fails_before_growth = False
    samples = True
    on_growth = ExplicitRungeKutta.on_growth
    on_failure = ExplicitRungeKutta.on_failure

    def __init_subclass__(cls) -> None:
        """Take over from the method what describes it."""
        for key in (
            "name",
            "meaning",
            "place",
            "order",
            "limited_above",
            "local_share",
            "points",
            "tableau",
        ):
            setattr(cls, key, getattr(cls.method, key))

    def __init__(self, model: Model, t0: float, y0: Array, t_end: float, **options: Any) -> None:
        super().__init__(model, t0, y0, t_end, **options)
        self._project = projection(model) if self._closed else None

    def _begin(self, rate: Array, multipliers: Array) -> Any:
        model, tableau = self._model, self.tableau
        return new_explicit_workspace(model, tableau, self.t, self.y, rate, self._h_next)

    def stride(self, times: Array, rows: Array, filled: int, keep: bool = False) -> int:
        """See `StepLoop`."""
        self._keep_stable()
        return super().stride(times, rows, filled, keep)

    def _advance(self) -> None:
        self._keep_stable()
        super()._advance()

    def _keep_stable(self) -> None:
        if keep_stable(self, self.tableau):
            self._evaluated += RATE_EVALUATIONS
            self._options = self._options._replace(max_step=float(self.max_step))

    def _restart(self, rate: Array, multipliers: Array) -> None:
        self._workspace.y[:], self._workspace.f[:] = self.y, rate

    def _call(
        self, most: int, times: Array, rows: Array, filled: int, ends: Ends
    ) -> tuple[int, int]:
        model, options, workspace = self._model, self._options, self._workspace
        if (left := self.bounded_to - self.counters.steps) > 0:
            most = min(most, left)  # the next bound is found at the same step in any case
        found = advance_explicit(
            model, options, self.tableau, workspace, most, times, rows, filled, ends
        )
        t, h = workspace.clock[STIFF_TIME], workspace.clock[STIFF_STEP]
        if h > 0.0 and not self.hints:
            self.hints.append(stiffness_hint(t, h))
        return found

    def _dense(self) -> Dense:
        workspace = self._workspace
        fill_polynomial(self._model, self.tableau, workspace)
        self.counters.evaluations += self.tableau.C_extra.size
        kind = Powers if self.tableau.first_same_as_last else Nested
        return kind(self.t_old, self.h, workspace.y_old.copy(), workspace.F.copy())


class RungeKutta8Loop(ExplicitLoop):
    """Dormand-Prince 8(5,3) of mechanisms; see `RungeKutta8`."""

    method = RungeKutta8


class RungeKutta5Loop(ExplicitLoop):
    """Dormand-Prince 5(4) of mechanisms; see `RungeKutta5`."""

    method = RungeKutta5
