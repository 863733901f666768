"""Error of the mesh of shells, once the model has the finer mesh of the second package.

While the model has the mesh of the first package, the check shows the error of its mesh. With the
same mesh, both have the same error. The model with the mesh of the first package shows it: if e is
the error of a mesh and decreases with the power p of the size of its cells, the two differ by
(2^p - 1) e of the finer one. Shells converge with p = 2, and with p = 1 beside corners, rigid edges
and edge layers of plates. The estimate takes p = 1: the difference itself.

Beams need no such run: their error decreases with the fourth power.
"""

from collections.abc import Callable, Iterable

from ..math.arrays import Array
from .plan import Plan
from .trial import Trial, distance


def mesh_error(
    model: Trial, shells: Iterable[str], metric: str, run: Callable[[Plan], Trial | None]
) -> tuple[Array | None, str]:
    """Return the estimated error of the meshes of shells (o,), and the bodies in words.

    No bodies: none has the finer mesh. None with bodies: the budget is used up.
    """
    plan = model.plan
    finer = [n for n in shells if plan.bodies[n].mesh == "check" and not plan.bodies[n].rigid]
    for name in finer:
        plan = plan.with_body(name, mesh="model")
    other = run(plan) if finer else None
    error = None if other is None else distance(metric, other, model)
    return error, " and ".join(finer)
