"""Campbell diagram: modes followed over speed, and their crossings with harmonics of the speed.

Modes at neighbouring speeds are matched by left vectors of one and right vectors of the other.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...math.arrays import Array, IntArray
from ..tolerances import ALIKE_OVERLAP, CROSSING_FOUND, LEAST_OVERLAP, OVERDAMPED
from .modes import Modes
from .state_space import StateSpace

if TYPE_CHECKING:
    from scipy.interpolate import PchipInterpolator


class Vectors(NamedTuple):
    """Modes in coordinates that all speeds share."""

    right: Array  # (2 n_vel + n_a, k) displacements, changes of velocity, other states
    left: Array  # (2 n_vel + n_a, k), with left^H right = 1 for each mode


class Match(NamedTuple):
    """Successors of the modes of one speed at another."""

    successor: IntArray  # (k,) number of the mode; -1: none
    overlap: Array  # (k,) 1: the same shape


def vectors_of(space: StateSpace, modes: Modes) -> Vectors:
    """Return right and left vectors in the coordinates of displacements and velocities."""
    n = space.n_free
    x, u = space.displacements(modes.right), space.velocities(modes.right)
    left, more = space.free.Z_left.T, slice(2 * n, None)
    return Vectors(
        np.vstack([x, u, modes.right[more]]),
        np.vstack([left @ modes.left[:n], left @ modes.left[n : 2 * n], modes.left[more]]),
    )


def match(one: Vectors, two: Vectors) -> Match:
    """Return the assignment of modes with the largest sum of overlaps.

    The overlap of mode i with mode j is sqrt(|l_i^H r_j| |l_j^H r_i|), of r_j or its conjugate:
    in axes that turn, a whirl may go on in the other direction.
    """
    k = one.right.shape[1]
    successor, overlap = np.full(k, -1, dtype=np.int64), np.zeros(k)
    if k == 0 or two.right.shape[1] == 0:
        return Match(successor, overlap)
    overlaps = np.zeros((k, two.right.shape[1]))
    for right, left in (two, (two.right.conj(), two.left.conj())):
        forward = np.abs(one.left.conj().T @ right)
        backward = np.abs(left.conj().T @ one.right).T
        overlaps = np.maximum(overlaps, np.nan_to_num(np.sqrt(forward * backward), posinf=0.0))
    overlaps = np.minimum(overlaps, 1.0)
    from scipy.optimize import linear_sum_assignment  # 0.1 s, which a single state does without

    rows, columns = linear_sum_assignment(-overlaps)
    alike = overlaps[rows, columns] >= LEAST_OVERLAP
    rows, columns = rows[alike], columns[alike]
    successor[rows], overlap[rows] = columns, overlaps[rows, columns]
    return Match(successor, overlap)


_HALVINGS = 6
_SECANTS = 5  # solutions for the speed of a crossing


class Point(NamedTuple):
    """Modes at one speed; numbers are those that are followed."""

    speed: float  # [rad/s]
    modes: Modes
    vectors: Vectors
    fixed: Array  # (k,) angular frequencies seen from axes at rest; nan: no whirl
    damping: Array  # (k,) ratios; of whirls in axes at rest
    main: list[str]  # (k,) names of main coordinates


class Crossing(NamedTuple):
    """A mode whose frequency is a multiple of the speed."""

    branch: int
    harmonic: int
    speed: float  # [rad/s]
    frequency: float  # [rad/s]


@dataclass(frozen=True)
class Campbell:
    """Branches of modes over speed; nan where a branch has no mode."""

    speeds: Array  # (s,) [rad/s]
    frequencies: Array  # (s, b) seen from axes that turn [rad/s]
    fixed: Array  # (s, b) seen from axes at rest [rad/s]
    damping: Array  # (s, b)
    growth: Array  # (s, b) [1/s] of modes that grow, else 0
    overlaps: Array  # (s - 1, b) with the speed before
    names: list[str]  # (b,) main coordinates where the branch begins
    modes: IntArray  # (s, b) number of the mode, -1: none
    points: tuple[Point, ...]

    def followed(self, fixed: bool) -> Array:
        """Return the frequencies (s, b) of the diagram: from axes at rest, or those that turn."""
        return np.abs(self.fixed) if fixed else self.frequencies


def follow(at: Callable[[float, Point | None], Point], speeds: Array, most: int) -> Campbell:
    """Return the branches of the lowest modes over speed.

    Parameters
    ----------
    at : returns the modes at a speed, given those of a speed nearby
    speeds : (s,) rising; the step between two is halved where shapes change too much
    most : how many modes are followed
    """
    points, matches = [at(float(speeds[0]), None)], list[Match]()

    def advance(low: float, high: float, halvings: int) -> None:
        before, point = points[-1], at(high, points[-1])
        matched = match(before.vectors, point.vectors)
        # The least overlap of the lowest modes that oscillate.
        moving = [k for k in _lowest(before, most) if before.modes.frequencies[k] > 0.0]
        if halvings and matched.overlap[moving].min(initial=1.0) < ALIKE_OVERLAP:
            middle = 0.5 * (low + high)
            advance(low, middle, halvings - 1)
            advance(middle, high, halvings - 1)
            return
        points.append(point)
        matches.append(matched)

    for low, high in pairwise(speeds.tolist()):
        advance(low, high, _HALVINGS)
    return _branches(points, matches, most)


def _lowest(point: Point, most: int) -> list[int]:
    """Return the numbers of the lowest modes without those that stand still.

    Those that hardly oscillate, such as the ends of a shaft in strong dampers, come last.
    """
    moving = [k for k in range(point.modes.eigenvalues.size) if not point.modes.still[k]]
    return sorted(moving, key=lambda k: float(point.damping[k]) > OVERDAMPED)[:most]


def _branches(points: Sequence[Point], matches: Sequence[Match], most: int) -> Campbell:
    columns = [[k] for k in _lowest(points[0], most)]  # by branch: its mode at each speed
    overlaps: list[list[float]] = [[] for _ in columns]
    for s, (point, match) in enumerate(zip(points[1:], matches, strict=True), 1):
        for column, alike in zip(columns, overlaps, strict=True):
            k = column[-1]
            j = int(match.successor[k]) if k >= 0 else -1
            gone = j < 0 or bool(point.modes.still[j])
            column.append(-1 if gone else j)
            alike.append(np.nan if gone else float(match.overlap[k]))
        taken = {column[-1] for column in columns}
        alive = sum(column[-1] >= 0 for column in columns)
        new = [j for j in _lowest(point, most) if j not in taken]
        for j in new[: max(most - alive, 0)]:
            columns.append([-1] * s + [j])
            overlaps.append([np.nan] * s)
    modes = np.array(columns, dtype=np.int64).reshape(-1, len(points)).T
    values = [
        np.where(
            n >= 0,
            np.array([p.modes.frequencies, p.fixed, p.damping, p.modes.growth])[:, n],
            np.nan,
        )
        for p, n in zip(points, modes, strict=True)
    ]
    frequencies, fixed, damping, growth = np.swapaxes(values, 0, 1)
    names = []
    for numbers in columns:
        s = next(s for s, k in enumerate(numbers) if k >= 0)
        names.append(points[s].main[numbers[s]])
    return Campbell(
        speeds=np.array([p.speed for p in points]),
        frequencies=frequencies,
        fixed=fixed,
        damping=damping,
        growth=growth,
        overlaps=np.array(overlaps).reshape(-1, len(points) - 1).T,
        names=names,
        modes=modes,
        points=tuple(points),
    )


def crossings(
    diagram: Campbell,
    at: Callable[[float, Point | None], Point],
    harmonics: int,
    *,
    fixed: bool,
) -> list[Crossing]:
    """Return where branches cross the lines w = n W, n = 1 .. harmonics, by rising speed.

    A crossing between two speeds is found on a monotone cubic through the branch, and improved
    by the secant method.

    Parameters
    ----------
    diagram : branches over speed
    at : returns the modes at a speed [rad/s], from those of a point nearby
    harmonics : number of lines
    fixed : frequencies seen from axes at rest
    """
    from scipy.interpolate import PchipInterpolator

    points = []
    for branch in range(diagram.frequencies.shape[1]):
        w = diagram.followed(fixed)[:, branch]
        known = np.flatnonzero(np.isfinite(w))
        if known.size < 2:
            continue
        curve = PchipInterpolator(diagram.speeds[known], w[known])
        for n in range(1, harmonics + 1):
            off = w - n * diagram.speeds
            for s, s_next in pairwise(known.tolist()):
                if off[s] * off[s_next] < 0.0 or (off[s_next] == 0.0 and off[s] != 0.0):
                    points.append(_crossing(diagram, at, curve, branch, n, s, s_next, fixed=fixed))
    return sorted(points, key=lambda c: (c.speed, c.harmonic))


def _crossing(
    diagram: Campbell,
    at: Callable[[float, Point | None], Point],
    curve: "PchipInterpolator",
    branch: int,
    n: int,
    s: int,
    s_next: int,
    *,
    fixed: bool,
) -> Crossing:
    from scipy.interpolate import PPoly

    low, high = float(diagram.speeds[s]), float(diagram.speeds[s_next])
    line = curve.c.copy()
    line[-1] -= n * curve.x[:-1]
    line[-2] -= n
    roots = [r for r in PPoly(line, curve.x).roots(extrapolate=False).tolist() if low <= r <= high]
    speed = roots[0] if roots else 0.5 * (low + high)
    before, row = diagram.points[s], diagram.modes[s, branch]

    def off(speed: float) -> float:
        """Frequency minus that of the harmonic at a speed; nan if the mode is not found."""
        point = at(speed, before)
        k = int(match(before.vectors, point.vectors).successor[row])
        if k < 0:
            return float("nan")
        return abs(float((point.fixed if fixed else point.modes.frequencies)[k])) - n * speed

    w = diagram.followed(fixed)[:, branch]
    known = (low, float(w[s]) - n * low), (high, float(w[s_next]) - n * high)
    last = max(known, key=lambda pair: abs(pair[0] - speed))
    for _ in range(_SECANTS):  # the secant method
        distance = off(speed)
        if not np.isfinite(distance) or distance == last[1]:
            break
        better = speed - distance * (speed - last[0]) / (distance - last[1])
        last = speed, distance
        speed = min(max(better, low), high)
        if abs(speed - last[0]) <= CROSSING_FOUND * high:
            break
    return Crossing(branch, n, speed, n * speed)
