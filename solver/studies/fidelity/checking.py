"""Runs of the model of a plan and of its check, within the budget of the request."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace

import numpy as np

from ...inputs.case.record import REACTION
from ...math.arrays import Array
from ...run.timing import work_s
from ..tolerances import REQUEST_MET, SPLIT_COST, SURELY_MET, TIGHTENED_COST
from .answer import Answer, not_compared
from .choice import MOTIONS, accuracy_over_rtol
from .comparison import kind_of_signal
from .plan import (
    STATIC,
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
    """Return the contribution of vibrations above n, over that of m + 1 to n."""
    known = float((np.arange(m + 1, n + 1) ** -power).sum())
    return (n + 0.5) ** (1.0 - power) / (power - 1.0) / known if known else 0.0


TIGHTENED = 30.0  # tolerance of a check of joint forces over that of the run it is compared with


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
        self._in_sections = any(kinds[name] not in plain for name in answer.names)
        answer.reactions = np.array([kinds[name] == REACTION for name in answer.names])
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

    def run(self, plan: Plan) -> Trial | None:
        """Run a plan; None if it cannot be assembled or, after the first check, without budget."""
        answer = self.answer
        for trial in self._known:
            if trial.plan == plan:
                return trial
        if self.left() <= 0.0 and answer.check is not None:
            return None
        result = answer.run(plan)
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
        answer.settled = None
        with self._timed("model"):
            answer.trial = self.run(answer.plan) or answer.trial  # the first whatever the budget
        wanted = check_plan(answer.plan, answer.study.check, self.tighter)
        if answer.check is None or answer.check.plan.rtol > wanted.rtol:
            with self._timed("check"):
                answer.check = self.run(wanted) or answer.check
        answer.rounds += 1
        answer.verdict = "not met"
        if answer.check is None or answer.trial is None:
            answer.reason = "the model of the plan cannot be assembled"
            if answer.check is None:
                answer.reason = "no check: the budget is used up, or its model cannot be assembled"
            return True
        self._estimate(distance(self.metric, *answer.pair))
        early = not_compared(*answer.pair)
        answer.reason = early or f"the check differs by {self._largest:.2g}"
        if answer.pair[1].finished.solution.code:  # a finding: a promoted model does not change it
            return True
        if self._fits() and answer.check.plan.rtol > wanted.rtol:
            answer.reason = "no check has a tolerance below that of the model"
            return False
        return self._fits() and self._met()

    def _tighten(self) -> None:
        """Compare the check of joint forces with the same one of a tighter tolerance; deliver that.

        They have the accelerations of fast vibrations, which a check does not damp: its tolerance
        may change them by more than it differs from the model, which does not have them.
        """
        answer, (model, check) = self.answer, self.answer.pair
        plan = replace(check.plan, rtol=max(check.plan.rtol / TIGHTENED, TIGHTEST))
        if not answer.reactions.any() or TIGHTENED_COST * check.cpu > self.left():
            return
        with self._timed("check"):
            other = self.run(plan)
        if other is not None and other.complete:
            answer.check, answer.settled = other, distance(self.metric, check, other)
            self._estimate(np.maximum(self._estimates, distance(self.metric, model, other)))

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
            )
            # More of the packages does not help if they lack too much.
            return more is not None and float(more.max()) > REQUEST_MET * self.accuracy
        if reason := self._meshes():
            answer.reason = reason
            return True
        self._tighten()
        if not self._fits():
            answer.reason = f"a check of a tighter tolerance differs by {self._largest:.2g}"
            return False
        answer.verdict, answer.reason = "met", ""
        if self.metric == "pointwise" and self.left() > 0.0:
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
        finer = any(b.mesh == "check" and not b.rigid for b in model.plan.bodies.values())
        sure = self._largest <= SURELY_MET * self.accuracy and not finer
        use_model = sure and (not self._in_sections or self.left() <= 0.0)
        poor, share, blind = check.plan, np.zeros(len(self.powers)), list[str]()
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
        other = model if use_model else self.run(poor)
        missing = None if other is None else share * distance(self.metric, other, check)
        return missing, ", ".join(blind)

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

        All at once if the runs that tell the shares would take most of the budget.
        """
        answer, (model, check), shares = self.answer, self.answer.pair, list[Share]()
        self._known.clear()
        single = [*promotions(model.plan, check.plan, self.ranked)]
        if len(single) * model.cpu <= SPLIT_COST * self.left():
            with self._timed("split"):
                for kind, body, changes in single:
                    if (other := self.run(model.plan.with_body(body, **changes))) is not None:
                        value = float(distance(self.metric, model, other).max(initial=0.0))
                        shares.append(Share(kind, body, value if np.isfinite(value) else 1e300))
        answer.shares = sorted(shares, key=lambda share: -share.value)
        more = promoted(
            answer.plan, check.plan, self.ranked, answer.shares, self._largest, self.accuracy
        )
        changed = more != answer.plan
        answer.plan = more
        return changed
