"""Lowest vibration modes of an imported body, counted so that none is missing."""

from collections.abc import Callable

import numpy as np

from ...solver.errors import InputError
from ...solver.math.arrays import Array
from ..modes import (
    KINDS,
    Condition,
    Eigenmodes,
    Participation,
    clusters,
    separating_rotation,
    shares_of,
)
from .direct import Solver

SPARE = 4
SEVENTH = 1e-14  # value of a mode without stiffness, relative to the largest K_ii / M_ii
ROUNDS = 4  # attempts to find all modes below the highest


def vibrations(
    condition: Condition,
    count: int,
    direct: Solver,
    participation: Participation,
    name_of: Callable[[int], str],
    where: str,
) -> Eigenmodes:
    """The `count` lowest modes: shift-invert Lanczos, and a Sturm count.

    Raises InputError for a motion without stiffness besides the six rigid ones, named with
    `name_of` its largest dof, and for modes that the count does not confirm.
    """
    n_dof = condition.K.shape[0]
    if count == 0:
        return Eigenmodes(np.zeros(0), np.zeros((n_dof, 0)), (), np.zeros((0, len(KINDS))))
    if count + SPARE >= condition.n_finite - 1:
        raise InputError(
            f"{where}: modes: {count} vibrations of a body with {condition.n_finite} massive "
            f"degrees of freedom; expected at most {condition.n_finite - SPARE - 2}"
        )
    spare = SPARE
    for _ in range(ROUNDS):
        values, X = condition.lowest(count + spare, direct.eigenpairs)
        _check_stiffness(condition, values, X, name_of, where)
        # The shift of the count lies between two groups of equal values, at least `count` of them.
        ends = [end for _, end in clusters(values)[:-1] if end >= count]
        if ends:
            middle = 0.5 * float(values[ends[0] - 1] + values[ends[0]])
            if _count_below(condition, middle) == ends[0]:
                break
        spare *= 2
    else:
        raise InputError(
            f"{where}: modes: the Sturm count does not confirm the {count} lowest modes; expected "
            "matrices without nearly rigid parts"
        )
    values, X = values[: ends[0]], X[:, : ends[0]]
    X = X @ separating_rotation(values, participation(X))
    values, X = values[:count], X[:, :count]
    X = X * _signs(X)
    labels = tuple(f"vibration {i + 1}" for i in range(count))
    return Eigenmodes(values, X, labels, shares_of(participation(X)))


def _count_below(condition: Condition, value: float) -> int:
    """Sturm count; -1 where a front is singular, by chance of the value."""
    try:
        return condition.count_below(value)
    except ArithmeticError:
        return -1


def _check_stiffness(
    condition: Condition, values: Array, X: Array, name_of: Callable[[int], str], where: str
) -> None:
    """Raise InputError for a mode whose value is round-off: a seventh rigid motion."""
    stiffness, mass = condition.K.diagonal(), condition.M.diagonal()
    largest = float((stiffness[mass > 0.0] / mass[mass > 0.0]).max())
    free = np.flatnonzero(values <= SEVENTH * largest)
    if len(free):
        named = "; ".join(name_of(int(np.argmax(np.abs(X[:, i])))) for i in free[:3])
        raise InputError(
            f"{where}: expected six motions without stiffness, found {6 + len(free)}: largest at "
            f"{named}: a mechanism, a hinge, or a degree of freedom without stiffness"
        )


def _signs(X: Array) -> Array:
    """+1 or -1 per column: the first of its nearly largest entries is positive."""
    largest = np.abs(X).max(axis=0)
    first = np.argmax(np.abs(X) >= 0.999 * largest, axis=0)
    return np.where(X[first, np.arange(X.shape[1])] < 0.0, -1.0, 1.0)
