"""Watch a run for the instant at which the loads of a flexible body reach its buckling load."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ...dynamics.analysis.recovery import stiffened
from ...dynamics.model.model import Model
from ...integrators.generic.base import Dense
from ...integrators.generic.drive import Steps, StopRequest
from ...math.arrays import Array, IntArray
from ...results.codes import BUCKLING, BUCKLING_LOAD, Finding
from .geometric_stiffness import Loading, geometric_stiffness
from .spin import SpinMonitor

LOOKS = 1000  # of a run, and one of each block of steps
# Over the lowest frequency of the body [rad]: it does not notice a load that passes sooner, as the
# waves of stress that follow a sudden release.
LASTS = 0.05


def buckling_text(name: str, t: float, *, linear: bool = False) -> str:
    """Return the message for a body, stiffened by default, that buckles at t [s]."""
    beyond, remedy = "Second-order displacements are accurate up to this load only", "Split"
    if linear:
        beyond = "A linear body keeps its full stiffness"
        remedy = "Set geometric_stiffening = true, split"
    return (
        f"{name}: at t = {t:.6g} s the loads of the motion and of the joints reach the buckling "
        f"load of the body. {beyond}: results after this time are invalid. {remedy} the body, "
        "stiffen it, or reduce the load"
    )


@dataclass
class BucklingMonitor:
    """Find when elastic and geometric stiffness together lose an eigenvalue.

    A stiffened body buckles then, and second-order displacements do not follow it far: the run
    ends, if asked to. A linear body keeps its stiffness, which is wrong from then on.

    A load that passes sooner than the body can follow is none that it buckles under.

    Parameters
    ----------
    tables : the same mechanism with the second-order terms of all bodies that have them
    bodies : these bodies
    t_end : of the run [s]
    """

    model: Model
    tables: Model
    bodies: Sequence[int]
    spin: SpinMonitor
    t_end: float
    stop: bool = True
    findings: list[Finding] = field(default_factory=list)  # one for each body
    _last: int = -1  # part of the run in which the last look was
    _since: dict[int, float] = field(default_factory=dict)  # start of a loss that lasts so far [s]
    _loading: Loading = field(init=False)

    def __post_init__(self) -> None:
        self._loading = Loading(self.model)
        self._lasts = {i: self._lasting(i) for i in self.bodies}

    def _lasting(self, i: int) -> float:
        """Return how long a loss must last to count [s]."""
        m, two = int(self.model.n_mode[i]), int(self.model.square_start[i])
        lowest = np.linalg.eigvalsh(self.model.K_qq[two : two + m * m].reshape(m, m))[:1]
        return LASTS / float(lowest[0]) ** 0.5 if lowest.size and lowest[0] > 0.0 else 0.0

    def __call__(self, steps: Steps) -> StopRequest | None:
        """Check the steps just taken; called by `integrate`."""
        part = np.floor(steps.t[1:] * (LOOKS / self.t_end)).astype(int)
        looks = 1 + np.flatnonzero(np.diff(part, prepend=self._last) > 0)
        self._last = int(part[-1]) if part.size else self._last
        request, known = None, {finding.body for finding in self.findings}
        for i in self.bodies:
            if self.spin.body_names[i] in known:
                continue
            t = self._lost(i, steps, looks)
            if t is None:
                continue
            found = self._found(i, t)
            ends = self.stop and stiffened(self.model, i)
            if ends and (request is None or t < request.t_stop):
                request = StopRequest(t, found.text, found.code)
        return request

    def margin(self, i: int, t: Array, y: Array) -> Array:
        """Smallest eigenvalue of the stiffness of body i in states y (k, n), (k,) [1/s2]."""
        elastic = np.array([np.subtract(*self.spin.matrices(i, state)) for state in y])
        whole = elastic + geometric_stiffness(self.model, self.tables, i, t, y, self._loading(t, y))
        found = np.full(t.size, np.nan)
        finite = np.isfinite(whole).all(axis=(1, 2))
        found[finite] = np.linalg.eigvalsh(whole[finite])[:, 0]
        return found

    def _lost(self, i: int, steps: Steps, looks: IntArray) -> float | None:
        """Return the time at which body i has been without stiffness long enough [s]."""
        first = 1  # end of a step that is not looked at yet
        while True:
            if i not in self._since:
                ahead = looks[looks >= first]
                lost = self._without(i, steps, ahead)
                if not lost.any():
                    return None
                k = int(np.argmax(lost))
                ends = np.arange(int(ahead[k - 1]) + 1 if k > 0 else first, int(ahead[k]) + 1)
                first = int(ends[np.argmax(self._without(i, steps, ends))])
                dense = steps.dense_output(first - 1)
                self._since[i] = self._crossing(i, steps.t[first - 1], steps.t[first], dense)
            until = self._since[i] + self._lasts[i]
            last = min(int(np.searchsorted(steps.t, until)), len(steps))
            ends = np.arange(first, last + 1)
            back = ~self._without(i, steps, ends)
            if not back.any():
                return until if steps.t[last] >= until else None
            del self._since[i]
            first = int(ends[np.argmax(back)]) + 1

    def _without(self, i: int, steps: Steps, ends: IntArray) -> NDArray[np.bool_]:
        """Tell at which ends of steps (k,) body i has no stiffness left, (k,)."""
        if not ends.size:
            return np.zeros(0, dtype=bool)
        return ~(self.margin(i, steps.t[ends], steps.y[ends]) > 0.0)

    def _found(self, i: int, t: float) -> Finding:
        """Keep and return what was found at t [s]."""
        name, linear = self.spin.body_names[i], not stiffened(self.model, i)
        code = BUCKLING_LOAD if linear else BUCKLING
        text = buckling_text(name, t, linear=linear)
        self.findings.append(code.finding(text, body=name, t=t))
        return self.findings[-1]

    def _crossing(self, i: int, low: float, high: float, dense: Dense) -> float:
        """Bisect a step for the time at which the margin passes zero."""
        while high - low > 1e-6 * self.t_end:
            middle = np.array([0.5 * (low + high)])
            if self.margin(i, middle, dense(middle))[0] > 0.0:
                low = float(middle[0])
            else:
                high = float(middle[0])
        return float(high)
