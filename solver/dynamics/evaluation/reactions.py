"""Sizes of the reactions of joints that forces read, and their derivatives."""

import numpy as np

from ...math.arrays import Triple
from ...math.compiled import inlined, lean
from ...math.rotations import dot3, minus3, sum3, times3, triple
from ..model.model import (
    AXIAL,
    BENDING,
    RADIAL,
    Model,
    Workspace,
)
from ..model.motion import axis


@inlined
def reads_reactions(model: Model) -> bool:
    """Return whether forces or states read the reactions of joints."""
    return bool(model.quantities.reaction_kind.shape[0] > 0)


@inlined
def reaction_slope(model: Model, work: Workspace, r: int, row: int) -> float:
    """Return the derivative of size r of a reaction by multiplier `row` of its joint.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    work : memory of one evaluation
    r : number of the reaction
    row : row of a multiplier of its joint
    """
    load, unit, n = _load(model, work, r), _load_of(model, work, r, row), _axis(model, work, r)
    along = dot3(load, n)
    if model.quantities.reaction_kind[r] in (RADIAL, BENDING):
        across = minus3(load, times3(along, n))
        size = float(np.sqrt(dot3(across, across)))
        return dot3(across, unit) / size if size > 0.0 else 0.0
    return dot3(n, unit) if along > 0.0 else -dot3(n, unit)


@lean
def reactions_into(model: Model, work: Workspace) -> None:
    """Fill the sizes of reactions in work.quantity from the rows and work.multipliers."""
    q = model.quantities
    first = work.quantity.shape[0] - q.reaction_kind.shape[0]
    for r in range(q.reaction_kind.shape[0]):
        load, n = _load(model, work, r), _axis(model, work, r)
        work.quantity[first + r] = _size(q.reaction_kind[r], load, n)


@inlined
def _load(model: Model, work: Workspace, r: int) -> Triple:
    """Return the force or moment of reaction r at work.multipliers."""
    joint, load = model.quantities.reaction_joint[r], (0.0, 0.0, 0.0)
    for row in range(model.joint_row[joint], model.joint_row[joint + 1]):
        load = sum3(load, times3(work.multipliers[row], _load_of(model, work, r, row)))
    return load


@inlined
def _load_of(model: Model, work: Workspace, r: int, row: int) -> Triple:
    """Return the force or moment of reaction r of a unit of multiplier `row`."""
    begin = 6 if model.quantities.reaction_kind[r] in (RADIAL, AXIAL) else 9
    return times3(-1.0, triple(work.rows[row, begin:]))


@inlined
def _axis(model: Model, work: Workspace, r: int) -> Triple:
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
