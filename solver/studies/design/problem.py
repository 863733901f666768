"""One problem for all optimisers: minimise fun(x) with bounds and cons(x) >= 0.

x are the free parameters, each scaled to -1 to 1. If the objective is a largest value, over time or
plies, x has one more entry: a bound of all its local peaks, which is minimised.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from ...errors import InputError
from ...inputs.case.tables.design_keys import Limit, Study
from ...math.arrays import Array
from .rules import Space

BARRIER = 10.0  # by which an invalid design is worse than the last valid one, scaled
FEASIBLE = 1e-4  # largest violation of limits, relative, of a design that counts as one


@dataclass(frozen=True)
class Values:
    """What was computed of a design: values of every measure, or why there are none."""

    why: str  # of a design that is invalid
    values: list[list[float]]  # by measure
    shown: list[float]
    units: list[str]


class Valued(Protocol):
    """What a problem knows of a measure (measures.py)."""

    @property
    def peaks(self) -> int:
        """1: the values are local maxima, of which the largest counts; -1: minima; 0: one value."""


class Designs(Protocol):
    """Gives values and slopes of designs: trials with their memory."""

    def values(self, p: Array) -> Values:
        """Return values of a design (p,), or why it is invalid."""

    def slopes(self, p: Array) -> list[list[list[float]]]:
        """Return derivatives of values of a valid design, by measure, value and parameter."""


@dataclass
class Point:
    """A design that was computed, and how good it is."""

    p: list[float]
    merit: float  # objective, negative where it is made large; of strength the exposure
    violation: float  # largest one of all limits, relative; 0: none
    shown: list[float]  # what a user reads of each measure
    second: float = 0.0  # merit of what `front` names

    def better_than(self, other: "Point | None") -> bool:
        """Tell whether it is nearer to feasible, or as feasible and of a better objective."""
        if other is None:
            return True
        mine, theirs = (max(each.violation - FEASIBLE, 0.0) for each in (self, other))
        return (mine, self.merit) < (theirs, other.merit)


def undominated(points: Iterable[Point]) -> list[Point]:
    """Return the points within all limits of which none is better in both merits, in order."""
    best: list[Point] = []
    valid = (point for point in points if point.violation <= FEASIBLE)
    for point in sorted(valid, key=lambda each: (each.merit, each.second)):
        if not best or point.second < best[-1].second:
            best.append(point)
    return best


@dataclass
class Problem:
    """The problem of one start.

    Attributes
    ----------
    x0 : (n,) where it begins; bounds (n, 2)
    best : the best valid design so far
    history : a point for each gradient that was asked for: the iterations
    invalid : designs that had no value, and the first reason
    front : the valid designs of which none is better in both numbers of a study with `front`
    restoring : the largest violation of the limits is made small in place of the objective
    """

    designs: Designs
    study: Study
    measures: Sequence[Valued]
    space: Space
    z0: Array
    best: Point | None = None
    history: list[Point] = field(default_factory=list)
    invalid: list[str] = field(default_factory=list)
    front: list[Point] = field(default_factory=list)
    restoring: bool = False

    def __post_init__(self) -> None:
        self._good: tuple[Array, Array, Array | None] | None = None
        first = self.designs.values(self.space.p(self.z0))
        if first.why:
            raise InputError(f"the design of the start is invalid: {first.why}")
        self._mid = 0.5 * (self.space.lower + self.space.upper)
        self._half = 0.5 * (self.space.upper - self.space.lower)
        self.sign = 1.0 if self.study.minimise is not None else -1.0
        if self.study.objective.subject == "strength":
            self.sign = 1.0  # of exposures, which are the values
        self.bounded = self.restoring or self.measures[0].peaks != 0
        sizes = [float(np.abs(v).max()) for v in first.values]
        self._scale = sizes[0] or 1.0
        self._sizes = [s or 1.0 for s in sizes]
        self._peaks = len(first.values[0]) if self.bounded and not self.restoring else 0
        self.x0 = self.x_of(self.space.p(self.z0))
        self.bounds = np.repeat([[-1.0, 1.0]], self.z0.size, axis=0)
        if self.bounded:
            self.bounds = np.r_[self.bounds, [[-FEASIBLE if self.restoring else -1e6, 1e6]]]

    def again(self, z0: Array, space: Space, *, restoring: bool = False) -> "Problem":
        """Return the problem with another start.

        Parameters
        ----------
        z0 : (z,) free parameters of the start
        space : the free parameters, which may be fewer than before
        restoring : make the violation of the limits small in place of the objective
        """
        return Problem(self.designs, self.study, self.measures, space, z0, restoring=restoring)

    @property
    def peaks(self) -> int:
        """Number of the first entries of `cons` that bound the objective."""
        return self._peaks

    def x_of(self, p: Array) -> Array:
        """Return the x of a design (p,); the bound of its peaks is the largest of them."""
        u = (self.space.z(p) - self._mid) / self._half
        if not self.bounded:
            return u
        values = self.designs.values(p).values
        if self.restoring:
            return np.r_[u, self.violation(p, values)]
        return np.r_[u, (self.sign * np.array(values[0]) / self._scale).max()]

    def z(self, x: Array) -> Array:
        """Return the free parameters of x, in their units."""
        u = np.clip(x[: self.z0.size], -1.0, 1.0)
        return np.asarray(self._mid + self._half * u)

    def fun(self, x: Array) -> float:
        """Return the objective, scaled."""
        f, _ = self._values(x)
        return float(x[-1]) if self.bounded else f

    def jac(self, x: Array) -> Array:
        """Return its gradient (n,)."""
        if self.bounded:
            return np.eye(x.size)[-1]
        return self._slopes(x)[0]

    def second(self, x: Array) -> float:
        """Return the merit of what `front` names; of an invalid design one that is worse."""
        p, assumed = self.space.p(self.z(x)), self.best
        values = self.designs.values(p)
        if values.why and assumed is not None:
            return assumed.second + BARRIER * (abs(assumed.second) or 1.0)
        return self.point(p, values).second

    def cons(self, x: Array) -> Array:
        """Return what must not be negative (m,)."""
        return self._values(x)[1]

    def cons_jac(self, x: Array) -> Array:
        """Return its derivative (m, n)."""
        return self._slopes(x)[1:]

    def _values(self, x: Array) -> tuple[float, Array]:
        p = self.space.p(self.z(x))
        result = self.designs.values(p)
        if result.why:
            if result.why not in self.invalid:
                self.invalid.append(result.why)
            assert self._good is not None
            good = self._good[1]  # the line search comes back
            return float(good[0] + BARRIER), good[1:] - BARRIER
        values = self._rows(x, [np.array(v) for v in result.values], None)
        self._good = x.copy(), values, self._good[2] if self._good is not None else None
        self._note(p, result)
        return float(values[0]), values[1:]

    def _slopes(self, x: Array) -> Array:
        """Return the gradient of the objective, then those of the constraints (1 + m, n)."""
        p = self.space.p(self.z(x))
        values = self.designs.values(p)
        if values.why:
            assert self._good is not None
            if self._good[2] is None:
                return self._slopes(self._good[0])
            return self._good[2]
        by_z = [np.array(s) @ self.space.T for s in self.designs.slopes(p)]
        rows = self._rows(x, [np.array(v) for v in values.values], by_z)
        rows[:, : self.z0.size] *= self._half
        if self._good is None or not np.array_equal(self._good[0], x):
            self._values(x)
        assert self._good is not None
        self._good = x.copy(), self._good[1], rows
        point = self.point(p, values)
        if not self.history or self.history[-1].p != point.p:
            self.history.append(point)
        return rows

    def _rows(self, x: Array, values: list[Array], slopes: list[Array] | None) -> Array:
        """Return objective and constraints (1 + m,), or their derivatives (1 + m, n) by z.

        The rows are linear in values; `slopes` None asks for values.
        """
        n = x.size
        rows: list[Array] = []

        def add(k: int, offset: float, factor: float, *, of_bound: float = 0.0) -> None:
            if slopes is None:
                rows.extend(offset + factor * values[k] + (of_bound * x[-1] if of_bound else 0.0))
                return
            table = np.zeros((values[k].size, n))
            table[:, : self.z0.size] = factor * slopes[k]
            table[:, -1] += of_bound
            rows.extend(table)

        if self.bounded:
            rows.append(np.asarray(x[-1]) if slopes is None else np.eye(n)[-1])
            if not self.restoring:
                add(0, 0.0, -self.sign / self._scale, of_bound=1.0)
        else:
            add(0, 0.0, self.sign / self._scale)
        for k, limit in enumerate(self.study.subject_to, 1):
            for offset, factor in self._limits(k, limit):
                add(k, offset, factor, of_bound=float(self.restoring))
        for row, b in zip(self.space.A, self.space.b, strict=True):
            size = float(np.abs(row * self._half).max())
            if slopes is None:
                rows.append(np.asarray((b - row @ self.z(x)) / size))
            else:
                rows.append(np.r_[-row / size, np.zeros(n - row.size)])
        return np.array(rows)

    def _limits(self, k: int, limit: Limit) -> list[tuple[float, float]]:
        """Return offsets and factors: offset + factor value >= 0."""
        if limit.subject == "strength":
            return [] if limit.least is None else [(1.0, -limit.least)]
        bounds = []
        for value, sign in ((limit.least, 1.0), (limit.most, -1.0)):
            if value is not None:
                size = abs(value) or self._sizes[k]
                bounds.append((-sign * value / size, sign / size))
        return bounds

    def violation(self, p: Array, values: list[list[float]]) -> float:
        """Return the largest violation of all limits by a design, relative."""
        x = np.r_[(self.space.z(p) - self._mid) / self._half, [0.0] * self.bounded]
        rows = self._rows(x, [np.array(v) for v in values], None)[1:]
        rows = rows[len(values[0]) if self._peaks else 0 :]
        return float(max(0.0, -rows.min())) if rows.size else 0.0

    def point(self, p: Array, values: Values) -> Point:
        """Return how good a design is."""
        merit = float((self.sign * np.array(values.values[0])).max())
        other, second = self.study.front, 0.0
        if other is not None:
            large = other.subject == "frequency" or other.of == "min"
            second = float(((-1.0 if large else 1.0) * np.array(values.values[-1])).max())
        return Point(p.tolist(), merit, self.violation(p, values.values), values.shown, second)

    def _note(self, p: Array, values: Values) -> None:
        point = self.point(p, values)
        if point.better_than(self.best):
            self.best = point
        if self.study.front is not None:
            self.front = undominated([*self.front, point])


@dataclass(frozen=True)
class Options:
    """What a driver is asked for."""

    iterations: int
    tolerance: float
    seed: int
