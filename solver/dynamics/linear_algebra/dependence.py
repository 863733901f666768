"""Whether constraint rows depend on each other, whatever the masses of the bodies.

A small pivot of J K^-1 J' has two causes: rows that depend on each other, and a heavy body
behind a light one, which two rows hold almost as one. Only the first leaves forces undetermined.
"""

from ...math.arrays import Array
from ...math.compiled import lean
from ..elements.joints.table import DRIVES, KINDS
from ..model.model import Model
from ..model.order import Order
from ..model.workspace import Factors
from .elimination import factorise

# Smallest ratio of a pivot to its diagonal entry, below which rows are treated as dependent
# and the penalty is used: an elimination without it would lose more than half of the digits.
REGULAR = 1e-7
CLEARLY = 1e3  # of the geometry alone: rows that are independent have such a multiple of it
ABSENT = 1e100  # softness of a row that holds nothing
_DRIVES = frozenset(KINDS[name] for name in DRIVES)


def is_tree(model: Model) -> bool:
    """Tell whether joints close no loop, so that no constraint row ever depends on others.

    Every joint leads to a body that no other one holds, and a drive takes a freedom that its joint
    leaves. Pivots are no measure then: that of the last joint of a chain falls with the third power
    of the number of links, whose inertia it moves.
    """
    if model.quantities.coupling_start.shape[0] > 1:
        return False
    root, pairs = list(range(model.n_body + 1)), set()
    driven: set[tuple[int, ...]] = set()

    def group(body: int) -> int:
        while root[body] != body:
            root[body] = root[root[body]]
            body = root[body]
        return body

    for kind, ends in zip(model.joint_kind, model.joint_marker.tolist(), strict=True):
        if kind in _DRIVES and tuple(ends) in pairs:
            if (int(kind), *ends) in driven:
                return False
            driven.add((int(kind), *ends))
            continue
        one, two = (group(int(model.marker_body[k]) % (model.n_body + 1)) for k in ends)
        if one == two:
            return False
        root[one] = two
        pairs.add(tuple(ends))
    return True


@lean
def rows_depend(model: Model, order: Order, factors: Factors, J: Array, softness: Array) -> bool:
    """Tell whether constraint rows depend on each other; `factors` and `softness` are overwritten.

    Every body counts as one of unit mass with its own radius of gyration and its own modes, so
    that the pivots are those of the geometry.
    """
    for i in range(model.n_body):
        L, v = factors.L[i], model.vel_start[i]
        for a in range(model.plan.size[i]):
            for b in range(a):
                L[a, b] = 0.0
            L[a, a] = model.inertia_scale[v + a] / model.inertia_scale[v]
    for k in range(softness.shape[0]):
        softness[k] = 0.0 if k < model.n_constraint else ABSENT
    factorise(model.plan, order, factors, J, softness)
    return bool(factors.regular[0] < CLEARLY * REGULAR)
