"""Runs of a plan, their differences by kind and body, and the horizon of pointwise promises."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from ...checks.finished import FinishedRun
from ...errors import InputError
from ...math.arrays import Array
from ...package import ModalPackage
from ...results import RunResult, Summary
from ...run.inputs import RunSpec
from ...run.outcome import collect
from ...run.preparation import Prepared, complete, prepare
from ...run.timing import work_s
from ...signals import Recording
from .comparison import difference, relatives, scales
from .plan import LEAST_RTOL, Plan, Rich, kind_of, planned, with_values


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
) -> Trial | None:
    """Run a plan; None if its model cannot be assembled.

    `quiet` (o,) are the signals that are rounding by the indicators.
    """
    begin = work_s()
    try:
        own = planned(spec, plan, model, check)
        prepared = prepare(own.mechanism, own.packages)
        finished = complete(prepared)
    except InputError:
        return None
    solution = finished.solution
    recording = Recording(finished.model, solution.t, solution.y)
    compared = relatives(names, own.mechanism, prepared.built, solution.y[0])
    measured = {n: s.values(recording) for n, s in compared.sensors(prepared.built).items()}
    signals, sizes = compared.judged(measured, plan.rtol, quiet)
    cpu = work_s() - begin
    whole = solution.status == "finished"
    return Trial(plan, own, prepared, finished, signals, sizes, whole, cpu)


def distance(metric: str, one: Trial, two: Trial) -> Array:
    """Return the difference (o,) of the signals of two runs, of the largest value of the second.

    Infinite if one of them ended early.
    """
    if not (one.complete and two.complete):
        return np.full(len(two.signals), np.inf)
    return difference(metric, one.signals, two.signals) / two.scales(metric)


TIGHTER = 30.0  # tolerance of a plan over that of its promotion
HIGHEST, TOLERANCE = "highest vibrations", "tolerance"
RESERVED = (HIGHEST, TOLERANCE)  # promotions after which a plan needs another check
PROMOTED = 0.3  # of the largest share, from which a kind is promoted


@dataclass(frozen=True)
class Share:
    """What one promotion changes: kind, body ("" of all), largest change of a signal."""

    kind: str
    body: str
    value: float


def promotions(
    plan: Plan, check: Plan, ranked: Mapping[str, tuple[str, ...]]
) -> Iterator[tuple[str, str, Plan]]:
    """Yield kind, body and plan of each single promotion towards a check.

    Of the vibrations of the check only kinds that respond (`ranked`, by body) are promoted. The
    package of the check has more of a kind than that of the model. The highest of each kind stay
    with the check as long as others are left: it then is a check of the promoted plan, too.
    """
    for kind, name, changes in _promotions(plan, check, ranked):
        yield kind, name, plan.with_body(name, **changes)


def _promotions(
    plan: Plan, check: Plan, ranked: Mapping[str, tuple[str, ...]]
) -> Iterator[tuple[str, str, dict[str, object]]]:
    """Yield kind, body and changes of each single promotion."""
    for name, body in plan.bodies.items():
        more = check.bodies[name]
        kinds = {kind_of(label) for label in ranked[name]}
        left = (label for label in more.vibrations if label not in body.vibrations)
        if added := [label for label in left if kind_of(label) in kinds]:
            highest = {kind_of(label): label for label in added}.values()
            some = [label for label in added if label not in highest]
            kept = tuple(dict.fromkeys((*body.vibrations, *(some or added))))
            mesh = "check" if set(some or added) - set(ranked[name]) else body.mesh
            kind = "vibrations" if some else HIGHEST
            yield kind, name, {"vibrations": kept, "mesh": mesh}
        if more.static > body.static:
            static = max(2 * body.static, body.static + 2)
            yield "statics", name, {"static": min(static, more.static)}
        if body.static and not body.ringing:
            yield "ringing", name, {"ringing": True}
        if body.mesh == "model" and not body.rigid:
            yield "mesh", name, {"mesh": "check"}
    if check.stiffening and not plan.stiffening:
        yield "stiffening", "", {"stiffening": True}
    if plan.rtol > LEAST_RTOL:
        yield TOLERANCE, "", {"rtol": max(LEAST_RTOL, plan.rtol / TIGHTER)}


def promoted(
    plan: Plan,
    check: Plan,
    ranked: Mapping[str, tuple[str, ...]],
    shares: list[Share],
    estimate: float,
    accuracy: float,
) -> Plan:
    """Return the plan with the promotions of large shares; with all, if none explains the check.

    A share above the accuracy is large whatever the others are: another round would have to
    promote it. The highest vibrations of a check and the tolerance are promoted for their own
    shares, or if nothing else is left, because the plan then needs another check.
    """
    largest = max((share.value for share in shares), default=0.0)
    every = not shares or estimate > 2.0 * largest
    least = min(PROMOTED * largest, accuracy)
    value = {(share.kind, share.body): share.value for share in shares}
    single, more = [*_promotions(plan, check, ranked)], plan
    for kind, body, changes in single:
        own, reserved = value.get((kind, body), 0.0), kind in RESERVED
        if own >= least > 0.0 or (every and (not reserved or own >= PROMOTED * accuracy)):
            more = more.with_body(body, **changes)
    for reserved_kind in RESERVED if every else ():
        for kind, body, changes in single if more == plan else ():
            if kind == reserved_kind:
                more = more.with_body(body, **changes)
    return more


CHANGE = 1e-6  # of the masses of the bodies, relative; another one for each body


def horizon(trial: Trial, names: list[str], accuracy: float) -> float | None:
    """Return the time [s] from which a signal of the changed run differs by `accuracy`.

    None if that is never, or if the changed run ends early.
    """
    spec = changed(trial.spec)
    try:
        prepared = prepare(spec.mechanism, spec.packages)
    except InputError:
        return None
    finished = complete(prepared)
    solution = finished.solution
    if solution.status != "finished" or not trial.complete:
        return None
    recording = Recording(finished.model, solution.t, solution.y)
    signals = np.array([prepared.measured[name].values(recording) for name in names])
    sizes = trial.scales("pointwise")
    far = np.flatnonzero((np.abs(signals - trial.signals) / sizes[:, None]).max(axis=0) > accuracy)
    return float(solution.t[far[0]]) if far.size else None


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
        tables = {name: factor * getattr(second, name) for name in ("Z0_B", "Z1_B", "G3", "G4")}
        pieces = None if second.point_mass is None else factor * second.point_mass
        second = replace(second, **tables, point_mass=pieces)
    return replace(
        package,
        mass=factor * package.mass,
        invariants=replace(inv, mass=factor * inv.mass, **scaled),
        second_order=second,
    )
