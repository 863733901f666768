"""The outcome of a plan, as an engineer reads it and as an entry of summary.json."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np

from ...checks.modes import motion_findings
from ...errors import counted
from ...math.arrays import Array
from ...run.inputs import RunSpec
from ..tolerances import NO_COST
from .indicators.base_motion import Study
from .indicators.beam_theory import beam_theory
from .plan import Plan
from .trial import Share, Trial, attempted


def beyond_theory(trial: Trial) -> list[str]:
    """Return, for each body that turns too far in itself, by how much and what to change."""
    return [finding.text for finding in motion_findings(trial.finished)]


def not_compared(model: Trial, check: Trial | None) -> str:
    """Return why model and check could not be compared; "" if both reached the end."""
    reasons = []
    for trial, what in ((check, "check"), (model, "model")):
        if trial is not None and not trial.complete:
            solution = trial.finished.solution
            end = f"the run of the {what} stopped at t = {solution.t[-1]:.4g} s"
            by = f" by `{solution.code}`" if solution.code else ""
            reasons.append(f"{end}{by} ({solution.message})")
    if reasons and model.complete:
        reasons.append("the run of the model did not, so that its error is not known")
    return "; ".join(reasons)


@dataclass
class Answer:
    """A plan with what is known of it.

    Attributes
    ----------
    losses : (o,) by the indicators, of the scale
    estimate : (o,) error of the model of the plan, by the check; None: not checked
    verdict : "planned", "met", "not met"
    horizon : time at which a change of 1e-6 has grown to the accuracy [s]; None: not in the run
    tried : name of the promotion, CPU time and signals (o, k) of each run on the way
    beyond : where the delivered run leaves the range of the theory, in words
    plan_sha256 : of the plan as it was read from its file, or written there
    delivered : the run of the check; that of the model if the check did not reach the end
    """

    spec: RunSpec
    names: list[str]
    study: Study
    plan: Plan
    losses: Array
    cpu: dict[str, float]
    estimate: Array | None = None
    verdict: str = "planned"
    shares: list[Share] = field(default_factory=list)
    trial: Trial | None = None
    check: Trial | None = None
    rounds: int = 0
    reason: str = ""
    horizon: float | None = None
    tried: list[tuple[str, float, Array]] = field(default_factory=list)
    beyond: list[str] = field(default_factory=list)
    plan_sha256: str = ""

    @property
    def estimates(self) -> dict[str, float]:
        """Estimated errors of the model by signal; infinite if a run ended early; none: not
        checked."""
        if self.estimate is None:
            return {}
        return dict(zip(self.names, self.estimate.tolist(), strict=True))

    def run(
        self, plan: Plan, seconds: float = np.inf, longest: float | None = None
    ) -> Trial | None:
        """Run a plan of the same bodies; see `attempted`.

        Parameters
        ----------
        plan : models of the bodies
        seconds : CPU time after which the run stops
        longest : limit of its steps [s]; None: that of the case
        """
        study, spec = self.study, self.spec
        if longest is not None:
            spec = spec.changed({"solver.max_step": longest})
        quiet = study.indicators.quiet
        return attempted(spec, plan, study.model, study.check, self.names, quiet, seconds)

    @property
    def pair(self) -> tuple[Trial, Trial]:
        """Runs of the model and of its check, of an answer that has been checked."""
        assert self.trial is not None
        assert self.check is not None
        return self.trial, self.check

    @property
    def delivered(self) -> Trial | None:
        """The run whose result is delivered."""
        known = [trial for trial in (self.check, self.trial) if trial is not None]
        return next((trial for trial in known if trial.complete), known[0] if known else None)

    @property
    def delivered_name(self) -> str:
        """Which run is delivered: "model" or "check"."""
        if self.delivered is None:
            return "none"
        return "check" if self.delivered is self.check else "model"

    @property
    def delivered_at_most(self) -> dict[str, float | None]:
        """What the error of the delivered run is at most, by signal; None: not estimated.

        The check has more of everything than the model, so that its error is smaller. How much
        smaller is not known. A run that no other one was compared with has no estimate. Neither has
        one of a request that is not met: its check may change by its tolerance or its mesh.
        """
        met = self.verdict == "met" and self.delivered is self.check
        known = (estimate_entry(self) if met else None) or {}
        return {name: known.get(name) for name in self.names}


JOINTS = "the joints: rigid, with the friction and clearance that the case describes"
NOT_CHECKED = (
    "the cross-sections and materials of the bodies: both packages have the same",
    JOINTS,
    "the theory: beams and shells of small strain in both runs; geometrically exact theories "
    "may differ pointwise by more than 1e-3 in vibrating signals",
)
BETWEEN = (
    "the surface of shells between the nodes of mesh files: finer meshes split their flat cells"
)
DELIVERED = {
    "check": "the check",
    "model": "the chosen model",
}
ONE_PACKAGE = "bodies of one package: its mesh and its modes"
UNSTIFFENED = "geometric stiffening: no second-order data"


def not_checked(answer: Answer) -> list[str]:
    """Return what neither the plan nor the check looks at."""
    bodies = answer.spec.mechanism.bodies
    lines = list(NOT_CHECKED) if answer.plan.bodies else [JOINTS]
    rich = answer.study.check if answer.check is not None else answer.study.model
    second = [name for name in rich if rich[name].package.second_order is not None]
    kinds = {name: bodies[name].kind for name in answer.plan.bodies}
    for text, names in (
        (ONE_PACKAGE, [n for n in kinds if kinds[n] in ("package", "imported", "solid")]),
        (BETWEEN, [n for n in kinds if kinds[n] == "shell"]),
        (UNSTIFFENED, [n for n in kinds if n not in second]),
    ):
        if names:
            lines.append(f"{text} ({', '.join(names)})")
    return lines


def entry(answer: Answer) -> dict[str, object]:
    """Return the entry `fidelity` of summary.json."""
    fidelity, delivered = answer.spec.fidelity, answer.delivered
    scale = delivered.scales(fidelity.metric) if delivered else answer.study.indicators.scale
    return {
        "asked": fidelity.accuracy,
        "metric": fidelity.metric,
        "scale": dict(zip(answer.names, scale.tolist(), strict=True)),
        "plan": answer.plan.table(),
        "losses": dict(zip(answer.names, answer.losses.tolist(), strict=True)),
        "estimate": estimate_entry(answer),
        "delivered": {"run": answer.delivered_name, "error_at_most": answer.delivered_at_most},
        "shares": [asdict(share) for share in answer.shares],
        "rounds": answer.rounds,
        "cpu": dict(answer.cpu),
        "verdict": answer.verdict,
        "reason": answer.reason,
        "base": answer.study.base.reason or "rigid",
        "horizon": answer.horizon,
        "theories": theories(answer),
        "beyond_theory": answer.beyond,
        "not_checked": not_checked(answer),
    }


def theories(answer: Answer) -> list[str]:
    """Return, for each flexible beam of the plan, whether a beam is enough or a shell is needed."""
    fidelity, mechanism = answer.spec.fidelity, answer.spec.mechanism
    theories_used = [
        beam_theory(mechanism, name, body, answer.study.model[name], answer.study.indicators)
        for name, body in answer.plan.bodies.items()
    ]
    return [one.words(fidelity.accuracy) for one in theories_used if one is not None]


def estimate_entry(answer: Answer) -> dict[str, float | None] | None:
    """Return the estimated errors of the model; None: not checked, or a run ended early."""
    if answer.estimate is None:
        return None
    return {name: e if np.isfinite(e) else None for name, e in answer.estimates.items()}


def fidelity_line(fidelity: Mapping[str, Any]) -> str:
    """Return the entry of summary.json in one line."""
    estimate, delivered = "no estimate of the error", fidelity.get("delivered", {})
    values = [*(fidelity["estimate"] or {}).values()]
    if values and None not in values:
        estimate = f"estimated error of the chosen model {max(values):.1e}"
    most = [*delivered.get("error_at_most", {}).values()]
    if (run := delivered.get("run", "none")) != "none":
        bound = f"at most about {max(most):.1e}" if most and None not in most else "not estimated"
        estimate += f"; delivered: {DELIVERED[run]}, error {bound}"
    reason = f", {fidelity['reason']}" if fidelity["reason"] else ""
    return f"accuracy {fidelity['asked']:g} {fidelity['verdict']}: {estimate}{reason}"


def remarks(answer: Answer) -> list[str]:
    """Return the lines at the top of a plan file."""
    fidelity = answer.spec.fidelity
    return [
        f"Plan of run {answer.spec.run} of case {answer.spec.case}, accuracy "
        f"{fidelity.accuracy:g} ({fidelity.metric}).",
        f"Verdict: {answer.verdict}" + (f", {answer.reason}." if answer.reason else "."),
        "A run uses this file as long as its inputs are the same. It may be edited: an edited plan",
        "is checked, but not changed.",
    ]


def answer_text(answer: Answer) -> str:
    """Return the answer in words."""
    fidelity = answer.spec.fidelity
    lines = [
        f"{answer.spec.case}, run {answer.spec.run}: {', '.join(answer.names)} to "
        f"{fidelity.accuracy:g} of the largest value ({fidelity.metric})",
        "",
    ]
    if answer.study.base.reason:
        lines += [f"The bodies cannot all be rigid: {answer.study.base.reason}", ""]
    lines += _model(answer.plan)
    if omissions := _omissions(answer):
        lines += ["", *omissions]
    lines.append("")
    lines += [f"{text[0].upper()}{text[1:]}." for text in theories(answer)]
    if answer.estimate is None:
        lines.append(f"Not checked{': ' + answer.reason if answer.reason else ''}.")
    else:
        run = DELIVERED.get(answer.delivered_name, "")
        for o, (name, value) in enumerate(answer.estimates.items()):
            model = f"{value:.1e}" if np.isfinite(value) else "not estimated"
            most = answer.delivered_at_most[name]
            bound, zero = "not estimated" if most is None else f"at most about {most:.1e}", ""
            if answer.check is not None and (size := answer.check.sizes[o]) > 0.0:
                zero = "; the signal is zero to rounding or noise: errors are relative to "
                zero += f"{size:.2g}, the size of related signals"
            lines.append(
                f"Estimated error of {name}: chosen model {model}; delivered run {bound}{zero}"
            )
        texts = {"met": "The request is met", "not met": "The request is NOT met"}
        reason = f": {answer.reason}" if answer.reason else ""
        result = f"The result of {run} is delivered." if run else "No result is delivered."
        lines.append(f"{texts[answer.verdict]}{reason}. {result}")
    lines += [f"Beyond the theory of both runs: {text}." for text in answer.beyond]
    if answer.horizon is not None:
        lines.append(
            f"After t = {answer.horizon:.4g} s the motion is too sensitive for this accuracy: a "
            "change of the masses by 1e-6 has grown to it (chaos, or vibrations that lose step). "
            "The estimate holds for this run only."
        )
    if answer.shares:
        lines += ["", "Shares of the error of the last plan that was too coarse:"]
        for share in answer.shares[:6]:
            body = f" of {share.body}" if share.body else ""
            lines.append(f"  {share.kind}{body}: {share.value:.1e}")
    cpu = ", ".join(f"{name} {value:.2f}" for name, value in answer.cpu.items())
    if answer.trial is not None:
        cpu += f"; a run of the chosen model {answer.trial.cpu:.2f}"
    lines += ["", f"CPU seconds: {cpu}", "Not checked:"]
    lines += [f"  - {text}" for text in not_checked(answer)]
    return "\n".join(lines)


def _model(plan: Plan) -> list[str]:
    if not plan.bodies:
        return [
            "Model: all bodies are rigid, the tolerance alone is chosen",
            f"  rtol = {plan.rtol:.2g}",
        ]
    lines = ["Model:"]
    for name, body in plan.bodies.items():
        if body.rigid:
            lines.append(f"  {name}: rigid")
            continue
        kept, shapes = counted(len(body.vibrations), "vibration"), "no static shapes"
        if body.vibrations:
            kept += f" ({', '.join(body.vibrations)})"
        if body.static:
            ring = "undamped" if body.ringing else "damped"
            shapes = f"{counted(body.static, 'static shape')}, {ring}"
        mesh = {"model": "first package", "check": "second package, with the finer mesh"}[body.mesh]
        lines.append(f"  {name}: {kept}, {shapes}; {mesh}")
    lines.append(f"  geometric stiffening: {'on' if plan.stiffening else 'off'}")
    lines.append(f"  rtol = {plan.rtol:.2g}")
    return lines


def _omissions(answer: Answer) -> list[str]:
    """Return what each omission costs by the indicators."""
    indicators, plan = answer.study.indicators, answer.plan
    if not plan.bodies:
        return []
    worth = indicators.worth({name: body.static > 0 for name, body in plan.bodies.items()})
    lines = ["Indicated cost of what the model leaves out (of the largest value of a signal):"]
    for name, body in plan.bodies.items():
        mine = [
            (value, mode.label)
            for value, mode in zip(worth.tolist(), indicators.modes, strict=True)
            if mode.body == name
            and mode.label not in body.vibrations
            and (mode.vibration or not body.static)
        ]
        left = [f"{label} {value:.1e}" for value, label in sorted(mine)[:-4:-1] if value > NO_COST]
        lines.append(f"  {name}: {', '.join(left) or 'nothing that responds'}")
    if not plan.stiffening:
        worst = float(indicators.stiffening.max(initial=0.0))
        lines.append(f"  geometric stiffening: {worst:.1e}")
    for name, ratio in indicators.spin.items():
        if ratio > 0.25:
            lines.append(f"  {name} spins at {ratio:.2f} of its first clamped frequency")
    return lines
