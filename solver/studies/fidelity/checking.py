"""Runs of the model of a plan and of its check, within the budget of the request."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, replace

import numpy as np

from ...inputs.case.record import REACTION
from ...math.arrays import Array
from ...run.timing import work_s
from .answer import Answer, not_compared
from .choice import accuracy_over_rtol
from .comparison import kind_of_signal
from .plan import (
    STATIC,
    TIGHTER,
    TIGHTER_AMPLIFIED,
    TIGHTEST,
    Plan,
    check_plan,
    covers,
    kind_of,
    outline,
    vibration_labels,
)
from .trial import Share, Trial, distance, horizon, promoted, promotions

POWER, POWER_OF_REACTIONS = 3.0, 2.5


def power_of(kind: str) -> float:
    """Return the power by which contributions of vibrations to a kind of signal decrease."""
    return POWER_OF_REACTIONS if kind == REACTION else POWER


def exhausted(
    check: Plan, ranked: Mapping[str, tuple[str, ...]], package: Mapping[str, tuple[str, ...]]
) -> dict[str, tuple[str, ...]]:
    """Return, by body, the kinds of which a check has all vibrations of its package.

    Parameters
    ----------
    ranked : labels of the vibrations that respond, by body; other kinds are left out
    package : labels of all vibrations of the packages of the check, by body
    """
    found = {}
    for name, body in check.bodies.items():
        responding = dict.fromkeys(kind_of(label) for label in ranked[name])
        left = {kind_of(label) for label in package[name] if label not in body.vibrations}
        kinds = tuple(kind for kind in responding if kind not in left)
        if kinds:
            found[name] = kinds
    return found


def tail(m: int, n: int, power: float = POWER) -> float:
    """Return the contribution of vibrations above n, over that of m + 1 to n."""
    known = float((np.arange(m + 1, n + 1) ** -power).sum())
    return (n + 0.5) ** (1.0 - power) / (power - 1.0) / known if known else 0.0


MARGIN = 0.9  # of the accuracy: estimate up to which a request counts as met
SECOND_CHECK = 1.0 / 3.0  # of the accuracy: estimate from which a second check runs
SECOND_COST = 4.0  # CPU time of a second check over that of the first: more modes, 0.3 of its rtol
TIGHTENED = 10.0  # tolerance of a check of joint forces over that of the run it is compared with
SPLIT_COST = 0.5  # of the budget that is left, for all runs of a split


@dataclass
class Checking:
    """Checks the plan of an answer and promotes it.

    Attributes
    ----------
    accuracy, metric : of the request
    budget : CPU seconds
    may_promote : the plan may be changed
    """

    answer: Answer
    accuracy: float
    metric: str
    budget: float
    may_promote: bool = True
    begin: float = field(default_factory=work_s)

    def __post_init__(self) -> None:
        answer, signals = self.answer, self.answer.spec.mechanism.signals
        kinds = {name: kind_of_signal(name, signals) for name in answer.names}
        by_kind, by_size = accuracy_over_rtol(answer.study.indicators, kinds)
        self.tighter = TIGHTER_AMPLIFIED if by_size > by_kind else TIGHTER
        self.powers = np.array([power_of(kinds[name]) for name in answer.names])
        answer.reactions = np.array([kinds[name] == REACTION for name in answer.names])
        self.ranked = {name: answer.study.indicators.ranked(name) for name in answer.plan.bodies}
        self._stuck = False  # nothing is left to promote towards the last check
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
        found = answer.run(plan)
        if found is not None and found.complete:
            answer.tried.append((outline(plan), found.cpu, found.signals))
            self._known.append(found)
        return found

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

    def _check_plan(self, more: int = 2) -> Plan:
        check = self.answer.study.check
        return check_plan(self.answer.plan, self.ranked, check, more, self.tighter)

    def _covered(self, wanted: Plan) -> bool:
        """Tell whether the last check is one of the plan, for which `wanted` would be made."""
        answer = self.answer
        return answer.check is not None and covers(
            answer.check.plan, wanted, answer.plan, self.ranked, answer.study.check
        )

    def _estimate(self, errors: Array) -> float:
        """Take errors (o,) as those of the model; return the largest."""
        self.answer.estimate = self._estimates = errors
        self._largest = float(errors.max(initial=0.0))
        return self._largest

    def _fits(self) -> bool:
        """Tell whether the estimate is within the accuracy."""
        return self._largest <= MARGIN * self.accuracy

    def _close(self) -> bool:
        """Tell whether the estimate is so near the accuracy that one check is not enough."""
        return self.accuracy * SECOND_CHECK < self._largest and self._fits()

    def settled(self) -> bool:
        """Run model and check; tell whether the request is met, or nothing can help."""
        answer = self.answer
        answer.settled = None
        with self._timed("model"):
            answer.trial = self.run(answer.plan) or answer.trial  # the first whatever the budget
        with self._timed("check"):
            wanted, last = self._check_plan(), answer.check
            covered = self._covered(wanted)
            if not covered:
                # A richer check is worth its time if the model agrees with the last one.
                if last is not None and not self._stuck:
                    self._estimate(distance(self.metric, *answer.pair))
                if last is None or self._stuck or self._fits():
                    answer.check = self.run(wanted) or last
                    covered = answer.check is not last
        answer.rounds += 1
        answer.verdict = "not met"
        if answer.check is None or answer.trial is None:
            answer.reason = "the model of the plan cannot be assembled"
            if answer.check is None:
                answer.reason = "no check: the budget is used up, or its model cannot be assembled"
            return True
        self._estimate(distance(self.metric, *answer.pair))
        if self._close() and covered:
            fits = SECOND_COST * answer.check.cpu <= self.left()
            if self.may_promote and not self._stuck and not fits:
                answer.reason = f"the check differs by {self._largest:.2g}, which is near the "
                answer.reason += "accuracy"
                return False  # a richer model takes less time than a richer check
            self._second()
        early = not_compared(*answer.pair)
        answer.reason = early or f"the check differs by {self._largest:.2g}"
        if answer.pair[1].finished.solution.code:  # a finding: a promoted model does not change it
            return True
        if not covered and self._fits():
            answer.reason = "the model has all that its last check has, and no run checks it"
        return covered and self._fits() and self._met()

    def _second(self) -> None:
        """Compare with a richer check; keep the larger estimate and deliver the richer run."""
        wanted = self._check_plan(more=4)
        self._checked_again(replace(wanted, rtol=0.3 * wanted.rtol))

    def _checked_again(self, plan: Plan) -> bool:
        """Compare with another check, keep the larger estimate, deliver that run; False without."""
        with self._timed("check"):
            other = self.run(plan)
        if other is None or not other.complete:
            return False
        self.answer.check = other
        again = distance(self.metric, *self.answer.pair)
        self._estimate(np.maximum(self._estimates, again))
        return True

    def _tighten(self) -> None:
        """Compare the check of joint forces with the same one of a tighter tolerance; deliver that.

        They have the accelerations of fast vibrations, which a check does not damp: its tolerance
        may change them by more than it differs from the model, which does not have them.
        """
        answer, check = self.answer, self.answer.pair[1]
        plan = replace(check.plan, rtol=max(check.plan.rtol / TIGHTENED, TIGHTEST))
        if not answer.reactions.any() or SECOND_COST * check.cpu > self.left():
            return
        if self._checked_again(plan):
            answer.settled = distance(self.metric, check, answer.pair[1])

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
            return more is not None and float(more.max()) > MARGIN * self.accuracy
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
        where; None if the check does not have all vibrations of a kind."""
        study, check = self.answer.study, self.answer.pair[1]
        model, finer = (
            {name: vibration_labels(rich.package) for name, rich in packages.items()}
            for packages in (study.model, study.check)
        )
        kinds = exhausted(check.plan, self.ranked, finer)
        poor, share = check.plan, np.zeros(len(self.powers))
        for name, these in kinds.items():
            if len(model[name]) < len(finer[name]):
                poor = poor.with_body(name, mesh="model")
                for kind in these:
                    m, n = (sum(kind_of(x) == kind for x in of[name]) for of in (model, finer))
                    share = np.maximum(share, [tail(m, n, power) for power in self.powers])
        if poor == check.plan:
            return None, ""
        other = self.run(poor)
        more = None if other is None else share * distance(self.metric, other, check)
        return more, ", ".join(f"{' and '.join(these)} of {name}" for name, these in kinds.items())

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
        answer, (model, check), found = self.answer, self.answer.pair, list[Share]()
        self._known.clear()
        single = [*promotions(model.plan, check.plan, self.ranked)]
        if len(single) * model.cpu <= SPLIT_COST * self.left():
            with self._timed("split"):
                for kind, body, plan in single:
                    if (other := self.run(plan)) is not None:
                        value = float(distance(self.metric, model, other).max(initial=0.0))
                        found.append(Share(kind, body, value if np.isfinite(value) else 1e300))
        answer.shares = sorted(found, key=lambda share: -share.value)
        more = promoted(
            answer.plan, check.plan, self.ranked, answer.shares, self._largest, self.accuracy
        )
        if more != answer.plan:
            answer.plan, self._stuck = more, False
            return True
        if self._stuck:
            return False
        self._stuck = self._close() or not self._covered(self._check_plan())
        return self._stuck

    def refuse(self) -> None:
        """Run all modes of the packages of the check, if the budget allows as much as a check.

        Load shapes that the base motion does not need stand for vibrations above those of the
        package: joint forces of the shaken cantilever have half the error.
        """
        answer = self.answer
        if answer.check is None or not answer.check.complete or self.left() < answer.check.cpu:
            return
        plan = answer.check.plan
        for name in plan.bodies:
            plan = plan.with_body(name, whole=True)
        if plan == answer.check.plan:  # rigid bodies alone
            return
        with self._timed("check"):
            answer.finest = self.run(plan)
