"""Forces that vary inside a step, but not where the step evaluates them.

Where laws of time break is known before the run (breakpoints.py). Where a law of coordinates, rates
and reactions breaks or has a peak is known only from the motion: a body that passes a narrow
contact within one step leaves nothing in its error estimate. Each accepted step is therefore looked
at: the quantities that an expression reads are polynomials between its ends, and interval
arithmetic bounds every part of the expression inside. A part that goes beyond its values at the
points that the method evaluates was not seen, and the step has to end there (docs/adr/0053).
"""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..dynamics.evaluation.series import quantities
from ..dynamics.model.model import SPIN, Model
from ..math.arrays import Array, IntArray
from ..math.expressions import operations as op
from ..math.expressions.program import Programs
from ..math.expressions.ranges import Range, parts
from .breakpoints import SPLIT, VARIES, programs_read

SHORTEST = 1e-6  # part of a step: what a shorter peak adds to the motion is below its rounding
MOST_CELLS = 20_000  # of the steps of one look; a law that needs more varies fast everywhere
WIDER = 4.0  # ranges of a look, by which the bounds without variation are wider
SUMS = frozenset((op.ADD, op.SUBTRACT, op.NEGATE))


class _Watched(NamedTuple):
    """An expression that reads the state, and which of its parts can hide something."""

    program: int
    timed: bool  # reads the time
    loads: IntArray  # (l,) quantities that it reads
    curved: NDArray[np.bool_]  # (parts,) not linear in them
    span: Array  # (parts, 2) least and largest value of each part so far
    quiet: Array  # (2, 1 + l) bounds of time and quantities within which no part varies much


class HiddenForces:
    """The expressions of a model that steps may pass without seeing how they vary.

    Parameters
    ----------
    model : a mechanism
    points : parts of a step, 0 and 1 among them, at which the method evaluates forces
    """

    def __init__(self, model: Model, points: tuple[float, ...]) -> None:
        self._model, self._points = model, np.array(points)
        programs = model.quantities.programs
        found = (_watched(programs, p) for p in np.unique(programs_read(model)).tolist())
        self._watched = [each for each in found if each is not None]
        loads = [each.loads for each in self._watched]
        self._loads = np.unique(np.concatenate([np.zeros(0, dtype=np.int64), *loads]))

    def __bool__(self) -> bool:
        return bool(self._watched)

    def first(self, t: Array, y: Array) -> float | None:
        """Return the earliest instant [s] at which a force was not seen; None if there is none.

        t, y : (k + 1,), (k + 1, n) ends of k steps
        """
        if len(t) < 2:
            return None
        path = _Path(self._model, self._loads, t, y)
        whole = path.ranges(np.arange(path.steps), np.zeros(path.steps), np.ones(path.steps))
        found = [self._hidden(each, path, whole) for each in self._watched]
        return min((instant for instant in found if instant is not None), default=None)

    def _hidden(self, watched: _Watched, path: "_Path", whole: "_Cells") -> float | None:
        read = [whole.time, *(whole.loads[k] for k in watched.loads.tolist())]
        low = np.array([each[0].min() for each in read])
        high = np.array([each[1].max() for each in read])
        if (low >= watched.quiet[0]).all() and (high <= watched.quiet[1]).all():
            return None
        own = np.flatnonzero(self._varies(watched, whole, path.steps))
        if own.size:
            return self._unseen(watched, path, own)
        wide = low - WIDER * (high - low), high + WIDER * (high - low)
        first, *others = zip(*(end[:, None] for end in wide), strict=True)
        around = _Cells(first, dict(zip(watched.loads.tolist(), others, strict=True)))
        if not self._varies(watched, around, 1).any():
            watched.quiet[:] = wide
            if not watched.timed:
                watched.quiet[:, 0] = -np.inf, np.inf
        return None

    def _varies(self, watched: _Watched, cells: "_Cells", count: int) -> NDArray[np.bool_]:
        """Tell in which cells a part may vary by more than a share of its range so far."""
        found = np.zeros(count, dtype=bool)
        for k, (least, most) in self._bounds(watched, cells):
            span = watched.span[k]
            loud = ~(most - least <= VARIES * max(span[1] - span[0], 0.0))
            span[:] = least[~loud].min(initial=span[0]), most[~loud].max(initial=span[1])
            found |= loud
        return found

    def _unseen(self, watched: _Watched, path: "_Path", own: IntArray) -> float | None:
        """Look at the steps `own`, in which a part may vary by more than a share of its range."""
        n = len(self._points)
        nodes = path.ranges(np.repeat(own, n), *2 * [np.tile(self._points, len(own))])
        row = np.zeros(path.steps, dtype=np.int64)
        row[own] = np.arange(len(own))
        limits = {}  # of each part and step, beyond which it was not seen
        for k, (value, _) in self._bounds(watched, nodes):
            seen = np.broadcast_to(value, len(own) * n).reshape(-1, n)
            known, span = seen[np.isfinite(seen)], watched.span[k]
            span[:] = known.min(initial=span[0]), known.max(initial=span[1])
            low, high = seen.min(axis=1), seen.max(axis=1)
            margin = np.maximum(VARIES * max(span[1] - span[0], 0.0), high - low)
            limits[k] = low - margin, high + margin

        def outside(steps: IntArray, a: Array, b: Array) -> NDArray[np.bool_]:
            """Tell in which cells a part may be beyond what was seen of it in the step."""
            far, at = np.zeros(len(steps), dtype=bool), row[steps]
            for k, (least, most) in self._bounds(watched, path.ranges(steps, a, b)):
                far |= (least < limits[k][0][at]) | (most > limits[k][1][at])
            return far

        steps, a, b, found = own, np.zeros(len(own)), np.ones(len(own)), np.inf
        while steps.size and SPLIT * steps.size <= MOST_CELLS:
            far = outside(steps, a, b) & (b - a > SHORTEST)
            steps, a, b = steps[far], a[far], b[far]
            middle = 0.5 * (a + b)
            instants = path.times(steps, middle)[outside(steps, middle, middle)]
            found = min(found, instants.min(initial=np.inf))
            earlier = path.times(steps, a) < found
            steps, a, b = _split(steps[earlier], a[earlier], b[earlier])
        return float(found) if np.isfinite(found) else None

    def _bounds(self, watched: _Watched, cells: "_Cells") -> Iterator[tuple[int, Range]]:
        """Yield number and bounds, over cells, of the parts that are not linear."""
        programs = self._model.quantities.programs
        every = parts(programs, watched.program, *cells.time, cells.loads)
        for k, part in enumerate(every):
            if watched.curved[k]:
                yield k, (part.low, part.high)


def _split(steps: IntArray, a: Array, b: Array) -> tuple[IntArray, Array, Array]:
    edges = a[:, None] + (b - a)[:, None] * (np.arange(SPLIT + 1) / SPLIT)
    return np.repeat(steps, SPLIT), edges[:, :-1].ravel(), edges[:, 1:].ravel()


def _watched(programs: Programs, p: int) -> _Watched | None:
    """Return an expression that reads the state and is not linear in it; else None."""
    own = slice(int(programs.start[p]), int(programs.start[p + 1]))
    codes, arguments = programs.code[own], programs.argument[own]
    loads = np.unique(arguments[codes == op.LOAD].astype(np.int64))
    constant, linear, curved = 0, 1, 2
    stack: list[int] = []
    found = []
    for code in codes.tolist():
        if code in op.PUSHES:
            stack.append(constant if code == op.CONSTANT else linear)
            continue
        count = 3 if code == op.SELECT else 2 if code in op.BINARY else 1
        given, stack = stack[-count:], stack[:-count]
        scaled = (code == op.MULTIPLY and min(given) == constant) or (
            code == op.DIVIDE and given[1] == constant
        )
        kept = code in SUMS or scaled or max(given) == constant
        stack.append(max(given) if kept else curved)
        found.append(stack[-1] == curved)
    if not loads.size or not any(found):
        return None
    nothing = np.array([np.inf, -np.inf])
    quiet = np.repeat(nothing[:, None], 1 + len(loads), axis=1)
    timed = bool((codes == op.TIME).any())
    return _Watched(p, timed, loads, np.array(found), np.tile(nothing, (len(found), 1)), quiet)


class _Cells(NamedTuple):
    """Bounds over parts of steps, (c,) each."""

    time: Range  # [s]
    loads: dict[int, Range]  # by number of the quantity


class _Path:
    """The quantities that expressions read, along steps with given ends.

    A coordinate is the cubic by its values and rates, whose Bezier points bound it; other
    quantities are taken as linear.
    """

    def __init__(self, model: Model, loads: IntArray, t: Array, y: Array) -> None:
        n, every = len(model.quantities.kind), quantities(model, t, y)
        cubic = (loads < 2 * n) & (loads % 2 == 0)
        cubic[cubic] = model.quantities.kind[loads[cubic] // 2] != SPIN
        value, rate = every[:, loads], every[:, np.where(cubic, loads + 1, 0)]
        h = np.diff(t)
        self._t, self._h, self.steps = t, h, len(h)
        first, rise = value[:-1], np.diff(value, axis=0)
        begin = np.where(cubic, h[:, None] * rate[:-1], rise)
        end = np.where(cubic, h[:, None] * rate[1:], rise)
        # coefficients of the powers of the part of a step
        self._powers = np.stack([first, begin, 3 * rise - 2 * begin - end, begin + end - 2 * rise])
        self._numbers = loads.tolist()

    def times(self, steps: IntArray, at: Array) -> Array:
        """Return instants [s] at parts of steps, (c,) each."""
        return np.asarray(self._t[steps] + at * self._h[steps])

    def ranges(self, steps: IntArray, a: Array, b: Array) -> _Cells:
        """Return bounds of the quantities over cells [a, b] of steps, (c,) each."""
        p, q, r, s = self._powers[:, steps]
        a, b = a[:, None], b[:, None]
        one, two = p + a * (q + a * (r + a * s)), p + b * (q + b * (r + b * s))
        third = (b - a) / 3.0
        near = one + third * (q + a * (2.0 * r + 3.0 * a * s))
        far = two - third * (q + b * (2.0 * r + 3.0 * b * s))
        low = np.minimum(np.minimum(one, two), np.minimum(near, far)).T
        high = np.maximum(np.maximum(one, two), np.maximum(near, far)).T
        times = self.times(steps, a[:, 0]), self.times(steps, b[:, 0])
        each = zip(low, high, strict=True)
        return _Cells(times, dict(zip(self._numbers, each, strict=True)))
