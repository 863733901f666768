"""Whether the motion grows exponentially, as that of an unstable feedback."""

from collections.abc import Iterator

import numpy as np

from ..dynamics.forces.contract import CoordinateForce
from ..dynamics.forces.table import FORCES
from ..dynamics.scales import scales, speed_of_drives
from ..errors import few
from ..math.arrays import Array
from ..math.keys import Code, Expression, Expressions
from ..results.codes.course import GROWS
from ..results.finding import Finding
from .finished import FinishedRun

# No power of time that loads or drives follow grows so fast: in the last tenth t^n grows by
# (10/9)^n, which is 3 for n = 10; the kinetic energy of a smooth step begins with t^6 at most.
PARTS, LAST, FACTOR = 10, 5, 3.0
DRIVEN = 10_001  # output times at which drives are looked at
# Kinds whose force the user writes as an expression or as code: a feedback may be among them.
ACTIVE = {
    kind
    for kind, force in FORCES.items()
    if isinstance(force, CoordinateForce)
    and any(isinstance(key, Expression | Expressions | Code) for key in force.keys)
}


def growth_findings(run: FinishedRun) -> Iterator[Finding]:
    """Yield a finding if the kinetic energy has grown exponentially beyond its scale."""
    peaks = _peaks(run)
    if peaks is None or not np.all(peaks[-LAST:] > FACTOR * peaks[-LAST - 1 : -1]):
        return
    t, y0 = run.solution.t, run.solution.y[0]
    size = scales(run.model, y0, run.mechanism.solver.t_end)
    # A drive may be fast for a moment, as a spline at a jump: motion that is prescribed, not grown.
    driven = speed_of_drives(run.model, y0, t[run.some(DRIVEN)], size.length)
    scale = max(size.energy, float(run.model.mass.sum()) * driven**2)
    value = float(peaks[-1] / scale) if scale > 0.0 else np.inf
    if value <= GROWS.limit:
        return
    named = [name for name, force in run.mechanism.forces.items() if force.kind in ACTIVE]
    forces = f": {few(named)}" if named else ""
    times = float((peaks[-1] / peaks[-LAST - 1]) ** (1.0 / LAST))
    every = float(t[-1] - t[0]) / PARTS
    text = (
        f"the motion grows exponentially: by t = {t[-1]:.4g} s the kinetic energy is "
        f"{peaks[-1]:.2g} J, {value:.2g} times that of the mechanism at its speed, and grows "
        f"{times:.2g}-fold in {every:.2g} s. Look for a feedback that is unstable{forces}"
    )
    yield GROWS.finding(text, t=float(t[-1]), value=value)


def _peaks(run: FinishedRun) -> Array | None:
    """Largest kinetic energy in each tenth of the run, (PARTS,) [J]; None of too few times."""
    known = np.array(run.past.kinetic)
    if not len(known) or not np.isfinite(known).all():
        return None
    first, last = float(run.solution.t[0]), float(known[-1, 0])
    part = np.minimum(
        (PARTS * (known[:, 0] - first) / max(last - first, 1e-300)).astype(int), PARTS - 1
    )
    if np.unique(part).size < PARTS:
        return None
    return np.array([known[part == i, 1].max() for i in range(PARTS)])
