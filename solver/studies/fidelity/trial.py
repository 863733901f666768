"""Runs of a plan, their differences by kind and body, and the horizon of pointwise promises."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from ...checks.finished_run import FinishedRun
from ...errors import InputError
from ...math.arrays import Array
from ...package import ModalPackage
from ...package.body.package_file import SUMS
from ...results import RunResult, Summary
from ...run.inputs import RunSpec
from ...run.outcome import collect
from ...run.preparation import Prepared, complete, prepare
from ...run.timing import work_s
from ...signals import Recording
from ..tolerances import LEAST_RTOL, PROMOTED
from .comparison import difference, relatives, scales
from .plan import Plan, Rich, planned, with_values


@dataclass(frozen=True)
class Trial:
    """A run of a plan.

    Attributes
    ----------
    signals : (o, k)
    sizes : (o,) of signals that are rounding or noise: what they are compared with; of others 0
    complete : it reached the end
    cpu : seconds, building and integration
    """

    plan: Plan
    spec: RunSpec
    prepared: Prepared
    finished: FinishedRun
    signals: Array
    sizes: Array
    complete: bool
    cpu: float

    def scales(self, metric: str) -> Array:
        """Return what errors of the signals are relative to, (o,)."""
        return np.where(self.sizes > 0.0, self.sizes, scales(metric, self.signals))

    @property
    def steps(self) -> int:
        """Number of the integrator's steps."""
        return int(self.finished.solution.counters.steps)

    def outcome(self) -> tuple[RunResult, Summary]:
        """Return result and summary of the run."""
        return collect(self.spec, self.prepared.measured, self.finished, self.cpu)


def attempted(
    spec: RunSpec,
    plan: Plan,
    model: Mapping[str, Rich],
    check: Mapping[str, Rich],
    names: list[str],
    quiet: npt.NDArray[np.bool_] | None = None,
    seconds: float = np.inf,
) -> Trial | None:
    """Run a plan; None if its model cannot be assembled.

    Parameters
    ----------
    spec : the run
    model, check : rich packages by body
    names : of the o signals
    quiet : (o,) those that are rounding by the indicators; None: not known
    seconds : CPU time after which the run stops
    """
    begin = work_s()
    return _ran(planned(spec, plan, model, check), plan, names, quiet, begin, seconds)


def _ran(
    spec: RunSpec,
    plan: Plan,
    names: list[str],
    quiet: npt.NDArray[np.bool_] | None,
    begin: float,
    seconds: float = np.inf,
) -> Trial | None:
    """Run the model of a plan, whose work began at `begin`; None if it cannot be assembled."""
    try:
        prepared = prepare(spec.mechanism, spec.packages)
        finished = complete(prepared, seconds)
    except InputError:
        return None
    solution = finished.solution
    recording = Recording(finished.model, solution.t, solution.y)
    compared = relatives(names, spec.mechanism, prepared.built, solution.y[0])
    measured = {n: s.values(recording) for n, s in compared.sensors(prepared.built).items()}
    signals, sizes = compared.judged(measured, plan.rtol, quiet)
    cpu = work_s() - begin
    whole = solution.status == "finished"
    return Trial(plan, spec, prepared, finished, signals, sizes, whole, cpu)


def distance(metric: str, one: Trial, two: Trial) -> Array:
    """Return the difference (o,) of the signals of two runs, of the largest value of the second.

    Infinite if one of them ended early.

    Parameters
    ----------
    metric : of `[fidelity]`: "pointwise", "extremum" or "rms"
    one, two : runs with the same signals and output times
    """
    if not (one.complete and two.complete):
        return np.full(len(two.signals), np.inf)
    return difference(metric, one.signals, two.signals) / two.scales(metric)


TIGHTER = 30.0  # tolerance of a plan over that of its promotion
TOLERANCE = "tolerance"  # the promotion after which a plan needs another check
MORE = 2  # vibrations that are promoted together


@dataclass(frozen=True)
class Share:
    """What one promotion changes: kind, body ("" of all), largest change of a signal."""

    kind: str
    body: str
    value: float


Ranked = Mapping[str, tuple[str, ...]]
Promotion = tuple[str, str, dict[str, object]]


def promotions(plan: Plan, check: Plan, ranked: Ranked) -> Iterator[Promotion]:
    """Yield kind, body ("" of all) and changes of each single promotion towards a check.

    Parameters
    ----------
    ranked : labels of the vibrations of the model's packages by body, largest loss first; the
        check has more of them
    """
    for name, body in plan.bodies.items():
        more = check.bodies[name]
        known = [label for label in ranked[name] if label in more.vibrations]
        left = [x for x in dict.fromkeys((*known, *more.vibrations)) if x not in body.vibrations]
        if added := left[:MORE]:
            mesh = "check" if set(added) - set(ranked[name]) else body.mesh
            yield "vibrations", name, {"vibrations": (*body.vibrations, *added), "mesh": mesh}
        if more.static > body.static:
            static = max(2 * body.static, body.static + 2)
            yield "statics", name, {"static": min(static, more.static)}
        if body.static and not body.ringing:
            yield "ringing", name, {"ringing": True}
        if body.mesh == "model" and not body.rigid:
            yield "mesh", name, {"mesh": "check"}
    if check.stiffening and not plan.stiffening:
        yield "stiffening", "", {"stiffening": True}
    rtol = max(LEAST_RTOL, check.rtol, plan.rtol / TIGHTER)
    if plan.rtol > rtol:
        yield TOLERANCE, "", {"rtol": rtol}


def promoted(
    plan: Plan,
    check: Plan,
    ranked: Ranked,
    shares: list[Share],
    estimate: float,
    accuracy: float,
) -> Plan:
    """Return the plan with the promotions of large shares; with all, if none explains the check.

    A share above the accuracy is large whatever the others are: another round would have to
    promote it. The tolerance is promoted for its own share, or if nothing else is left, because
    the plan then needs another check.

    Parameters
    ----------
    plan : that was checked
    check : the plan of its check
    ranked : labels of the vibrations by body, as for `promotions`
    shares : what single promotions change; none if they were not run
    estimate : error of the model
    accuracy : that is asked for, relative as `estimate`
    """
    largest = max((share.value for share in shares), default=0.0)
    every = not shares or estimate > 2.0 * largest
    least = min(PROMOTED * largest, accuracy)
    value = {(share.kind, share.body): share.value for share in shares}
    more = plan
    for kind, body, changes in promotions(plan, check, ranked):
        own = value.get((kind, body), 0.0)
        cheap = kind != TOLERANCE or own >= PROMOTED * accuracy or more == plan
        if own >= least > 0.0 or (every and cheap):
            more = more.with_body(body, **changes)
    return more


CHANGE = 1e-6  # of the masses of the bodies, relative; another one for each body


def horizon(trial: Trial, names: list[str], accuracy: float) -> float | None:
    """Return the time [s] from which a signal of the run with changed masses differs too much.

    None if that is never, or if the changed run ends early.

    Parameters
    ----------
    trial : the run
    names : of the signals
    accuracy : largest difference, of the largest value of the signal
    """
    other = _ran(changed(trial.spec), trial.plan, names, None, 0.0)
    if other is None or not (other.complete and trial.complete):
        return None
    sizes = trial.scales("pointwise")
    gap = np.abs(other.signals - trial.signals) / sizes[:, None]
    far = np.flatnonzero(gap.max(axis=0) > accuracy)
    return float(trial.finished.solution.t[far[0]]) if far.size else None


def changed(spec: RunSpec) -> RunSpec:
    """Return the run with masses changed by about CHANGE, differently for each body."""
    bodies = dict(spec.mechanism.bodies)
    factors = {n: 1.0 + CHANGE * float(np.cos(1.0 + i)) for i, n in enumerate(bodies)}
    for name, body in bodies.items():
        if body.kind == "rigid":
            inertia = [[factors[name] * x for x in row] for row in body.inertia]
            bodies[name] = with_values(body, mass=factors[name] * body.mass, inertia=inertia)
    packages = {name: _heavier(package, factors[name]) for name, package in spec.packages.items()}
    return replace(spec, mechanism=with_values(spec.mechanism, bodies=bodies), packages=packages)


def _heavier(package: ModalPackage, factor: float) -> ModalPackage:
    """Return a body of another density."""
    inv = package.invariants
    arrays = ("S0_B", "S_B", "T00_B", "T01_B", "T11_B", "J0_B", "J_psi_B")
    scaled = {name: factor * getattr(inv, name) for name in arrays}
    second = package.second_order
    if second is not None:
        tables = {name: factor * getattr(second, name) for name in SUMS}
        pieces = second.pieces and replace(second.pieces, mass=factor * second.pieces.mass)
        second = replace(second, **tables, pieces=pieces)
    return replace(
        package,
        mass=factor * package.mass,
        invariants=replace(inv, mass=factor * inv.mass, **scaled),
        second_order=second,
    )
