"""Watch a run for the instant at which the loads of a flexible body reach its buckling load."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from ..dynamics.model import Model
from ..dynamics.recover import stiffened
from ..integrators.generic import Steps, StopRequest
from ..integrators.generic.base import Dense
from ..math.arrays import Array
from ..results.codes.motion import BUCKLING, BUCKLING_LOAD
from ..results.finding import Finding
from .geometric_stiffness import Loading, geometric_stiffness
from .spin import SpinMonitor

LOOKS = 1000  # of a run, and one of each block of steps


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
    _loading: Loading = field(init=False)

    def __post_init__(self) -> None:
        self._loading = Loading(self.model)

    def __call__(self, steps: Steps) -> StopRequest | None:
        """Check the steps just taken; called by `integrate`."""
        part = np.floor(steps.t[1:] * (LOOKS / self.t_end)).astype(int)
        looks = 1 + np.flatnonzero(np.diff(part, prepend=self._last) > 0)
        self._last = int(part[-1]) if part.size else self._last
        request, known = None, {finding.body for finding in self.findings}
        for i in self.bodies if looks.size else ():
            if self.spin.body_names[i] in known:
                continue
            lost = np.flatnonzero(~(self.margin(i, steps.t[looks], steps.y[looks]) > 0.0))
            if lost.size:
                before = int(looks[lost[0] - 1]) if lost[0] > 0 else 0
                found = self._found(i, steps, before, int(looks[lost[0]]))
                assert found.t is not None
                ends = self.stop and stiffened(self.model, i)
                if ends and (request is None or found.t < request.t_stop):
                    request = StopRequest(found.t, found.text, found.code)
        return request

    def margin(self, i: int, t: Array, y: Array) -> Array:
        """Smallest eigenvalue of the stiffness of body i in states y (k, n), (k,) [1/s2]."""
        elastic = np.array([np.subtract(*self.spin.matrices(i, state)) for state in y])
        whole = elastic + geometric_stiffness(self.model, self.tables, i, t, y, self._loading(t, y))
        found = np.full(t.size, np.nan)
        finite = np.isfinite(whole).all(axis=(1, 2))
        found[finite] = np.linalg.eigvalsh(whole[finite])[:, 0]
        return found

    def _found(self, i: int, steps: Steps, before: int, after: int) -> Finding:
        """Find the instant between two ends of steps, and keep what was found."""
        ends = np.arange(before + 1, after + 1)
        step = before + int(np.argmax(~(self.margin(i, steps.t[ends], steps.y[ends]) > 0.0)))
        t = self._crossing(i, steps.t[step], steps.t[step + 1], steps.dense_output(step))
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
