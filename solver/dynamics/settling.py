"""Forces that read the reactions of joints, such as friction in a bearing.

The multipliers depend on the forces, and these forces on the multipliers. At given multipliers
`reactions_into` fills the sizes of the reactions, which expressions read. Implicit steps hand over
the multipliers that they iterate (integrators/compiled/residual.py). Where accelerations are
computed (derivative.py), multipliers and forces are iterated until they agree: fixed points with
the relaxation of Aitken for vectors (B. M. Irons and R. C. Tuck, A version of the Aitken
accelerator for computer iteration, Int. J. Numer. Methods Eng. 1 (1969) 275-277).
"""

import numpy as np

from ..math.compiled import inlined, lean
from ..math.triple import Triple, dot3, minus3, sum3, times3, triple
from .applied_forces import add_wrench, coordinate_wrench
from .bodies.motion import axis
from .measures import force_size
from .model import Model
from .quantities import AXIAL, BENDING, RADIAL
from .workspace import Work

MOST_PASSES = 60
# What a force may miss, over its size and over the largest multiplier (rounding).
SETTLED, ROUNDING = 1e-11, 1e-14


@inlined
def reaction_slope(model: Model, work: Work, r: int, row: int) -> float:
    """Return the derivative of size r of a reaction by multiplier `row` of its joint."""
    load, unit, n = _load(model, work, r), _load_of(model, work, r, row), _axis(model, work, r)
    along = dot3(load, n)
    if model.quantities.reaction_kind[r] in (RADIAL, BENDING):
        across = minus3(load, times3(along, n))
        size = float(np.sqrt(dot3(across, across)))
        return dot3(across, unit) / size if size > 0.0 else 0.0
    return dot3(n, unit) if along > 0.0 else -dot3(n, unit)


@lean
def reactions_into(model: Model, work: Work) -> None:
    """Fill the sizes of reactions in work.quantity from the rows and work.multipliers."""
    q = model.quantities
    first = work.quantity.shape[0] - q.reaction_kind.shape[0]
    for r in range(q.reaction_kind.shape[0]):
        load, n = _load(model, work, r), _axis(model, work, r)
        work.quantity[first + r] = _size(q.reaction_kind[r], load, n)


@inlined
def _load(model: Model, work: Work, r: int) -> Triple:
    """Return the force or moment of reaction r at work.multipliers."""
    joint, load = model.quantities.reaction_joint[r], (0.0, 0.0, 0.0)
    for row in range(model.joint_row[joint], model.joint_row[joint + 1]):
        load = sum3(load, times3(work.multipliers[row], _load_of(model, work, r, row)))
    return load


@inlined
def _load_of(model: Model, work: Work, r: int, row: int) -> Triple:
    """Return the force or moment of reaction r of a unit of multiplier `row`."""
    begin = 6 if model.quantities.reaction_kind[r] in (RADIAL, AXIAL) else 9
    return times3(-1.0, triple(work.rows[row, begin:]))


@inlined
def _axis(model: Model, work: Work, r: int) -> Triple:
    """Return the axis of the joint of reaction r."""
    joint = model.quantities.reaction_joint[r]
    return axis(work.motion[model.joint_marker[joint, 0]], 2)


@inlined
def _size(kind: int, load: Triple, n: Triple) -> float:
    """Return the size of a load across the axis n, or along it."""
    along = dot3(load, n)
    if kind in (RADIAL, BENDING):
        across = minus3(load, times3(along, n))
        return float(np.sqrt(dot3(across, across)))
    return abs(along)


@lean
def move_forces(model: Model, work: Work, t: float, passed: int) -> bool:
    """Move forces that read reactions towards those at work.multipliers; tell if they differ.

    Their sizes, work.f and the power follow. `passed` is the number of calls before, for the same
    evaluation.
    """
    q, left = model.quantities, work.unsettled
    last = left.shape[0] - 1
    reactions_into(model, work)
    largest = 0.0
    for k in range(work.multipliers.shape[0]):
        largest = max(largest, abs(work.multipliers[k]))
    differ, product, square = False, 0.0, 0.0
    for k in q.reacting:
        before = work.size[k, 0]
        force_size(q, k, t, work.quantity, work.size[k])
        missing = work.size[k, 0] - before
        work.size[k, 0] = before
        # not-a-number differs
        if not abs(missing) <= SETTLED * abs(before) + ROUNDING * largest:
            differ = True
        change = missing - left[k, 0]
        product += left[k, 0] * change
        square += change * change
        left[k, 0] = missing
    relax = 1.0
    if passed > 0 and square > 0.0:
        relax = -left[last, 0] * product / square
    left[last, 0] = relax
    if differ:
        for k in q.reacting:
            more = relax * left[k, 0]
            work.size[k, 0] += more
            add_wrench(model, work, k, coordinate_wrench(model, work, k, more))
    return differ
