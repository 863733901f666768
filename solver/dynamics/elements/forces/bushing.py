"""Bushing: springs and dampers on all six relative motions of two markers."""

from collections.abc import Sequence

from ....math.arrays import Array
from ....math.compiled import jit
from ....math.rotations import cross3, dot3, minus3, moment_of_gradient, triple, vector_of
from ...model.motion import axis, from_axes, in_axes, place, velocity
from ...model.motion import spin as spin_of
from .contract import DAMPING, FORCE, STIFFNESS, Direction, Element, Three, Wrench


@jit
def bushing(one: Array, two: Array, parameters: Array, law: float) -> Wrench:
    """Forces against the place and rotation of marker two in the axes of marker one.

    Stiffness (6,) along x, y, z, about x, y, z, and damping (6,) [N/m, N m/rad; N s/m, N m s/rad].
    The rotation is taken as a vector theta up to half a turn; its moments T^-T k theta are those
    of the energy theta' k theta / 2, so that nothing is lost at large angles.

    Parameters
    ----------
    one : motion (24,) of marker one (dynamics/model/motion.py)
    two : motion (24,) of marker two
    parameters : stiffness (6,) and damping (6,) along and about x, y, z
    law : not used
    """
    stiffness, damping = parameters[:6], parameters[6:12]
    d = minus3(place(two), place(one))
    turning = spin_of(one)
    offset = in_axes(one, d)
    speed = in_axes(one, minus3(minus3(velocity(two), velocity(one)), cross3(turning, d)))
    x, y, z = in_axes(one, axis(two, 0)), in_axes(one, axis(two, 1)), in_axes(one, axis(two, 2))
    theta = vector_of(x, y, z)
    spin = in_axes(one, minus3(spin_of(two), turning))
    k, c = triple(stiffness[:3]), triple(damping[:3])
    k_t, c_t = triple(stiffness[3:]), triple(damping[3:])
    gradient = (k_t[0] * theta[0], k_t[1] * theta[1], k_t[2] * theta[2])
    t = moment_of_gradient(theta, gradient)
    force = (
        -k[0] * offset[0] - c[0] * speed[0],
        -k[1] * offset[1] - c[1] * speed[1],
        -k[2] * offset[2] - c[2] * speed[2],
    )
    lost = (c_t[0] * spin[0], c_t[1] * spin[1], c_t[2] * spin[2])
    moment = (-t[0] - lost[0], -t[1] - lost[1], -t[2] - lost[2])
    potential, power = 0.0, -dot3(spin, lost)
    for i in range(3):
        potential += 0.5 * stiffness[i] * offset[i] ** 2 + 0.5 * stiffness[3 + i] * theta[i] ** 2
        power -= damping[i] * speed[i] ** 2
    return Wrench(from_axes(one, force), from_axes(one, moment), potential, power)


@jit
def bushing_rows(one: Array, two: Array, parameters: Array, rows: Array) -> None:
    """Rows 0 to 2: along the axes of marker one. Rows 3 to 5: rates of the rotation vector theta.

    thetadot = T^-1 (w_2 - w_1). A damper sees w_2 - w_1 itself: beside a spring it takes the
    spring's row, which is the same at small angles; alone it has a row of its own.

    Parameters
    ----------
    one : motion (24,) of marker one (dynamics/model/motion.py)
    two : motion (24,) of marker two
    parameters : stiffness (6,) and damping (6,) along and about x, y, z
    rows : rows (MOST_ROWS, N_ELEMENT_ROW) for Newton's matrix, to fill
    """
    d = minus3(place(two), place(one))
    speed = minus3(minus3(velocity(two), velocity(one)), cross3(spin_of(one), d))
    turning = minus3(spin_of(two), spin_of(one))
    x, y, z = in_axes(one, axis(two, 0)), in_axes(one, axis(two, 1)), in_axes(one, axis(two, 2))
    theta = vector_of(x, y, z)
    for i in range(3):
        a = axis(one, i)
        n = cross3(a, d)
        k, c = parameters[i], parameters[6 + i]
        for j in range(3):
            rows[i, j], rows[i, 3 + j] = -a[j], n[j]
            rows[i, 6 + j], rows[i, 9 + j] = a[j], 0.0
        rows[i, STIFFNESS], rows[i, DAMPING] = k, c
        rows[i, FORCE] = k * dot3(a, d) + c * dot3(a, speed)
        k, c = parameters[3 + i], parameters[9 + i]
        if k > 0.0:
            e = (1.0 if i == 0 else 0.0, 1.0 if i == 1 else 0.0, 1.0 if i == 2 else 0.0)
            a = from_axes(one, moment_of_gradient(theta, e))
        for j in range(3):
            rows[3 + i, j] = rows[3 + i, 6 + j] = 0.0
            rows[3 + i, 3 + j], rows[3 + i, 9 + j] = -a[j], a[j]
        rows[3 + i, STIFFNESS], rows[3 + i, DAMPING] = k, c
        rows[3 + i, FORCE] = k * theta[i] + c * dot3(a, turning)


def _rows_in_use(parameters: Sequence[float]) -> list[int]:
    return [i for i in range(6) if parameters[i] or parameters[6 + i]]


ELEMENT = Element(
    kind="bushing",
    meaning="springs and dampers on all six relative motions",
    remark="At rest where the two places coincide with the axes of the given starting position.",
    keys=(
        Direction("axis", "third axis at the start, global; fixed in the first place"),
        Direction(
            "axis_1",
            "first axis, at a right angle to `axis`; absent: the global axis farthest from "
            "`axis`, made orthogonal",
            absent=True,
        ),
        Three("stiffness", "N/m", "along the three axes", required=True),
        Three("rotary_stiffness", "N m/rad", "about the three axes"),
        Three("damping", "N s/m", "along the three axes"),
        Three("rotary_damping", "N m s/rad", "about the three axes"),
    ),
    wrench=bushing,
    rows=bushing_rows,
    most_rows=6,
    rows_in_use=_rows_in_use,
    order=3,
)
