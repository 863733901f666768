"""Pareto front of points in two measures, such as error and time."""

from collections.abc import Sequence


def front(points: Sequence[tuple[float, float]]) -> list[int]:
    """Return the indices of the points of the Pareto front, sorted by the first number.

    Parameters
    ----------
    points : pairs of which less is better, as CPU time [s] and error
    """
    found: list[int] = []
    for i in sorted(range(len(points)), key=points.__getitem__):
        if not found or points[i][1] < points[found[-1]][1]:
            found.append(i)
    return found
