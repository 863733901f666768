"""The joints and drives of this folder by name and number, and the call of their kernels."""

import numpy as np
from numpy.typing import NDArray

from ....math.arrays import Array, IntArray, Triple
from ....math.catalogue import Call, by_name, catalogue, dispatched
from ....math.compiled import jit
from . import __name__ as _package
from . import __path__ as _path
from .contract import FREEDOMS, Constraint, Coordinate, CouplingKind, Drive, Joint

_found = catalogue(_package, _path, Constraint)
JOINTS: dict[str, Joint] = by_name(
    [
        (joint.kind, joint)
        for joint in sorted(
            (c for c in _found if isinstance(c, Joint)), key=lambda joint: (joint.order, joint.kind)
        )
    ],
    "joint",
)
DRIVES: dict[str, Drive] = by_name([(c.kind, c) for c in _found if isinstance(c, Drive)], "drive")
_coupling_kinds = {c.kind: c for c in _found if isinstance(c, CouplingKind)}
COUPLED = {c.units: kind for kind, c in _coupling_kinds.items()}
CONSTRAINTS: dict[str, Constraint] = {**JOINTS, **DRIVES, **_coupling_kinds}

# A number holds within one process: models are built again in each.
NAMES = tuple(CONSTRAINTS)
KINDS = {name: number for number, name in enumerate(NAMES)}
ROWS = {name: constraint.units for name, constraint in CONSTRAINTS.items()}
RIGID = tuple(k for k, name in enumerate(NAMES) if len(CONSTRAINTS[name].removes) == len(FREEDOMS))
N_PARAMETER = max(len(joint.parameters) for joint in JOINTS.values())
COORDINATES: dict[str, Coordinate] = by_name(
    [(c.name, c) for c in dict.fromkeys(c for joint in JOINTS.values() for c in joint.coordinates)],
    "coordinate of joints",
)


def position_rows(joint_kind: IntArray) -> NDArray[np.bool_]:
    """Return a mask (n_c,) of the constraint rows with lengths [m]; `joint_kind` (nj,)."""
    units = "".join(ROWS[NAMES[kind]] for kind in joint_kind)
    return np.array([unit == "d" for unit in units], dtype=bool)


def _call(constraint: Constraint) -> Call:
    """Return the kernel and its arguments as those of `joint_rows`."""
    if isinstance(constraint, Joint):
        more = [f"parameters[{k}]" for k in range(len(constraint.parameters))]
    else:
        more = [f"law[{k}]" for k in range(3)] if isinstance(constraint, Drive) else []
    return constraint.rows, ["rows", "k", "one", "two", *more]


@jit
@dispatched("kind", [_call(constraint) for constraint in CONSTRAINTS.values()])
def joint_rows(
    rows: Array, k: int, kind: int, one: Array, two: Array, law: Triple, parameters: Array
) -> None:
    """Fill the rows of one joint, beginning at row k.

    `law` is that of a drive and its rates at the present time, `parameters` (N_PARAMETER,) the
    numbers of the joint; kinds that have none ignore them.

    Parameters
    ----------
    rows : rows of the constraints, to fill (rows.py)
    k : first row to fill
    kind : number of the kind (table.py)
    one : motion (24,) of marker one (dynamics/model/motion.py)
    two : motion (24,) of marker two
    law : value of a drive's law at the present time [rad or m], and its rates by time
    parameters : numbers of the joint (N_PARAMETER,)
    """
