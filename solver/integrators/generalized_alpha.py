"""Generalized-alpha for mechanisms: its options, its formulations, its dense output."""

from typing import Any

from ..dynamics.model.model import Model
from ..math.arrays import Array
from ..math.catalogue import Number
from ..math.laws import Hermite
from .compiled.alpha import advance_alpha
from .compiled.alpha_stages import (
    FORMULATIONS,
    SPECTRAL_RADIUS,
    first_scheme,
    new_alpha_workspace,
    restart_alpha,
    scheme,
)
from .compiled.step_control import Ends
from .generic.advice import IMPLICIT, SHORTER, of_choice
from .generic.base import Dense
from .step_loop import StepLoop


class GeneralizedAlpha(StepLoop):
    """Generalized-alpha of Arnold and Bruls for M a + Phi_q' lambda = f, Phi = 0.

    Second order; q moves by the group's exponential (dynamics/model/coordinates.py), so that Euler
    parameters need no constraint of their own. With spectral radius rho at infinity,

        alpha_m = (2 rho - 1) / (rho + 1), alpha_f = rho / (rho + 1),
        gamma = 1/2 + alpha_f - alpha_m, beta = (gamma + 1/2)^2 / 4,
        (1 - alpha_m) a_1 + alpha_m a_0 = (1 - alpha_f) vdot_1 + alpha_f vdot_0,
        z = h v_0 + h^2 ((1/2 - beta) a_0 + beta a_1),  v_1 = v_0 + h ((1 - gamma) a_0 + gamma a_1).

    Formulations:
      index3  q_1 = q_0 exp(z); Phi(q_1) = 0. Velocities satisfy the constraints to h^2 only, and
              multipliers swing after a change of step.
      ggl     q_1 = q_0 exp(z + p) with p = -J^-1 Phi_q' eta, J being Newton's matrix (the position
              multiplier of Gear, Leimkuhler and Gupta); Phi(q_1) = 0 and Phidot(q_1, v_1) = 0.
              Default.

    Steps grow and shrink: the lag of a behind vdot that a smooth motion has, (alpha_m - alpha_f) h
    vddot, does so with them. A step without one before (at the start, behind a kink) takes the lag
    from its own change of vdot, which is the trapezoidal rule; fixed steps begin with a = vdot.

    Newton's unknowns are z and h^2 lambda: scaled so, the matrix stays well conditioned as h
    tends to zero. rho = 1 keeps the energy of what it does not resolve, rho = 0 destroys it in
    one step.

    Parameters
    ----------
    formulation : "ggl" or "index3"
    spectral_radius : rho, 0 to 1
    others : see Integrator. With fixed_step only Newton's iteration uses the tolerances.
    """

    name = "generalized-alpha"
    local_share = 0.03  # with ggl a quarter: unstable motions amplify errors
    meaning = "implicit, for constraints = ggl or index3"
    place = 5
    keys = (
        Number(
            "spectral_radius",
            "",
            "of generalized-alpha at infinite frequency: 1 gives no damping",
            default=SPECTRAL_RADIUS,
            least=0,
            most=1,
        ),
    )
    treatments = FORMULATIONS
    auxiliary = False
    order = 2
    on_failure = IMPLICIT
    # What it does not damp shows in its multipliers, not in the state.
    on_growth = (
        "With too little damping (spectral_radius near 1) what the step does not resolve can grow "
        'where the problem is not linear, and with constraints = "index3" the velocities that the '
        'constraints forbid swing on: take spectral_radius = 0.8, constraints = "ggl", or a '
        f"shorter step ({SHORTER})"
    )

    def __init__(
        self,
        model: Model,
        t0: float,
        y0: Array,
        t_end: float,
        *,
        formulation: str = "ggl",
        spectral_radius: float = SPECTRAL_RADIUS,
        **options: Any,
    ) -> None:
        self._scheme = scheme(formulation, spectral_radius)
        self._first = first_scheme(formulation, spectral_radius)
        super().__init__(model, t0, y0, t_end, **options)
        self.hints += of_choice(formulation, spectral_radius)

    @classmethod
    def local_tolerance(cls, rtol: float, treatment: str) -> float:
        """Return the tolerance of a step: of rtol**(3/2), as there are rtol**(-1/2) steps.

        With a constant share of `rtol` the error of a run is of rtol**(2/3): so with index3, whose
        multipliers at constraints that are redundant allow no such steps.
        """
        smallest = cls.smallest_rtol(treatment)
        if treatment == "index3":
            return cls.local_share * min(rtol, smallest)
        return 0.25 * cls.local_share * min(rtol, max(rtol, smallest) ** 1.5)

    @classmethod
    def smallest_rtol(cls, treatment: str) -> float:
        """Return that of rounding in Newton's corrections, or 1 with index3."""
        return 1.0 if treatment == "index3" else 3e-8

    @classmethod
    def for_treatment(cls, name: str) -> dict[str, object]:
        """Formulation."""
        return {"formulation": name}

    def _begin(self) -> Any:
        return new_alpha_workspace(self._model, self.t, self.y, self._h_next)

    def _restart(self) -> None:
        restart_alpha(self._model, self._workspace, self.t)

    def _call(
        self, most: int, times: Array, rows: Array, filled: int, ends: Ends
    ) -> tuple[int, int]:
        model, options, workspace = self._model, self._options, self._workspace
        return advance_alpha(
            model, options, self._scheme, self._first, workspace, most, times, rows, filled, ends
        )

    def _dense(self) -> Dense:
        c, h = self._workspace, self.h
        ends = (c.y_old.copy(), c.rate_old.copy(), c.y.copy(), c.rate.copy())
        cubic, s = Hermite(self.t_old, h, *ends), self._scheme.to_a**0.5 / h
        return self._closed_inside(cubic, s) if self._model.n_constraint > 0 else cubic
