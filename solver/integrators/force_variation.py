"""Forces that vary inside a step, but not where the step evaluates them.

Where laws of time break is known before the run (breakpoints.py). Where a law of coordinates, rates
and reactions breaks or has a peak is known only from the motion: a body that passes a narrow
contact within one step leaves nothing in its error estimate. Each accepted step is therefore looked
at: the quantities that an expression reads are polynomials between its ends, and interval
arithmetic bounds every part of the expression inside. A part that goes beyond its values at the
points that the method evaluates was not seen, and the step has to end there (docs/adr/0053).

Over a jump of a force the error estimate of a step may be a tenth of the error or less, whatever
the method: it compares sums over the same few points. Such a step may be only so long that the
jump changes the motion by less than the tolerance.
"""

import numpy as np

from ..dynamics.evaluation.series import marker_motions, quantities
from ..dynamics.model.model import DISTANCE, Model
from ..dynamics.model.motion import PLACE, VELOCITY
from ..math.arrays import Array, distinct
from ..math.laws import Hermite
from .breakpoints import programs_read
from .expression_breaks import BESIDE, Watched, bend, first_break, first_hidden, watched_expression
from .generic.base import Derivative
from .generic.norm import ErrorNorm

MOST_CELLS = 20_000  # of the steps of one look; a law that needs more varies fast everywhere
# Of the tolerance: an error by a bend above the first is looked at closer, and above the second
# costs a stop. Errors by bends are of one sign where a motion repeats, and add up.
UNSURE, SHARE = 0.03, 0.2
CLOSER, PARTS = 2, 8  # times, and parts of an interval, in which a break is located
# Longest steps over a jump within which it comes back; attempts to pass it that are no motion.
AHEAD, OFTEN = 20.0, 30
# Relative motion in a step over the distance of two places: a straight path past a place at b has
# the distance (b^2 + v^2 t^2)^(1/2), which a cubic polynomial then follows within 1e-6 b. Least
# distance that counts, over the largest so far.
FAR, NEAR = 0.1, 1e-3
# Of a state that friction holds: bends in a row, most steps between them and error by one [tol].
RESTS, SOON, LITTLE = 10, 30.0, 100.0
SURE = 10.0  # errors of a position over a step [tol], above which its rate is no straight line


class HiddenForces:
    """The expressions of a model that steps may pass without seeing how they vary.

    Parameters
    ----------
    model : a mechanism
    points : parts of a step, 0 and 1 among them, at which the method evaluates forces
    rates_fit : coordinates change over a step by their rates, to the tolerance
    """

    def __init__(self, model: Model, points: tuple[float, ...], rates_fit: bool) -> None:
        self._model, self._sure = model, SURE if rates_fit else np.inf
        at, cells = np.array(points), np.zeros((2, MOST_CELLS, 2))
        groups = (
            watched_expression(model, p, at, cells) for p in distinct(programs_read(model)).tolist()
        )
        self._watched = [each for each in groups if each is not None]
        first = model.n_pos + model.n_vel
        rates = 2 * len(model.quantities.kind) + model.n_aux  # of states, behind all values
        read = any((each.slope >= rates).any() for each in self._watched)
        self._states = slice(first, first + model.n_aux) if read else None
        self._breaking = [each for each in self._watched if each.breaking.any()]
        loads = {load for each in self._breaking for load in each.loads.tolist()}
        distances = np.flatnonzero(model.quantities.kind == DISTANCE).tolist()
        apart = [k for k in distances if 2 * k in loads]
        self._pairs: list[list[int]] = model.quantities.marker[apart].tolist()
        self._largest = 0.0  # distance of such a pair so far [m]
        self._gain: dict[int, float] = {}  # of errors by bends of expressions, the last one found
        self._last: dict[int, tuple[float, int]] = {}  # last jump [s], attempts
        self._bends: dict[int, tuple[float, int]] = {}  # last bend [s], those soon behind others
        self.chattering: dict[int, float] = {}  # expressions, and since when [s]

    def __bool__(self) -> bool:
        return bool(self._watched)

    def stops(
        self, t: Array, y: Array, rate: Derivative, norm: ErrorNorm, over_bends: bool
    ) -> list[float]:
        """Return the instants [s] at which steps have to end, for the earliest cause; or none.

        One for a force that was not seen; two around a jump; a bend, and the end of its step.

        Parameters
        ----------
        t, y : (k + 1,), (k + 1, n) ends of k steps
        rate : f(t, y) -> (n,), valid up to the next call
        norm : of errors; 1 is just acceptable
        over_bends : steps may go over bends
        """
        hidden, values = np.inf, self._values(t, y, rate)
        sure = self._sure / float(norm.weight(y[0], y[-1])[: self._model.n_pos].min())
        with np.errstate(all="ignore"):
            for each in self._watched:
                hidden = first_hidden(each, t, values, hidden, sure)
            hidden = min(hidden, self._passes(t, y))
            stops = [hidden] if np.isfinite(hidden) else []
            for each in list(self._breaking):
                i, part, jump, factor, reach = first_break(each, t, values, 0, 0.0, sure)
                while i >= 0 and t[i] + part * (t[i + 1] - t[i]) < hidden:
                    h = float(t[i + 1] - t[i])
                    cost = h * self._gain.get(each.program, np.inf) * min(factor, reach)
                    bends = cost > UNSURE and not over_bends
                    if jump > 0.0 or (bends and not self._rests(each, float(t[i]), h, cost)):
                        path = _path(t[i : i + 2], y[i : i + 2], rate)
                        more = self._within(each, path, np.inf if over_bends else reach, rate, norm)
                        if more and more[0] < hidden:
                            hidden, stops = more[0], more
                            break
                        part = 1.0
                    i, part, jump, factor, reach = first_break(each, t, values, i, part, sure)
        return stops

    def _passes(self, t: Array, y: Array) -> float:
        """Return the middle of the first step in which a distance is no polynomial, [s]; or inf."""
        passed = np.inf
        for pair in self._pairs:
            one, two = (marker_motions(self._model, k, y)[0] for k in pair)
            apart, speed = (
                np.linalg.norm((two - one)[:, first : first + 3], axis=1)
                for first in (PLACE, VELOCITY)
            )
            self._largest = max(self._largest, float(apart.max()))
            near = np.maximum(np.minimum(apart[1:], apart[:-1]), NEAR * self._largest)
            far = np.diff(t) * np.maximum(speed[1:], speed[:-1]) > FAR * near
            if far.any():
                i = int(np.argmax(far))
                passed = min(passed, float(0.5 * (t[i] + t[i + 1])))
        return passed

    def _values(self, t: Array, y: Array, rate: Derivative) -> Array:
        """Return all quantities at times t (k,), and behind them the rates of states if read."""
        values, states = quantities(self._model, t, y), self._states
        if states is None:
            return values
        rates = [rate(float(one), row)[states].copy() for one, row in zip(t, y, strict=True)]
        return np.hstack([values, np.array(rates)])

    def _within(
        self, each: Watched, path: Hermite, reach: float, rate: Derivative, norm: ErrorNorm
    ) -> list[float]:
        """Return stops about the first break of a step that costs more than its share, or none.

        Wherever a jump is, its error is at most that of the jump over the whole step; that of a
        bend is at most that of a jump by `reach`, the range of the expression over the step.
        Bends are passed if that is infinite.
        """
        end = path.t_old + path.h
        at, jump = self._next(each, path, path.t_old, rate)
        while at < end:
            close = 1e3 * np.spacing(abs(at))
            side = min(at - path.t_old, end - at)
            if jump:
                change = norm((path.f_1 - path.f_0) * norm.weight(path.y_0, path.y_1))
                most = max(SHARE / max(change, 1e-300), close)
                if path.h > most and not self._chatters(each, at):
                    return [max(at - 0.4 * most, path.t_old), at + 0.4 * most, end]
                later = np.array([path.t_old, end + AHEAD * most])
                beyond = path.y_1 + AHEAD * most * path.f_1
                self._pass(each, later, np.stack([path.y_0, beyond]), rate)
            elif (
                reach < np.inf
                and side > 2.0 * close
                and path.h * self._bend(each, path, at, side, reach, rate, norm) > SHARE
            ):
                # The step in two, as the next one could be so long that stages of no weight throw
                # the state out of a contact. Surely before what turns out to be a jump.
                return [at - close, end]
            at, jump = self._next(each, path, at, rate)
        return []

    def _next(
        self, each: Watched, path: Hermite, begin: float, rate: Derivative
    ) -> tuple[float, bool]:
        """Return the next break along a step behind `begin` [s], or its end; whether it jumps."""
        low, high = begin, path.t_old + path.h
        for _ in range(CLOSER):
            t = np.linspace(low, high, PARTS + 1)
            i, part, jump, *_ = first_break(each, t, self._values(t, path(t), rate), 0, 0.0, np.inf)
            if i < 0:
                return path.t_old + path.h, False
            low, high = float(t[i]), float(t[i + 1])
        return max(low + part * (high - low), begin + 4.0 * np.spacing(begin)), jump > 0.0

    def _bend(
        self,
        each: Watched,
        path: Hermite,
        at: float,
        side: float,
        reach: float,
        rate: Derivative,
        norm: ErrorNorm,
    ) -> float:
        """Return the error by a bend at time `at`, of a step of unit length, in tolerances."""
        near = at + side * BESIDE * np.arange(-2.0, 3.0)
        states = path(near)
        factor, turn = bend(each, near, quantities(self._model, near, states))
        if turn == 0.0:
            return 0.0
        rates = [rate(float(near[k]), states[k]).copy() for k in (1, 2, 3)]
        weight = norm.weight(path.y_0, path.y_0)  # the end may be far off
        gain = norm((rates[0] - 2.0 * rates[1] + rates[2]) * weight) / turn
        self._gain[each.program] = gain
        return gain * min(factor, reach)

    def _rests(self, watched: Watched, at: float, h: float, cost: float) -> bool:
        """Return whether friction holds the state, which short steps throw over its rise and back.

        Then steps pass bends often, each soon after the last one, at little cost.
        """
        last, count = self._bends.get(watched.program, (-np.inf, 0))
        soon = watched.rises and at - last < SOON * h and (cost < LITTLE or count > RESTS)
        count = count + (at > last) if soon else 0
        self._bends[watched.program] = max(at, last), count
        return count > RESTS

    def _chatters(self, watched: Watched, at: float) -> bool:
        """Count an attempt to step up to a jump at time `at`; return whether it is one too many."""
        p = watched.program
        last, count = self._last.get(p, (-np.inf, 0))
        self._last[p] = last, count + 1
        if count == OFTEN:
            self.chattering[p] = at
            self._breaking = [each for each in self._breaking if each.program != p]
        return count == OFTEN

    def _pass(self, watched: Watched, t: Array, y: Array, rate: Derivative) -> None:
        """Note a step over a jump, which is behind the motion if the motion does not come back.

        If it does, both forces push towards the jump and hold the state there. t, y : (2,), (2, n)
        before the jump, and a little later on the straight line on which the state leaves it.
        """
        last, count = self._last.get(watched.program, (-np.inf, 0))
        if t[0] > last:  # not taken again
            values = self._values(t, y, rate)
            behind = first_break(watched, t, values, 0, 0.0, np.inf)[2] > 0.0
            self._last[watched.program] = float(t[0]), 0 if behind else count
            if not behind:
                self._chatters(watched, float(t[0]))


def _path(t: Array, y: Array, rate: Derivative) -> Hermite:
    """Return the cubic by states and rates between the ends t (2,), y (2, n) of a step."""
    rates = [rate(float(t[k]), y[k]).copy() for k in range(2)]
    return Hermite(float(t[0]), float(t[1] - t[0]), y[0], rates[0], y[1], rates[1])
