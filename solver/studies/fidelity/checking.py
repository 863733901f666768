"""Runs of the model of a plan and of its check, within the budget of the request."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace

import numpy as np

from ...inputs.case.record import REACTION
from ...math.arrays import Array
from ...package.body.invariants import MOST_MODES
from ...results.codes import LOADED_START
from ...run.timing import work_s
from ..tolerances import (
    LACKING,
    LADDER_COST,
    MORE_STEPS,
    REQUEST_MET,
    SPLIT_COST,
    STIFFENING_SPIN,
    SURELY_MET,
)
from .answer import Answer, not_compared
from .choice import MOTIONS, accuracy_over_rtol
from .comparison import kind_of_signal
from .plan import (
    STATIC,
    TIGHT,
    TIGHTER,
    TIGHTER_AMPLIFIED,
    TIGHTEST,
    Plan,
    check_plan,
    kind_of,
    outline,
    vibration_labels,
)
from .trial import Share, Trial, distance, horizon, promoted, promotions

POWER, POWER_OF_REACTIONS = 3.0, 2.5


def power_of(kind: str) -> float:
    """Return the power by which contributions of vibrations to a kind of signal decrease."""
    return POWER_OF_REACTIONS if kind == REACTION else POWER


def tail(m: int, n: int, power: float = POWER) -> float:
    """Return the contribution of vibrations above n, over that of m + 1 to n.

    Parameters
    ----------
    m, n : numbers of vibrations, m < n; 0 if n = m
    power : by which contributions decrease: that of number i is i^-power
    """
    known = float((np.arange(m + 1, n + 1) ** -power).sum())
    return (n + 0.5) ** (1.0 - power) / (power - 1.0) / known if known else 0.0


FINER_BODIES = (
    "; strengths are looked for at the elements: more `elements` of beams, or `refine` of shells, "
    "make both packages finer"
)
LADDER = 3.0  # tolerance of a check over that of the next one
FINER = LADDER**0.25  # steps of a check over those of the last one, by an error estimate of order 3


def more_steps(check: Trial, other: Trial) -> bool:
    """Tell whether another check has so many more steps that their difference shows an error."""
    return other.steps >= MORE_STEPS * check.steps


@dataclass
class Checking:
    """Checks the plan of an answer and promotes it.

    Attributes
    ----------
    accuracy, metric : of the request
    budget : CPU seconds
    """

    answer: Answer
    accuracy: float
    metric: str
    budget: float
    begin: float = field(default_factory=work_s)

    def __post_init__(self) -> None:
        answer, signals = self.answer, self.answer.spec.mechanism.signals
        kinds = {name: kind_of_signal(name, signals) for name in answer.names}
        by_kind, by_size = accuracy_over_rtol(answer.study.indicators, kinds)
        self.tighter = TIGHTER_AMPLIFIED if by_size > by_kind else TIGHTER
        self.powers = np.array([power_of(kinds[name]) for name in answer.names])
        plain = (*MOTIONS, "deflection", "rotation", REACTION)
        self._finer = FINER_BODIES if {"exposure", "strength_ratio"} & {*kinds.values()} else ""
        self._in_sections = any(kinds[name] not in plain for name in answer.names)
        # Where the tolerance follows from small deflections, a tenth of it may take more than the
        # budget. Joint forces have fast vibrations, which a check does not damp. So checks of
        # falling tolerances run until they agree: at least to this tolerance, because they change
        # by little as long as no check has a vibration. Joint forces change by two steps.
        rtol, reactions = self.accuracy / max(by_size, by_kind), REACTION in kinds.values()
        self._ladder = reactions or (by_size > by_kind and rtol < TIGHT)
        self._steps = 2 if reactions else 1
        self._rtol = min(rtol / LADDER ** (self._steps - 1), TIGHT)
        self._looser = int(np.log(TIGHT / self._rtol) / np.log(LADDER))  # checks above it
        self._longest: float | None = None  # step of the checks [s]
        self._checks = [answer.check] if answer.check is not None else []
        self.ranked = {name: answer.study.indicators.ranked(name) for name in answer.plan.bodies}
        self._known: list[Trial] = []  # of the last split: one of them may be the next model

    def left(self) -> float:
        """CPU seconds that are left of the budget."""
        return self.budget - (work_s() - self.begin)

    @contextmanager
    def _timed(self, part: str) -> Iterator[None]:
        begin = work_s()
        yield
        cpu = self.answer.cpu
        cpu[part] = cpu.get(part, 0.0) + work_s() - begin

    def run(self, plan: Plan, longest: float | None = None) -> Trial | None:
        """Run a plan; None if it cannot be assembled or if another run than the first model and
        the first check does not end within the budget."""
        answer = self.answer
        for trial in self._known:
            if trial.plan == plan:
                return trial
        first = answer.trial is None or (answer.check is None and answer.trial.complete)
        if self.left() <= 0.0 and answer.trial is not None:
            return None
        result = answer.run(plan, self.left(), longest)
        if result is not None and not (result.complete or first) and self.left() <= 0.0:
            return None
        if result is not None and result.complete:
            answer.tried.append((outline(plan), result.cpu, result.signals))
            self._known.append(result)
        return result

    def assemble(self) -> None:
        """Give flexible bodies static shapes if the model of the plan cannot be assembled.

        A quasi-static start under large loads needs them, whatever they contribute to the signals.
        """
        answer = self.answer
        with self._timed("model"):
            if self.run(answer.plan) is None:
                for name, body in answer.plan.bodies.items():
                    static = 0 if body.rigid else max(body.static, STATIC)
                    answer.plan = answer.plan.with_body(name, static=static)

    def _estimate(self, errors: Array) -> float:
        """Take errors (o,) as those of the model; return the largest."""
        self.answer.estimate = self._estimates = errors
        self._largest = float(errors.max(initial=0.0))
        return self._largest

    def _fits(self) -> bool:
        """Tell whether the estimate is within the accuracy."""
        return self._largest <= REQUEST_MET * self.accuracy

    def settled(self) -> bool:
        """Run model and check; tell whether the request is met, or nothing can help."""
        answer = self.answer
        with self._timed("model"):
            answer.trial = self.run(answer.plan) or answer.trial
        wanted = check_plan(answer.plan, answer.study.check, self.tighter)
        if self._ladder:
            wanted = replace(wanted, rtol=min(self._rtol, answer.plan.rtol))
            while self._few(wanted) and self._next_check(wanted):
                pass
        elif answer.check is None or answer.check.plan.rtol > wanted.rtol:
            with self._timed("check"):
                answer.check = self.run(wanted) or answer.check
        answer.rounds += 1
        answer.verdict = "not met"
        if answer.check is None or answer.trial is None:
            answer.reason = "the model of the plan cannot be assembled"
            if answer.check is None:
                answer.reason = "no check: the budget is used up, or its model cannot be assembled"
            if answer.trial is not None:
                answer.reason = not_compared(answer.trial, answer.check) or answer.reason
            return True
        while True:
            early = not_compared(*answer.pair)
            apart = self._estimate(distance(self.metric, *answer.pair))
            answer.reason = early or f"the check differs by {self._largest:.2g}"
            if answer.pair[1].finished.solution.code:  # a promoted model does not change a finding
                return True
            if not self._ladder:
                break
            change = self._changed()
            known = change is not None
            lacks = self._expected() if change is None else LACKING * change
            self._estimate(self._estimates + lacks)
            if known and (self._fits() or float(lacks.max()) < apart):
                break
            if not self._next_check(wanted):
                answer.reason = self._unsettled()
                return True
        if self._fits() and answer.check.plan.rtol > wanted.rtol:
            answer.reason = "no check has a tolerance below that of the model"
            return False
        return self._fits() and self._met()

    def _few(self, plan: Plan) -> bool:
        """Tell whether no change is known, or no check has the tolerance of the plan."""
        return len(self._checks) <= self._steps or self._checks[-1].plan.rtol > plan.rtol

    def _tolerance(self, count: int) -> float:
        """Return the tolerance of the check after `count` others; one of them is `_rtol` itself."""
        return max(self._rtol * LADDER ** (self._looser - count), TIGHTEST)

    def _next_check(self, plan: Plan) -> bool:
        """Run a check of the next tolerance; False if the budget does not allow it."""
        checks = self._checks
        rtol = self._tolerance(len(checks))
        if checks:
            last = checks[-1]
            if rtol == last.plan.rtol or not last.complete or self._cost() > self.left():
                return False
            # Where laws of time or `max_step` limit the steps, the limit falls with the tolerance.
            if self._longest or (len(checks) > 1 and not more_steps(*checks[-2:])):
                t_end = self.answer.spec.mechanism.solver.t_end
                self._longest = t_end / (FINER * last.steps)
        with self._timed("check"):
            check = self.run(replace(plan, rtol=rtol), self._longest)
        if check is not None:
            self.answer.check = check
            checks.append(check)
        return check is not None

    def _cost(self) -> float:
        """CPU seconds of the next check."""
        return LADDER_COST * self._checks[-1].cpu

    def _changed(self) -> Array | None:
        """Return the last change of the check (o,); None: not known.

        Checks of equal steps are equal, whatever their error.
        """
        compared = self._checks[-1 - self._steps :]
        if len(compared) <= self._steps or not all(map(more_steps, compared, compared[1:])):
            return None
        return distance(self.metric, compared[0], compared[-1])

    def _expected(self) -> Array:
        """Return the errors (o,) that the tolerance of the check permits."""
        amplified, check = self.answer.study.indicators.amplified, self.answer.pair[1]
        return np.asarray(amplified * check.plan.rtol)

    def _unsettled(self) -> str:
        """Say what the check would need."""
        change = self._changed()
        known = "no change is known" if change is None else f"it changed by {change.max():.2g}"
        budget = self.answer.spec.fidelity.budget
        return (
            f"the check has not settled at rtol {self._checks[-1].plan.rtol:.2g} ({known}), and "
            f"the next one would take about {self._cost():.2g} s of CPU time, more than the budget "
            f"leaves: it needs about {budget - self.left() + self._cost():.2g} s{self._sudden()}"
        )

    def _sudden(self) -> str:
        """Say what leaves out the vibrations of bodies that begin undeformed under loads, or ""."""
        if self.answer.spec.mechanism.solver.start != "positions":
            return ""
        for rich in self.answer.study.model.values():
            energy = ((rich.eta @ rich.package.stiffness) * rich.eta).sum(axis=1)
            if energy[0] > LOADED_START.limit * energy.max():
                return (
                    f'; {rich.name} begins undeformed under loads: `solver.start = "quasi-static"` '
                    "leaves out the vibrations that follow, if they are not meant"
                )
        return ""

    def _met(self) -> bool:
        """Estimate what both packages lack; tell whether this settles the request."""
        answer, model = self.answer, self.answer.pair[0]
        with self._timed("check"):
            more, blind = self._unseen()
        lacking = f"no package has more vibrations ({blind})"
        if blind and more is None:
            answer.reason = f"{lacking}, and no run shows what is missing above them: the budget "
            answer.reason += "is used up"
            return True
        if more is not None:
            self._estimate(np.hypot(self._estimates, more))  # they peak at other times
        if not self._fits():
            answer.reason = (
                f"{lacking}; with what is missing above them the error is about {self._largest:.2g}"
                f"{self._sudden()}{self._finer}"
            )
            # More of the packages does not help if they lack too much.
            return more is not None and float(more.max()) > REQUEST_MET * self.accuracy
        if reason := self._unstiffened() or self._meshes():
            answer.reason = reason
            return True
        answer.verdict, answer.reason = "met", ""
        if self.metric == "pointwise" and model.cpu < self.left():
            with self._timed("horizon"):
                answer.horizon = horizon(model, answer.names, self.accuracy)
        return True

    def _unseen(self) -> tuple[Array | None, str]:
        """Return what vibrations above those of the packages contribute to the signals (o,), and
        where; None if no run tells.

        It follows from what vibrations of the check contribute that another run does not have: the
        check with the package of the model or, far below the accuracy, the model itself. Forces
        and stresses in sections follow from curvatures, which static shapes hide: they need the
        first, if there is a budget.
        """
        study, (model, check) = self.answer.study, self.answer.pair
        fine = any(b.mesh == "check" and not b.rigid for b in model.plan.bodies.values())
        sure = self._largest <= SURELY_MET * self.accuracy and not fine
        use_model = sure and (not self._in_sections or self.left() <= 0.0)
        looser = check
        if len(self._checks) > 1 and check.cpu > SPLIT_COST * self.left():
            looser = self._checks[-2]  # tells what vibrations contribute in a third of the time
        poor, share, blind = looser.plan, np.zeros(len(self.powers)), list[str]()
        for name, body in check.plan.bodies.items():
            less, more = (vibration_labels(of[name].package) for of in (study.model, study.check))
            kinds = dict.fromkeys(kind_of(label) for label in body.vibrations)
            if kinds and len(less) < len(more):
                poor = poor.with_body(name, mesh="model")
                blind.append(f"{' and '.join(kinds)} of {name}")
                less = model.plan.bodies[name].vibrations if use_model else less
                for kind in kinds:
                    m, n = (sum(kind_of(x) == kind for x in known) for known in (less, more))
                    share = np.maximum(share, [tail(m, n, power) for power in self.powers])
        if not blind:
            return None, ""
        other, finer = (model, check) if use_model else (self.run(poor), looser)
        missing = None if other is None else share * distance(self.metric, other, finer)
        return missing, ", ".join(blind)

    def _unstiffened(self) -> str:
        """Say which bodies spin so fast that they need the second-order data they lack, or ""."""
        study, bodies = self.answer.study, self.answer.plan.bodies
        names = [
            name
            for name, spin in study.indicators.spin.items()
            if spin > STIFFENING_SPIN and not bodies[name].rigid
            if study.check[name].package.second_order is None
        ]
        if not names:
            return ""
        return (
            f"{' and '.join(names)} would stiffen by spin, and no second-order data say how much: "
            f"beams and shells have them up to {MOST_MODES} modes, so with fewer loaded places, or "
            "in `segments`; shells and solids with second_order = true"
        )

    def _meshes(self) -> str:
        """Add the error of the meshes of shells to the estimate; say what is too much, or ""."""
        answer, model = self.answer, self.answer.pair[0]
        bodies, coarse = answer.spec.mechanism.bodies, model.plan
        finer = [
            name
            for name, body in model.plan.bodies.items()
            if bodies[name].kind == "shell" and body.mesh == "check" and not body.rigid
        ]
        if not finer:
            return ""
        for name in finer:
            coarse = coarse.with_body(name, mesh="model")
        with self._timed("check"):
            other = self.run(coarse)
        names = " and ".join(finer)
        if other is None:
            return f"no run shows the error of the mesh of {names}: the budget is used up"
        error = distance(self.metric, other, model)
        self._estimate(np.hypot(self._estimates, error))
        if self._fits():
            return ""
        return (
            f"the two meshes of {names} differ by {float(error.max()):.2g}; `refine` of the body "
            "makes both finer"
        )

    def promote(self) -> bool:
        """Promote what has the largest shares of the difference; False if nothing is left.

        All at once if the runs that tell the shares would take most of the budget: with checks of
        falling tolerances, the model then is one of them, which has run.
        """
        answer, (model, check), shares = self.answer, self.answer.pair, list[Share]()
        self._known[:] = self._checks
        single = [*promotions(model.plan, check.plan, self.ranked)]
        split = len(single) * model.cpu <= SPLIT_COST * self.left()
        if split:
            with self._timed("split"):
                for kind, body, changes in single:
                    if (other := self.run(model.plan.with_body(body, **changes))) is not None:
                        value = float(distance(self.metric, model, other).max(initial=0.0))
                        shares.append(Share(kind, body, value if np.isfinite(value) else 1e300))
        answer.shares = sorted(shares, key=lambda share: -share.value)
        more = promoted(
            answer.plan, check.plan, self.ranked, answer.shares, self._largest, self.accuracy
        )
        if self._ladder and not split:
            more = self._checks[-self._steps].plan
        before, answer.plan = answer.plan, more
        return more != before or (self._ladder and self._next_check(check.plan))
