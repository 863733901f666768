"""The difference of a check, split by kind and body: what is promoted if it is too large."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..base.plan import LEAST_RTOL, Plan, kind_of
from .trial import Trial, distance

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

    def entry(self) -> dict[str, object]:
        """Return plain data."""
        return {"kind": self.kind, "body": self.body, "value": self.value}


def promotions(
    plan: Plan, check: Plan, ranked: Mapping[str, tuple[str, ...]]
) -> Iterator[tuple[str, str, Plan]]:
    """Return kind, body and plan of each single promotion towards a check.

    Of the vibrations of the check only kinds that respond (`ranked`, by body) are promoted. The
    package of the check has more of a kind than that of the model. The highest of each kind stay
    with the check as long as others are left: it then is a check of the promoted plan, too.
    """
    for name, body in plan.bodies.items():
        more = check.bodies[name]
        kinds = {kind_of(label) for label in ranked[name]}
        added = [
            label
            for label in more.vibrations
            if kind_of(label) in kinds and label not in body.vibrations
        ]
        highest = {kind_of(label): label for label in added}.values()
        if added:
            some = [label for label in added if label not in highest]
            kept = tuple(dict.fromkeys((*body.vibrations, *(some or added))))
            mesh = "check" if set(some or added) - set(ranked[name]) else body.mesh
            kind = "vibrations" if some else HIGHEST
            yield kind, name, plan.with_body(name, vibrations=kept, mesh=mesh)
        if more.static > body.static:
            static = max(2 * body.static, body.static + 2)
            yield "statics", name, plan.with_body(name, static=min(static, more.static))
        if body.static and not body.ringing:
            yield "ringing", name, plan.with_body(name, ringing=True)
        if body.mesh == "model" and not body.rigid:
            yield "mesh", name, plan.with_body(name, mesh="check")
    if check.stiffening and not plan.stiffening:
        yield "stiffening", "", replace(plan, stiffening=True)
    if plan.rtol > LEAST_RTOL:
        yield TOLERANCE, "", replace(plan, rtol=max(LEAST_RTOL, plan.rtol / TIGHTER))


def split(
    trial: Trial,
    check: Trial,
    ranked: Mapping[str, tuple[str, ...]],
    metric: str,
    run: Callable[[Plan], Trial | None],
) -> list[Share]:
    """Return the share of each promotion, largest first; `run` tries a plan."""
    found = []
    for kind, body, plan in promotions(trial.plan, check.plan, ranked):
        other = run(plan)
        if other is None:
            continue
        value = distance(metric, trial, other)
        largest = float(value.max(initial=0.0))
        found.append(Share(kind, body, largest if np.isfinite(largest) else 1e300))
    return sorted(found, key=lambda share: -share.value)


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
    single = [*promotions(plan, check, ranked)]

    def with_those(found: Plan, wanted: Callable[[str, float], bool]) -> Plan:
        for kind, body, one in single:
            if wanted(kind, value.get((kind, body), 0.0)):
                found = _joined(found, one, kind, body)
        return found

    more = with_those(plan, lambda kind, v: v >= least > 0.0 or (every and kind not in RESERVED))
    if every:
        more = with_those(more, lambda kind, v: kind in RESERVED and v >= PROMOTED * accuracy)
    for reserved in RESERVED if every else ():
        if more == plan:
            more = with_those(more, lambda kind, _: kind == reserved)  # noqa: B023
    return more


def _joined(plan: Plan, single: Plan, kind: str, body: str) -> Plan:
    if kind == "stiffening":
        return replace(plan, stiffening=True)
    if kind == TOLERANCE:
        return replace(plan, rtol=single.rtol)
    new = single.bodies[body]
    fields: dict[str, dict[str, Any]] = {
        "vibrations": {"vibrations": new.vibrations, "mesh": new.mesh},
        HIGHEST: {"vibrations": new.vibrations, "mesh": new.mesh},
        "statics": {"static": new.static},
        "ringing": {"ringing": True},
        "mesh": {"mesh": "check"},
    }
    return plan.with_body(body, **fields[kind])
