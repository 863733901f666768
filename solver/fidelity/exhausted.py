"""Vibrations that neither package has more of: where a check is blind.

A check that has all vibrations of a kind that its package has does not show what the package
lacks. The package of the model has fewer of each kind, with static shapes of its own. The same
check in this package differs from the check by the vibrations m + 1 to n of a kind. If the
contributions decrease with a power p of the number of a vibration, those above n are

    (sum over j > n of j^-p) / (sum over m < j <= n of j^-p)

of this difference. Contributions to forces under loads that jump decrease with p = 2, those to
motions under smooth loads with p = 4 and more. The estimate takes p = 3, and 2.5 for joint forces.
"""

from collections.abc import Callable, Mapping

import numpy as np

from ..math.arrays import Array
from .model import Rich, vibration_labels
from .plan import Plan, kind_of
from .trial import Trial, distance

POWER, POWER_OF_REACTIONS = 3.0, 2.5


def power_of(kind: str) -> float:
    """Return the power by which contributions of vibrations to a kind of signal decrease."""
    return POWER_OF_REACTIONS if kind == "reaction" else POWER


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


def unseen(
    check: Trial,
    ranked: Mapping[str, tuple[str, ...]],
    packages: tuple[Mapping[str, Rich], Mapping[str, Rich]],
    metric: str,
    run: Callable[[Plan], Trial | None],
    powers: Array,
) -> tuple[Array | None, str]:
    """Return what vibrations above those of the packages contribute to the signals (o,), and where.

    None if the check does not have all vibrations of a kind.

    Parameters
    ----------
    packages : rich packages of the model and of the check, by body
    powers : (o,) of the number of a vibration, by which its contribution decreases
    """
    model, finer = ({n: vibration_labels(r.package) for n, r in p.items()} for p in packages)
    kinds = exhausted(check.plan, ranked, finer)
    poor, share = check.plan, np.zeros(len(powers))
    for name, these in kinds.items():
        if len(model[name]) < len(finer[name]):
            poor = poor.with_body(name, mesh="model")
            counts = [[_count(labels[name], kind) for labels in (model, finer)] for kind in these]
            for m, n in counts:
                share = np.maximum(share, [tail(m, n, p) for p in powers])
    if poor == check.plan:
        return None, ""
    words = ", ".join(f"{' and '.join(these)} of {name}" for name, these in kinds.items())
    other = run(poor)
    return (None if other is None else share * distance(metric, other, check)), words


def tail(m: int, n: int, power: float = POWER) -> float:
    """Return the contribution of vibrations above n, over that of m + 1 to n."""
    known = float((np.arange(m + 1, n + 1) ** -power).sum())
    return (n + 0.5) ** (1.0 - power) / (power - 1.0) / known if known else 0.0


def _count(labels: tuple[str, ...], kind: str) -> int:
    return sum(kind_of(label) == kind for label in labels)
