"""The axis about which a mechanism spins: given in the case, or that of its hub joint."""

from typing import TYPE_CHECKING

import numpy as np

from ..dynamics.joints.table import DRIVES, JOINTS, NAMES
from ..dynamics.model import GROUND
from ..dynamics.spinning import Spin
from ..errors import InputError, few
from ..math.arrays import Array
from .build import BuiltMechanism

if TYPE_CHECKING:
    from ..inputs.case.solver import Solver

_ABOUT = "about z"  # freedom that a spin needs, in the axes of a joint
_HELD = {"x", "y", "about x", "about y"}  # freedoms that fix its axis


def given_spin(solver: "Solver") -> Spin | None:
    """Return the spin of `[solver]`, if it has one."""
    if solver.spin is None:
        return None
    return spin_about(solver.spin.axis, solver.spin.point, solver.spin.speed)


def spin_about(axis: Array | list[float], point: Array | list[float], rate: float) -> Spin:
    """Return a spin about a line; `axis` of any length."""
    direction = np.array(axis, dtype=float)
    return Spin(direction / np.linalg.norm(direction), np.array(point, dtype=float), float(rate))


def hub_axis(built: BuiltMechanism) -> tuple[Array, Array]:
    """Return the axis (3,) and a point of it: of the driven hinge to the ground, or the only hinge.

    Raises
    ------
    InputError
        There is none, or more than one.
    """
    driven, free = _hinges(built)
    found = driven or free
    lines = list(found.values())
    first = lines[0] if lines else None
    if first is not None and all(_same(first, line) for line in lines[1:]):
        return first
    if first is None:
        why = "no hinge connects a body to the ground"
    else:
        why = f"the joints {few(found)} to the ground have different axes"
    raise InputError(
        f"the axis of the spin is missing: {why}. Expected --axis X,Y,Z, or "
        "solver.spin = { axis = [X, Y, Z] } in the case"
    )


def _hinges(built: BuiltMechanism) -> tuple[dict[str, tuple[Array, Array]], ...]:
    """Return the lines of hinges to the ground by joint: those with a drive, all."""
    model = built.model
    driven: dict[str, tuple[Array, Array]] = {}
    free: dict[str, tuple[Array, Array]] = {}
    for name, joint in built.joints.items():
        pair = [int(k) for k in model.joint_marker[joint.rows[0]]]
        ground = [k for k in pair if model.marker_body[k] == GROUND]
        removes = set(JOINTS[joint.kind].removes)
        if _ABOUT in removes or not removes >= _HELD or len(ground) != 1:
            continue
        line = model.marker_A[ground[0]][:, 2].copy(), model.marker_x[ground[0]].copy()
        free[name] = line
        drives = [DRIVES[NAMES[model.joint_kind[row]]] for row in joint.rows[1:]]
        if any(_ABOUT in drive.removes for drive in drives):
            driven[name] = line
    return driven, free


def _same(one: tuple[Array, Array], two: tuple[Array, Array]) -> bool:
    away = two[1] - one[1]
    parallel = np.linalg.norm(np.cross(one[0], two[0])) < 1e-9
    return bool(parallel and np.linalg.norm(np.cross(one[0], away)) < 1e-9)
