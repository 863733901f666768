"""SUNDIALS' IDA (BDF of variable order on F(t, y, y') = 0) behind our contract, for comparison."""

from typing import Any

import numpy as np
from peer_integrator import Peer

from plymotion.solver.dynamics.evaluation.accelerations import accelerations, assemble
from plymotion.solver.dynamics.model.coordinates import position_rates
from plymotion.solver.dynamics.model.model import Model
from plymotion.solver.errors import InputError
from plymotion.solver.integrators.generic.base import Dense
from plymotion.solver.integrators.step_loop import right_hand_side
from plymotion.solver.math.arrays import Array
from plymotion.solver.math.laws import Hermite

RANK_TOLERANCE = 1e-9  # of the scaled Jacobian's singular values, over the largest
CREEPING, TOO_MANY = 1e-6, 500  # steps so short beside the longest, so many in a row
NOT_CONTROLLED = 1e20  # absolute tolerance of multipliers: they take no part in the error norm
MISSING = "ida: needs scikit-sundae, which is not installed: pip install scikit-sundae"


class SundialsIda(Peer):
    """IDA on the index-2 form of Gear, Gupta and Leimkuhler.

    Unknowns Y = [q | v | work | lambda | eta], N = model.inertia_scale:

        qdot = rates(q, v - N^-1 Phi_q' eta),  M vdot + Phi_q' lambda = f,  Phidot = 0,  Phi = 0.

    IDA cannot do without a factor of its whole matrix: redundant constraints and singular
    positions end the run. Lengths of Euler parameters are held to the tolerance only.
    Output between steps is the cubic through their ends.

    Parameters
    ----------
    model : a mechanism whose forces read no reactions
    formulation : "ggl", as for generalized-alpha
    sharp, functions : of no effect here
    others : see Integrator; no `fixed_step`, no `project`

    Raises
    ------
    InputError : scikit-sundae is not installed
    ValueError : an option that makes no sense
    """

    name = "ida"
    meaning = "SUNDIALS' IDA, to compare with, for constraints = ggl"
    treatments = ("ggl",)
    order = 1
    takes = "model"
    auxiliary = False

    def __init__(
        self,
        model: Model,
        t0: float,
        y0: Array,
        t_end: float,
        *,
        formulation: str = "ggl",
        sharp: Array | None = None,
        functions: Any = (),
        **options: Any,
    ) -> None:
        if formulation not in self.treatments:
            raise ValueError(f"formulation: expected one of ggl, got {formulation!r}")
        if model.quantities.reaction_kind.size:
            raise ValueError("ida: does not know the reactions that friction depends on")
        if options.get("project") is not None:
            raise ValueError(
                "project: ida cannot continue from a state that was moved; expected no projection"
            )
        try:
            from sksundae.ida import IDA
        except ImportError as error:
            raise InputError(MISSING) from error
        self._kind = IDA
        self._model = model
        super().__init__(right_hand_side(model), t0, y0, t_end, **options)

    @classmethod
    def for_treatment(cls, name: str) -> dict[str, Any]:
        """Formulation."""
        return {"formulation": name}

    def _begin(self) -> None:
        model, n = self._model, self.n
        _, multipliers = accelerations(model, assemble(model, self.t, self.y), self.y)
        self.counters.evaluations += 1
        n_c = self._n_c = multipliers.size
        self._check_rank()
        atol = np.full(n + 2 * n_c, NOT_CONTROLLED)
        atol[:n] = np.minimum(self.norm.atol, NOT_CONTROLLED)
        self._within = self._kind(
            self._residual,
            rtol=self.norm.rtol,
            atol=atol,
            algebraic_idx=np.arange(n, n + 2 * n_c) if n_c else None,
            first_step=self._h_next,
            max_step=self.max_step if np.isfinite(self.max_step) else 0.0,
        )
        zeros = np.zeros(n_c)
        self._slope, self._longest, self._creeping = self._f_start, 0.0, 0
        state = np.concatenate((self.y, multipliers, zeros))
        self._within.init_step(self.t, state, np.concatenate((self._slope, zeros, zeros)))

    def _step_within(self) -> tuple[float, Array] | None:
        found = self._within.step(self._stop, "onestep", self._stop)
        if found.status < 0:
            self._trouble = str(found.message).rstrip(".")
            return None
        self.counters.jacobians = self.counters.factorisations = int(found.njev)
        y, slope = np.array(found.y[: self.n]), np.array(found.yp[: self.n])
        self._ends = (self.y, self._slope, y, slope)
        self._slope = slope
        h = float(found.t) - self.t
        self._longest = max(self._longest, h)
        self._creeping = self._creeping + 1 if h < CREEPING * self._longest else 0
        if self._creeping > TOO_MANY:
            self._trouble = (
                f"{TOO_MANY} steps in a row below {CREEPING:g} of the longest one, "
                "as where its matrix is singular"
            )
            return None
        return float(found.t), y

    def _check_rank(self) -> None:
        terms = assemble(self._model, self.t, self.y)
        self.counters.evaluations += 1
        if terms.Phi.size == 0:
            return
        mobility = terms.Phi_q / np.sqrt(self._model.inertia_scale)
        rows = np.linalg.norm(mobility, axis=1)
        mobility /= np.where(rows > 0, rows, 1.0)[:, None]
        rank = int(np.linalg.matrix_rank(mobility, tol=RANK_TOLERANCE))
        if rank < terms.Phi.size:
            raise ArithmeticError(
                f"{terms.Phi.size - rank} of {terms.Phi.size} constraint equations are redundant, "
                "and ida then factorises a singular matrix; generalized-alpha handles redundant "
                "constraints"
            )

    def _residual(self, t: float, Y: Array, Y_d: Array, residual: Array) -> None:
        try:
            residual[:] = self._unbalanced(t, Y, Y_d)
        except (np.linalg.LinAlgError, ArithmeticError) as error:
            self._raised = f"{type(error).__name__} in the equations at t = {t:.9g} s: {error}"
            residual[:] = np.nan
        except BaseException as error:
            self._error_in_f = error
            raise
        if not np.isfinite(residual).all():
            self._f_not_finite = True

    def _unbalanced(self, t: float, Y: Array, Y_d: Array) -> Array:
        """F(t, Y, Y'), (n + 2 n_c,)."""
        model, n, n_pos = self._model, self.n, self._model.n_pos
        y = np.array(Y[:n])
        v, v_d = y[n_pos : n_pos + model.n_vel], Y_d[n_pos : n_pos + model.n_vel]
        multipliers, eta = Y[n : n + self._n_c], Y[n + self._n_c :]
        self.counters.evaluations += 1
        terms = assemble(model, t, y)
        corrected = v - (terms.Phi_q.T @ eta) / model.inertia_scale
        return np.concatenate(
            (
                Y_d[:n_pos] - position_rates(model, y[:n_pos], corrected),
                terms.M @ v_d + terms.Phi_q.T @ multipliers - terms.f,
                [Y_d[n - 1] - terms.power[0] - multipliers @ terms.Phi_t],
                terms.Phi_q @ v + terms.Phi_t,
                terms.Phi,
            )
        )

    def _shift(self, t: float, y: Array) -> None:
        raise NotImplementedError("no `project`: nothing moves its state")

    def _dense(self) -> Dense:
        y_0, slope_0, y_1, slope_1 = self._ends
        return Hermite(self.t_old, self.h, y_0, slope_0, y_1, slope_1)
