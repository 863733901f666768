"""Watch a run for singular positions: where constraints lose rank, and what a run does there.

In such a position (all links of a four-bar linkage on one line, say) the mechanism gains
freedom for an instant and could leave in several directions. The motion that goes on without a
jump of velocity is the right one. A treatment that divides by the vanishing singular value
follows its own rounding instead, often with the energy kept: no other check detects this.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial

import numpy as np

from ..dynamics.analysis.rank import begin
from ..dynamics.elements.constraints.treatment import PASSES_SINGULAR
from ..dynamics.evaluation.elimination import is_tree
from ..dynamics.model.model import Model
from ..dynamics.tolerances import CERTAIN
from ..errors import few
from ..integrators.generic.drive import MOST_NOTED, Steps, StopRequest
from ..math.arrays import Array
from ..results.codes import BRANCH, ENERGY_JUMP, SINGULAR, SINGULAR_PASSED, Finding
from ..results.run_result import ROUNDING
from .constraint_rank import ConstraintRank, Rank, new_observation, note, observe
from .tolerances import (
    AT_SINGULAR,
    EXPLAINED,
    HIGHER_PIVOT,
    LOWER_PIVOT,
    NEARLY_SINGULAR,
    UNDAMPED,
    UNTURNED,
)


@dataclass(eq=False, repr=False)
class EnergyMonitor:
    """Energy less the work done on the system: constant, but for the error of the run.

    A single step that changes it visibly is no accumulated error but an event: an impact, a
    force with a jump, a step far too long.
    """

    in_play: float = 0.0  # largest energy, change of potential or work so far; least to begin [J]
    largest_jump: float = 0.0  # of the balance in one step [J]
    t_jump: float = 0.0
    balance: float = 0.0  # of the last state [J]
    _start: Array = field(default_factory=lambda: np.zeros(0))
    _terms: float = 0.0  # largest sum of the sizes of all energies and the work [J]

    def take(self, t: Array, energy: Array, work: Array) -> None:
        """Take the states after the last ones.

        Parameters
        ----------
        t, energy, work : (k,) [s], (k, 3) kinetic, strain, potential [J], (k,) done so far [J]
        """
        if t.size == 0:
            return
        balance = energy.sum(axis=1) - work
        if self._start.size == 0:
            self._start, self.balance = energy[0].copy(), float(balance[0])
        change = energy[:, 2] - self._start[2]
        sizes = (energy[:, 0].max(), energy[:, 1].max(), np.abs(change).max(), np.abs(work).max())
        self.in_play = float(max(self.in_play, *sizes))
        self._terms = max(self._terms, float((np.abs(energy).sum(axis=1) + np.abs(work)).max()))
        jumps = np.abs(np.diff(balance, prepend=self.balance))
        k = int(np.argmax(jumps))
        if jumps[k] > self.largest_jump:
            self.largest_jump, self.t_jump = float(jumps[k]), float(t[k])
        self.balance = float(balance[-1])

    def findings(self, *, sudden: bool = True) -> list[Finding]:
        """Return the largest jump of the run so far, if it is above the threshold.

        `sudden`: whether forces of the mechanism may jump, or bodies collide.
        """
        share = float(self.largest_jump / max(self.in_play, 1e-300))
        if share < ENERGY_JUMP.limit or self.largest_jump < ROUNDING * self._terms:
            return []
        cause = "the step was too long for the motion there: decrease rtol, or set max_step"
        if sudden:
            cause = "look for an impact or a jump of force there; decrease rtol"
        text = (
            f"one step, to t = {self.t_jump:.6g} s, changed the energy balance by "
            f"{share:.2g} of the energy in play (expected below {ENERGY_JUMP.limit:g}): {cause}"
        )
        return [ENERGY_JUMP.finding(text, t=self.t_jump, value=share)]


@dataclass(eq=False, repr=False)
class _State:
    """What is kept of the end of a step."""

    t: float
    velocity: Array  # (n_vel,) scaled by the roots of the inertia
    balance: float  # energy less the work done on the system [J]


@dataclass(eq=False, repr=False)
class SingularityMonitor:
    """Find singular positions as a run goes through them, and judge how it came out.

    The least pivot of H (dynamics/analysis/rank.py) certifies for most steps that no
    singular position lies in them: that is linear in the number of bodies. A step without
    certificate is divided; where that does not help, or where the pivot is small beside its largest
    in the run, the smallest singular value sigma that counts is computed. It has passed through
    zero where it falls at the beginning of a step and rises at its end, steeply enough. A mechanism
    without loops has no singular positions.
    """

    model: Model
    joint_names: list[str]
    treatment: str
    stop: bool = True
    findings: list[Finding] = field(default_factory=list)
    passes: list[float] = field(default_factory=list)  # times of singular positions [s]

    def __post_init__(self) -> None:
        self.energy = EnergyMonitor()
        self._observation = new_observation(self.model, MOST_NOTED)
        self._rank = ConstraintRank(self.model, self._observation, self.joint_names)
        self._root = np.sqrt(self.model.inertia_scale)
        self._last: _State | None = None
        self._known: Rank | None = None  # the last that was needed
        self._low, self._high = 0.0, 0.0  # pivots beyond which sigma is computed
        self._largest_pivot = 0.0
        self._before: _State | None = None  # last state before the neighbourhood, if inside it
        self._first_inside: _State | None = None
        self._lowest, self._t_lowest = np.inf, 0.0
        self._hardest = 0.0  # acceleration elsewhere, in the metric of _State.velocity

    def at_start(self, t: float, y: Array) -> None:
        """Take the state that the run starts from."""
        if self._rank.count:
            self._known = self._rank.decompose(t, y)
            self._keep_independent(t, y)
            if not self.model.redundant and is_tree(self.model):
                # No row ever depends on others. In steps of a long chain the certificate would be
                # divided as often as there are links, to find that.
                self._observation.regular[0] = np.sqrt(self._low * self._high)
        energy, pivot = np.empty((1, 3)), np.empty(1)
        observe(self.model, self._observation, np.array([t]), y[None], energy, pivot)
        self.energy.take(np.array([t]), energy, y[-1:])
        self._last = self._state(t, y)

    def __call__(self, steps: Steps) -> StopRequest | None:
        """Judge the steps just taken; called by `integrate`."""
        assert self._last is not None, "at_start comes first"
        count, i = len(steps), 0
        energy, pivots = self._seen(steps)
        while i < count:
            doubt = np.zeros(0, dtype=np.int64)
            if self._before is not None:
                doubt = np.array([i])
            elif self._known is not None:
                certain = (pivots[i:] > self._low) & (pivots[i:] < self._high)
                doubt = i + np.flatnonzero(~certain)
            j = int(doubt[0]) if doubt.size else count
            self._regular(steps, i, j, energy)
            if j == count:
                break
            request, again = self._look(steps, j, float(pivots[j]), energy[j : j + 1])
            if request is not None:
                return request
            i = j + 1
            if again and i < count:
                _, pivots[i:] = self._seen(steps, i)
        return None

    def _look(
        self, steps: Steps, i: int, pivot: float, energy: Array
    ) -> tuple[StopRequest | None, bool]:
        """Judge step i, which is in doubt; also say whether later pivots must be found again."""
        last = self._last
        assert last is not None
        assert self._known is not None
        before = self._known
        if pivot <= CERTAIN and before.t != steps.t[i]:
            before = self._rank.decompose(steps.t[i], steps.y[i])
        self.energy.take(steps.t[i + 1 : i + 2], energy, steps.y[i + 1 : i + 2, -1])
        now = self._last = self._state(steps.t[i + 1], steps.y[i + 1])
        self._known = self._rank.decompose(now.t, steps.y[i + 1])
        interval = None
        if pivot <= CERTAIN:
            interval = self._rank.valley(before, self._known, steps.at(i))
        sigma = self._known.sigma
        near = sigma < NEARLY_SINGULAR * self._rank.typical
        if not (near or interval or self._before is not None):
            change = float(np.linalg.norm(now.velocity - last.velocity))
            self._hardest = max(self._hardest, change / (now.t - last.t))
            return None, self._adapt(pivot, steps.t[i + 1], steps.y[i + 1])
        if self._before is None:
            self._inside(last)
        elif self._first_inside is None:
            self._first_inside = last
        if interval is not None:
            sigma_least, t_least = self._rank.least(*interval, steps.dense_output(i))
            if sigma_least < self._lowest:
                self._lowest, self._t_lowest = sigma_least, t_least
        elif sigma < self._lowest:
            self._lowest, self._t_lowest = sigma, now.t
        request = None
        if (
            self._lowest < AT_SINGULAR * self._rank.typical
            and self.treatment not in PASSES_SINGULAR
        ):
            request = self._cannot_pass(steps, i)
        if not near:
            request = request or self._came_out(last, now)
            self._inside(None)
            self._first_inside = None
            self._lowest = np.inf
        return request, False

    def _adapt(self, pivot: float, t: float, y: Array) -> bool:
        """Take the pivot of a regular step as known; return whether rows were chosen again.

        A pivot is of the order of sigma squared, by a factor that depends on which rows are
        nearly dependent: a small one asks for sigma once, and again only when it has shrunk.
        """
        if pivot > self._high:
            self._largest_pivot = pivot
            self._limit(LOWER_PIVOT * pivot, HIGHER_PIVOT * pivot)
            return False
        if self.model.redundant and pivot < LOWER_PIVOT * self._largest_pivot:
            self._keep_independent(t, y)
            return True
        self._limit(LOWER_PIVOT * min(pivot, self._low), self._high)
        return False

    def _keep_independent(self, t: float, y: Array) -> None:
        """Choose independent rows, as many as count, in state y; start from its pivot."""
        rows = self._observation.rows
        if self.model.redundant:
            rows.kept[:] = 0
            rows.kept[self._rank.independent(t, y)] = 1
        pivot = begin(self.model, self._observation.work, rows, float(t), y)
        self._largest_pivot = pivot
        self._limit(LOWER_PIVOT * pivot, HIGHER_PIVOT * max(pivot, CERTAIN))

    def _limit(self, low: float, high: float) -> None:
        """Set the pivots beyond which sigma is computed."""
        self._low, self._high = max(low, CERTAIN), high
        self._observation.limits[:] = self._low, self._high

    def _inside(self, before: _State | None) -> None:
        """Enter the neighbourhood of a singular position, where every step is looked at."""
        self._before = before
        self._observation.limits[0] = self._low if before is None else np.inf

    @property
    def note(self) -> Callable[[float, Array], bool]:
        """Observes the next step by itself; returns whether it is time to call the monitor."""
        return partial(note, self.model, self._observation)

    def look_at_spins_above(self, safe: Mapping[int, float]) -> None:
        """Have `note` ask for a look where a body spins faster than safe [rad/s]."""
        for body, spin in safe.items():
            self._observation.safe[body] = spin**2

    def _seen(self, steps: Steps, i: int = 0) -> tuple[Array, Array]:
        """Energies (k, 3) and least pivots (k,) of the steps from i on."""
        seen, count = self._observation, len(steps) - i
        noted = int(seen.noted[0])
        seen.noted[0] = 0
        if noted:
            return seen.energy[:noted].copy(), seen.pivots[:noted].copy()
        energy, pivots = np.empty((count, 3)), np.empty(count)
        observe(self.model, seen, steps.t[i + 1 :], steps.y[i + 1 :], energy, pivots)
        return energy, pivots

    def explain(self, t: float, y: Array) -> str:
        """Words on a run that failed at (t, y), if it is a singular position that stopped it."""
        if self._known is None:
            return ""
        sigma, names = self._rank.smallest(t, y)
        if sigma > NEARLY_SINGULAR * self._rank.typical:
            return ""
        return f"{self._where(t, names)}. {self._advice()}"

    def _state(self, t: float, y: Array) -> _State:
        return _State(float(t), self._velocities(y), self.energy.balance)

    def _velocities(self, y: Array) -> Array:
        """Velocities of states (..., n), scaled by the roots of the inertia."""
        n_pos = self.model.n_pos
        return y[..., n_pos : n_pos + self.model.n_vel] * self._root

    def _regular(self, steps: Steps, i: int, j: int, energy: Array) -> None:
        """Take steps i to j - 1, far from singular positions."""
        if j == i:
            return
        velocity = self._velocities(steps.y[i : j + 1])
        change = np.sqrt((np.diff(velocity, axis=0) ** 2).sum(axis=1))
        hardest = float((change / np.diff(steps.t[i : j + 1])).max())
        self._hardest = max(self._hardest, hardest)
        self.energy.take(steps.t[i + 1 : j + 1], energy[i:j], steps.y[i + 1 : j + 1, -1])
        self._last = _State(float(steps.t[j]), velocity[-1], self.energy.balance)

    def _where(self, t: float, names: list[str]) -> str:
        return f"the constraint Jacobian loses rank at t = {t:.6g} s, in joints {few(names)}"

    def _advice(self) -> str:
        if self.treatment == "augmented-lagrangian":
            return 'Raise `frequency`, or take constraints = "projection"'
        if self.treatment == "ggl":
            return (
                "Take `radau` or `rk8`, which pass it at every rtol, or increase rtol: near it, "
                "corrections of steps as short as those of rtol below 1e-5 are rounding"
            )
        if self.treatment in PASSES_SINGULAR:
            return "Decrease rtol; check lengths that nearly fit"
        return (
            f'Constraints = "{self.treatment}" cannot pass a singular position: take '
            '"projection", or "ggl" with integrator = "generalized-alpha"'
        )

    def _cannot_pass(self, steps: Steps, i: int) -> StopRequest | None:
        if self.passes and not self.stop:
            return None
        t = float(np.clip(self._t_lowest, steps.t[i], steps.t[i + 1]))
        _, names = self._rank.smallest(t, steps.dense_output(i)(t))
        text = f"{self._where(t, names)}: a singular position. {self._advice()}"
        self.passes.append(t)
        return self._found(SINGULAR.finding(text, t=t), t)

    def _came_out(self, last: _State, now: _State) -> StopRequest | None:
        """Judge a passage that is complete: energy kept, velocity continued."""
        before = self._before
        assert before is not None
        if self._lowest >= AT_SINGULAR * self._rank.typical:
            return None
        if self.treatment in PASSES_SINGULAR:
            self.passes.append(self._t_lowest)
        loss = abs(now.balance - before.balance) / max(self.energy.in_play, 1e-300)
        turn = self._turn(last)
        if loss < UNDAMPED and turn < UNTURNED:
            return None
        text = (
            f"the run left the singular position at t = {self._t_lowest:.6g} s on another "
            f"branch, or with an impact: velocity turned by {turn:.2g}, energy balance changed by "
            f"{loss:.2g} of the energy in play. What follows is not the motion of the mechanism. "
            f"{self._advice()}"
        )
        return self._found(BRANCH.finding(text, t=self._t_lowest), now.t)

    def _found(self, finding: Finding, t_stop: float) -> StopRequest | None:
        """Keep a finding; return the request to stop because of it, if asked to."""
        self.findings.append(finding)
        return StopRequest(t_stop, finding.text, finding.code) if self.stop else None

    def passed(self) -> list[Finding]:
        """Return the singular positions that the run passed without harm, as one finding."""
        if self.findings or not self.passes:
            return []
        times = few(f"{t:.4g} s" for t in self.passes)
        text = (
            f"the run passed {len(self.passes)} singular positions, at t = {times}, where the "
            "mechanism can continue in more than one direction; velocity and energy are "
            "continuous there"
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
        if change <= EXPLAINED * self._hardest * (last.t - first.t):
            return 0.0
        return change / max(float(np.linalg.norm(first.velocity)), 1e-300)
