"""Read processor time off curves of error against processor time."""

from collections.abc import Mapping, Sequence

import numpy as np

from plymotion.solver.math.arrays import front as on_front

Curve = Sequence[Sequence[float]]  # pairs of error [m] and processor time [s]


def front(curve: Curve) -> list[tuple[float, float]]:
    """Points that no other beats in both error and time, the coarsest first."""
    points = [(float(error), float(cpu)) for error, cpu in curve]
    return [points[i] for i in reversed(on_front(points))]


def cpu_at(curve: Curve, error: float) -> float:
    """Time [s] that a curve needs for an error [m], between its points on logarithmic axes.

    An error beyond the coarsest point costs what that point costs; one below the finest cannot
    be had: inf.
    """
    points = front(curve)
    if not points or error < points[-1][0]:
        return np.inf
    errors, times = np.log(np.array(points)).T
    # np.interp wants rising errors, and holds the ends
    return float(np.exp(np.interp(np.log(error), errors[::-1], times[::-1])))


def ratios(
    ours: Mapping[str, Curve], theirs: Curve, targets: Sequence[str]
) -> dict[str, float | None]:
    """Our best integrator's time over theirs at each error; None where one does not get there."""
    found: dict[str, float | None] = {}
    for target in targets:
        best = min((cpu_at(curve, float(target)) for curve in ours.values()), default=np.inf)
        ratio = best / cpu_at(theirs, float(target))
        found[target] = ratio if np.isfinite(ratio) and ratio > 0 else None
    return found
