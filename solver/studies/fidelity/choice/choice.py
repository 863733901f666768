"""Choice of a plan from the indicators: cheapest additions first, until the losses are small."""

from collections.abc import Iterator, Mapping

import numpy as np

from ....math.arrays import Array
from ..base.model import Rich
from ..base.model import rows as rows_of
from ..base.plan import LEAST_RTOL, MOST_RTOL, BodyPlan, Plan
from ..indicators.indicators import Indicators

SHARE = 0.5  # of the accuracy, for all modes that are left out
STIFFENING_SHARE = 0.25  # of the accuracy: loss from which stiffening is on
STIFFENING_SPIN = 0.5  # of the first clamped frequency: spin from which it is on
SHAPE_SHARE = 0.1  # of the accuracy, for static shapes that are left out
COST = {"vibration": 1.0, "static": 1.5, "ringing": 6.0}  # of an addition, relative
# Damped static shapes damp the vibrations that joints couple them with: a frequency changes by
# little, but the phase by more with every period. The indicators take modes one by one.
DAMPED_ABOVE = 3e-4
MOTIONS = ("position", "velocity", "angular_velocity", "orientation", "joint")
MOTION_RTOL, OTHER_RTOL = 3.0, 30.0  # accuracy over tolerance, by the kind of signal


def chosen(
    indicators: Indicators,
    rich: Mapping[str, Rich],
    accuracy: float,
    kinds: Mapping[str, str],
    least: Mapping[str, BodyPlan],
) -> tuple[Plan, Array]:
    """Return a plan whose losses are below SHARE of the accuracy, and its losses (o,).

    Parameters
    ----------
    kinds : of the signals
    least : what each body has at least
    """
    spin = max(indicators.spin.values(), default=0.0)
    stiffening = bool(
        (indicators.stiffening > STIFFENING_SHARE * accuracy).any() or spin > STIFFENING_SPIN
    )
    by = max(accuracy_over_rtol(indicators, kinds))
    rtol = min(max(accuracy / by, LEAST_RTOL), MOST_RTOL)
    plan = Plan(dict(least), stiffening, rtol)
    omitted = _omitted(indicators, plan)
    loss = indicators.loss(omitted.sum(axis=2))
    while loss.max(initial=0.0) > SHARE * accuracy:
        additions = list(_additions(indicators, plan, omitted))
        if not additions:
            break
        lost = omitted.sum(axis=2) - np.array([gained for _, _, gained in additions])
        after = indicators.loss(lost)  # (additions, o)
        gain = np.maximum(loss, SHARE * accuracy).sum()
        gain = gain - np.maximum(after, SHARE * accuracy).sum(axis=1)
        best = int(np.argmax(gain / np.array([COST[kind] for kind, _, _ in additions])))
        plan, loss = additions[best][1], after[best]
        omitted = _omitted(indicators, plan)
    tight = any(kinds[name] not in MOTIONS for name in indicators.names)
    for name, body in plan.bodies.items():
        if body.static:
            count = _shapes(indicators, plan, name, rich[name], SHAPE_SHARE * accuracy)
            ringing = body.ringing or (tight and accuracy < DAMPED_ABOVE)
            plan = plan.with_body(name, static=max(count, least[name].static), ringing=ringing)
    return plan, loss


def accuracy_over_rtol(indicators: Indicators, kinds: Mapping[str, str]) -> tuple[float, float]:
    """Return the accuracy over the tolerance of a plan: by the kinds of the signals, and by the
    size of the deflections that they follow from."""
    by = MOTION_RTOL if all(kinds[n] in MOTIONS for n in indicators.names) else OTHER_RTOL
    return by, MOTION_RTOL * float(indicators.amplified.max(initial=0.0))


def _additions(
    indicators: Indicators, plan: Plan, omitted: Array
) -> Iterator[tuple[str, Plan, Array]]:
    """Return kind, plan and regained contributions (o, k) of each addition to a plan."""
    parts = indicators.effects
    for j, mode in enumerate(indicators.modes):
        body = plan.bodies[mode.body]
        if mode.vibration and mode.label not in body.vibrations:
            more = plan.with_body(mode.body, vibrations=(*body.vibrations, mode.label))
            yield "vibration", more, omitted[:, :, j]
    for name, body in plan.bodies.items():
        left = [
            j
            for j, mode in enumerate(indicators.modes)
            if mode.body == name and mode.label not in body.vibrations
        ]
        if not body.static:
            more = plan.with_body(name, static=1)
            yield "static", more, parts.static[:, :, left].sum(axis=2)
        elif not body.ringing:
            more = plan.with_body(name, ringing=True)
            yield "ringing", more, omitted[:, :, left].sum(axis=2)


def _omitted(indicators: Indicators, plan: Plan) -> Array:
    """Return the contributions of the modes (o, k, m) that a plan leaves out."""
    parts = indicators.effects
    kept, static = np.zeros((2, len(indicators.modes)), dtype=bool)
    for j, mode in enumerate(indicators.modes):
        body = plan.bodies[mode.body]
        of_plan = mode.vibration and mode.label in body.vibrations
        kept[j], static[j] = of_plan or (body.static and body.ringing), body.static > 0
    return np.where(kept, 0.0, parts.response - np.where(static, parts.static, 0.0))


def _shapes(indicators: Indicators, plan: Plan, name: str, rich: Rich, allowed: float) -> int:
    """Return how many static shapes of a body keep the quasi-static response to `allowed`."""
    kept = rows_of(rich.package, plan.bodies[name].vibrations)
    shapes = rich.rest(kept, stiffening=plan.stiffening)
    worth = rich.energies(shapes)
    eta, K = rich.eta, rich.package.stiffness
    mine = [j for j, mode in enumerate(indicators.modes) if mode.body == name]
    labels = {label: i for i, label in _static_rows(rich)}
    own = [labels[indicators.modes[j].label] for j in mine]
    usable = int(np.sum(worth > 1e-6 * max(float(worth.max(initial=0.0)), 1e-300)))
    unit = shapes[:, :usable] / worth[:usable]
    along = eta @ K @ unit  # (k, r) coordinates of the response in the shapes
    static = indicators.effects.static[:, :, mine]
    with np.errstate(divide="ignore", invalid="ignore"):
        slope = np.where(eta[None, :, own] != 0.0, static / eta[None, :, own], 0.0)
    for count in range(1, usable + 1):
        left = along[:, count:] @ unit[own, count:].T  # (k, m)
        lost = np.einsum("okm,km->ok", slope, left)
        if float(indicators.loss(lost).max(initial=0.0)) <= allowed:
            return count
    return usable


def _static_rows(rich: Rich) -> list[tuple[int, str]]:
    return list(enumerate(rich.package.mode_labels))
