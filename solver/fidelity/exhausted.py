"""Vibrations that neither package has more of: where a check is blind.

If the model of a plan has all vibrations of a kind that the package of the check has, the check
adds none of this kind, and their difference does not show what both lack. What the highest one
contributes is then taken as the size of that.
"""

from collections.abc import Callable, Mapping

from ..math.arrays import Array
from .plan import Plan, kind_of
from .trial import Trial, distance


def exhausted(
    plan: Plan, check: Plan, ranked: Mapping[str, tuple[str, ...]]
) -> dict[str, tuple[str, ...]]:
    """Return, by body, the highest vibration of each kind of which the check adds none.

    Kinds that do not respond are left out; `ranked` has labels of those that do, by body. A kind
    that the plan has none of is no such kind either.
    """
    found = {}
    for name, body in plan.bodies.items():
        responding = {kind_of(label) for label in ranked[name]}
        added = set(check.bodies[name].vibrations) - set(body.vibrations)
        more = {kind_of(label) for label in added}
        highest = {
            kind_of(label): label
            for label in sorted(body.vibrations, key=_number)
            if kind_of(label) in responding - more
        }
        if highest:
            found[name] = tuple(highest[kind] for kind in sorted(highest, reverse=True))
    return found


def unseen(
    trial: Trial,
    check: Trial,
    ranked: Mapping[str, tuple[str, ...]],
    metric: str,
    run: Callable[[Plan], Trial | None],
) -> tuple[Array | None, str]:
    """Return what the highest vibrations contribute to the signals (o,), and their labels.

    None if the check has more of each kind.
    """
    plan = trial.plan
    highest = exhausted(plan, check.plan, ranked)
    if not highest:
        return None, ""
    for name, labels in highest.items():
        kept = tuple(label for label in plan.bodies[name].vibrations if label not in labels)
        plan = plan.with_body(name, vibrations=kept)
    other = run(plan)
    words = ", ".join(f"{name} {', '.join(labels)}" for name, labels in highest.items())
    return (distance(metric, other, trial) if other is not None else None), words


def _number(label: str) -> int:
    number = label.rpartition(" ")[2]
    return int(number) if number.isdigit() else 0
