"""Watch a run for singular positions: where constraints lose rank, and what a run does there.

In such a position (all links of a four-bar linkage on one line, say) the mechanism gains
freedom for an instant and could leave in several directions. The motion that goes on without a
jump of velocity is the right one. A treatment that divides by the vanishing singular value
follows its own rounding instead, often with the energy kept: nothing else would tell.
"""

from dataclasses import dataclass, field

import numpy as np

from ..dynamics.constraints.scaling import scaled_jacobian
from ..dynamics.constraints.treatment import PASSES_SINGULAR
from ..dynamics.model import Model
from ..dynamics.system import assemble
from ..integrators.generic import Integrator, StopRequest
from ..integrators.generic.base import Dense
from ..math.arrays import Array
from ..results.codes.course import BRANCH, SINGULAR, SINGULAR_PASSED
from ..results.finding import Finding
from .energy import EnergyMonitor

NEAR, AT = 0.05, 1e-3  # smallest singular value, over the largest that it had in the run
SMALL_CHANGE = 0.5  # of the scaled Jacobian: one valley at most
TURN = 0.2  # change of velocity within the neighbourhood of a singular position, relative
LOSS = 1e-3  # of the energy in play, there
GOLDEN = 0.5 * (5.0**0.5 - 1.0)


@dataclass
class _Rank:
    """Scaled Jacobian C (n_c, n) at a time, and the smallest singular value that counts."""

    t: float
    C: Array
    sigma: float


@dataclass
class _State:
    """What is kept of an accepted step."""

    t: float
    C: Array  # (n_c, n) scaled Jacobian
    velocity: Array  # (n_vel,) scaled by the roots of the inertia
    balance: float  # energy less the work done on the system [J]


@dataclass
class SingularityMonitor:
    """Find singular positions as a run goes through them, and judge how it came out.

    The smallest singular value sigma that counts is followed from step to step. It cannot
    change by more than the Jacobian C does (Weyl), so that most steps need no decomposition. It
    has passed through zero where it falls at the beginning of a step and rises at its end,
    steeply enough; steps in which C changes much are divided for that.
    """

    model: Model
    joint_names: list[str]
    treatment: str
    stop: bool = True
    findings: list[Finding] = field(default_factory=list)
    passes: list[float] = field(default_factory=list)  # times of singular positions [s]

    def __post_init__(self) -> None:
        self._rank = min(self.model.n_constraint - self.model.redundant, self.model.n_vel)
        self.energy = EnergyMonitor(self.model)
        self._last: _State | None = None
        self._known: _Rank | None = None  # the last that was needed
        self._path = 0.0  # change of C since then
        self._typical = 0.0  # largest of the smallest singular values so far
        self._before: _State | None = None  # last state before the neighbourhood, if inside it
        self._first_inside: _State | None = None
        self._lowest, self._t_lowest = np.inf, 0.0
        self._hardest = 0.0  # acceleration elsewhere, in the metric of _State.velocity

    def at_start(self, t: float, y: Array) -> None:
        """Take the state that the run starts from."""
        self._last = self._state(t, y)
        if self._rank:
            self._known = self._decompose(t, self._last.C)

    def __call__(self, integrator: Integrator) -> StopRequest | None:
        """Judge the step just taken; called by `integrate`."""
        assert self._last is not None, "at_start comes first"
        last, now = self._last, self._state(integrator.t, integrator.y)
        self._last = now
        if self._known is None:
            return None
        self._path += _size(now.C - last.C)
        if self._before is None and self._path < 0.5 * self._known.sigma:
            self._regular(last, now)
            return None
        before = self._known
        if before.t < last.t:
            before = self._decompose(last.t, last.C)
        self._known, self._path = self._decompose(now.t, now.C), 0.0
        interval = self._valley(before, self._known, integrator)
        sigma = self._known.sigma
        near = sigma < NEAR * self._typical
        if not (near or interval or self._before is not None):
            self._regular(last, now)
            return None
        if self._before is None:
            self._before = last
        elif self._first_inside is None:
            self._first_inside = last
        if interval is not None:
            self._locate(*interval, integrator.dense_output())
        elif sigma < self._lowest:
            self._lowest, self._t_lowest = sigma, now.t
        request = None
        if self._lowest < AT * self._typical and self.treatment not in PASSES_SINGULAR:
            request = self._cannot_pass(integrator)
        if not near:
            request = request or self._came_out(integrator, last, now)
            self._before = self._first_inside = None
            self._lowest = np.inf
        return request

    def explain(self, t: float, y: Array) -> str:
        """Words on a run that failed at (t, y), if it is a singular position that stopped it."""
        if self._known is None:
            return ""
        sigma, names = self._smallest(t, y)
        if sigma > NEAR * self._typical:
            return ""
        return f"{self._where(t, names)}. {self._advice()}"

    def _state(self, t: float, y: Array) -> _State:
        model = self.model
        equations = assemble(model, t, y)
        velocity = y[model.n_pos : model.n_pos + model.n_vel] * np.sqrt(model.inertia_scale)
        C = scaled_jacobian(equations.Phi_q, model.inertia_scale)
        return _State(t, C, velocity, self.energy.take(t, equations, y))

    def _regular(self, last: _State, now: _State) -> None:
        change = float(np.linalg.norm(now.velocity - last.velocity))
        self._hardest = max(self._hardest, change / (now.t - last.t))

    def _decompose(self, t: float, C: Array) -> _Rank:
        sigma = float(np.linalg.svd(C, compute_uv=False)[self._rank - 1])
        self._typical = max(self._typical, sigma)
        return _Rank(t, C, sigma)

    def _at(self, t: float, dense: Dense) -> _Rank:
        Phi_q = assemble(self.model, t, dense(t)).Phi_q
        return self._decompose(t, scaled_jacobian(Phi_q, self.model.inertia_scale))

    def _valley(self, a: _Rank, b: _Rank, integrator: Integrator) -> tuple[float, float] | None:
        """Return times between which sigma may go through zero; None if it does not."""
        change = _size(b.C - a.C)
        if a.sigma + b.sigma > change:
            return None
        dense = integrator.dense_output()
        if change > SMALL_CHANGE and b.t - a.t > 0.02 * integrator.h:
            middle = self._at(0.5 * (a.t + b.t), dense)
            return self._valley(a, middle, integrator) or self._valley(middle, b, integrator)
        ahead = 1e-6 * (b.t - a.t)
        fall = (a.sigma - self._at(a.t + ahead, dense).sigma) / ahead
        rise = (b.sigma - self._at(b.t - ahead, dense).sigma) / ahead
        if fall <= 0.0 or rise <= 0.0:
            return None
        # where the tangents at both ends meet
        bottom = (rise * a.sigma + fall * b.sigma - fall * rise * (b.t - a.t)) / (fall + rise)
        return (a.t, b.t) if bottom < NEAR * self._typical else None

    def _smallest(self, t: float, y: Array) -> tuple[float, list[str]]:
        """Smallest singular value that counts, and the joints whose rows make it."""
        C = scaled_jacobian(assemble(self.model, t, y).Phi_q, self.model.inertia_scale)
        U, s, _ = np.linalg.svd(C, full_matrices=False)
        small = np.flatnonzero(s[: self._rank] < max(NEAR * self._typical, s[self._rank - 1]))
        share = np.abs(U[:, [*small, self._rank - 1]]).max(axis=1)
        row = self.model.joint_row
        names = [
            name
            for k, name in enumerate(self.joint_names)
            if share[row[k] : row[k + 1]].max() > 0.1 * share.max()
        ]
        return float(s[self._rank - 1]), names

    def _locate(self, a: float, b: float, dense: Dense) -> None:
        """Find the smallest singular value between times a and b, by golden section."""
        c, d = b - GOLDEN * (b - a), a + GOLDEN * (b - a)
        at_c, at_d = self._at(c, dense).sigma, self._at(d, dense).sigma
        accuracy = 1e-7 * (b - a) + 4 * np.spacing(b)
        while b - a > accuracy:
            if at_c < at_d:
                b, d, at_d = d, c, at_c
                c = b - GOLDEN * (b - a)
                at_c = self._at(c, dense).sigma
            else:
                a, c, at_c = c, d, at_d
                d = a + GOLDEN * (b - a)
                at_d = self._at(d, dense).sigma
        if min(at_c, at_d) < self._lowest:
            self._lowest, self._t_lowest = min((at_c, c), (at_d, d))

    def _where(self, t: float, names: list[str]) -> str:
        return f"the constraint Jacobian loses rank at t = {t:.6g} s, in joints {', '.join(names)}"

    def _advice(self) -> str:
        if self.treatment == "augmented-lagrangian":
            return 'Raise `frequency`, or take constraints = "projection"'
        if self.treatment in PASSES_SINGULAR:
            return "Tighten rtol and atol; lengths that do not quite fit act so as well"
        return (
            f'Constraints = "{self.treatment}" cannot pass a singular position: take '
            '"projection", or "ggl" with integrator = "generalized-alpha"'
        )

    def _cannot_pass(self, integrator: Integrator) -> StopRequest | None:
        if self.passes and not self.stop:
            return None
        t = float(np.clip(self._t_lowest, integrator.t_old, integrator.t))
        _, names = self._smallest(t, integrator.dense_output()(t))
        text = f"{self._where(t, names)}: a singular position. {self._advice()}"
        self.passes.append(t)
        return self._found(SINGULAR.finding(text, t=t), t)

    def _came_out(self, integrator: Integrator, last: _State, now: _State) -> StopRequest | None:
        """Judge a passage that is complete: energy kept, velocity continued."""
        before = self._before
        assert before is not None
        if self._lowest >= AT * self._typical:
            return None
        if self.treatment in PASSES_SINGULAR:
            self.passes.append(self._t_lowest)
        loss = abs(now.balance - before.balance) / max(self.energy.in_play, 1e-300)
        turn = self._turn(last)
        if loss < LOSS and turn < TURN:
            return None
        text = (
            f"the run came out of the singular position at t = {self._t_lowest:.6g} s on another "
            f"branch, or with an impact: velocity turned by {turn:.2g}, energy balance changed by "
            f"{loss:.2g} of the energy in play. What follows is not the motion of the mechanism. "
            f"{self._advice()}"
        )
        return self._found(BRANCH.finding(text, t=self._t_lowest), integrator.t)

    def _found(self, finding: Finding, t_stop: float) -> StopRequest | None:
        """Keep a finding; return the request to stop because of it, if asked to."""
        self.findings.append(finding)
        return StopRequest(t_stop, finding.text, finding.code) if self.stop else None

    def passed(self) -> list[Finding]:
        """Return the singular positions that the run passed without harm, as one finding."""
        if self.findings or not self.passes:
            return []
        times = ", ".join(f"{t:.4g}" for t in self.passes[:5])
        more = " ..." if len(self.passes) > 5 else ""
        text = (
            f"{len(self.passes)} singular positions on the way, at t = {times}{more} s, "
            "where the mechanism could leave in more than one direction; velocity and energy "
            "were continued"
        )
        return [SINGULAR_PASSED.finding(text, t=self.passes[0], value=float(len(self.passes)))]

    def _turn(self, last: _State) -> float:
        """Change of velocity from the first to the last state inside, relative.

        Zero where the time spent there explains it: a slow passage may well change its velocity.
        """
        first = self._first_inside
        if first is None:
            return 0.0
        change = float(np.linalg.norm(last.velocity - first.velocity))
        if change <= 10.0 * self._hardest * (last.t - first.t):
            return 0.0
        return change / max(float(np.linalg.norm(first.velocity)), 1e-300)


def _size(C: Array) -> float:
    """Return a bound of the largest singular value, without finding it."""
    absolute = np.abs(C)
    return float(np.sqrt(absolute.sum(axis=0).max() * absolute.sum(axis=1).max()))
