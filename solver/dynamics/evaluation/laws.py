"""Values of the expressions of a model: measured quantities, auxiliary states, laws of time."""

import numpy as np

from ...math.arrays import Array, IntArray, Triple
from ...math.compiled import inlined, lean
from ...math.expressions.program import BY_TIME, NO_SEED, evaluated
from ...math.laws import N_COEFFICIENT, law_value
from ...math.rotations import cross3, dot3, minus3, sum3, times3
from ..model.model import (
    DISPLACEMENT,
    DISTANCE,
    HEIGHT,
    RIM,
    SLIP,
    SPHERES,
    SPIN,
    Model,
    Quantities,
)
from ..model.motion import acceleration, axis, place, spin, spin_rate, velocity
from ..tolerances import LAST_INSTANT, NO_DIRECTION, ONE_SAMPLE


@lean
def coordinate(
    kind: int, axes: IntArray, offset: float, one: Array, two: Array, g: Array
) -> tuple[float, float]:
    """Return value and rate of a coordinate, and fill its row g (12,).

    Parameters
    ----------
    kind : kind of the coordinate
    axes : numbers of the axes that it uses
    offset : radius of a contact [m]; else not used
    one : motion (24,) of marker one
    two : motion (24,) of marker two
    g : row (12,) by the velocities of both markers, to fill
    """
    e, n, arm = 0.0, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    turning, d = minus3(spin(two), spin(one)), minus3(place(two), place(one))
    if kind in (DISPLACEMENT, DISTANCE):
        if kind == DISPLACEMENT:
            n = axis(one, axes[0])
            e, arm = dot3(n, d), cross3(n, d)
        else:
            e = np.sqrt(dot3(d, d))
            n = times3(1.0 / e if e > NO_DIRECTION else 0.0, d)
        for j in range(3):
            g[j], g[3 + j], g[6 + j], g[9 + j] = -n[j], arm[j], n[j], 0.0
        moving = minus3(velocity(two), velocity(one))
        return e, dot3(n, moving) + dot3(arm, spin(one))
    if kind in (HEIGHT, SLIP):
        return of_contact(kind, axes, offset, one, two, g)
    if kind == SPIN:
        n = axis(one, axes[0])
    else:
        frame, pointer = (one, two) if axes[0] == 0 else (two, one)
        e, n = angle_of(frame, pointer, axes[1], axes[2], axes[3])
        if axes[0] == 1:
            n = times3(-1.0, n)
    for j in range(3):
        g[j], g[3 + j], g[6 + j], g[9 + j] = 0.0, -n[j], 0.0, n[j]
    return e, dot3(n, turning)


@inlined
def touch(axes: IntArray, radius: float, one: Array, two: Array) -> tuple[Triple, Triple]:
    """Return the normal of a contact, and the way from marker two to where it touches.

    A sphere about marker two on a sphere about marker one (axes[1] = SPHERES), on the plane through
    it across its axis z (PLANE), or the rim of a disc about axis z of marker two on this plane.

    Parameters
    ----------
    axes : numbers of the axes; axes[1] is the kind of contact
    radius : radius of the sphere or disc [m]
    one : motion (24,) of marker one
    two : motion (24,) of marker two
    """
    n = axis(one, 2)
    if axes[1] == SPHERES:
        d = minus3(place(two), place(one))
        length = np.sqrt(dot3(d, d))
        n = times3(1.0 / length if length > NO_DIRECTION else 0.0, d)
    up = n
    if axes[1] == RIM:
        a = axis(two, 2)
        up = minus3(n, times3(dot3(n, a), a))
        length = np.sqrt(dot3(up, up))
        up = times3(1.0 / length if length > NO_DIRECTION else 0.0, up)
    return n, times3(-radius, up)


@inlined
def of_contact(
    kind: int, axes: IntArray, radius: float, one: Array, two: Array, g: Array
) -> tuple[float, float]:
    """Return height and its rate of a rim, or 0 and a sliding velocity; fill the row g (12,).

    The sliding velocity is that along an axis of marker one, of which the part across the normal
    counts.

    Parameters
    ----------
    kind : HEIGHT or SLIP
    axes : numbers of the axes; axes[1] is the kind of contact
    radius : radius of the sphere or disc [m]
    one : motion (24,) of marker one
    two : motion (24,) of marker two
    g : row (12,) by the velocities of both markers, to fill
    """
    d = minus3(place(two), place(one))
    n, arm = touch(axes, radius, one, two)
    e, t = dot3(n, sum3(d, arm)), n
    if kind == SLIP:
        along = axis(one, axes[0])
        e, t = 0.0, minus3(along, times3(dot3(along, n), n))
    turn_1, turn_2 = cross3(sum3(d, arm), t), cross3(arm, t)
    for j in range(3):
        g[j], g[3 + j], g[6 + j], g[9 + j] = -t[j], -turn_1[j], t[j], turn_2[j]
    moving = dot3(t, minus3(velocity(two), velocity(one)))
    return e, moving + dot3(turn_2, spin(two)) - dot3(turn_1, spin(one))


@inlined
def angle_of(frame: Array, pointer: Array, i: int, j: int, k: int) -> tuple[float, Triple]:
    """Return the angle from axis i towards axis j of a marker to axis k of another, and n.

    From -pi to pi [rad]; its rate is n . (w_pointer - w_frame).

    Parameters
    ----------
    frame : motion (24,) of the marker with the reference axes
    pointer : motion (24,) of the marker with the axis that points
    i : axis of the frame at angle 0
    j : axis of the frame at 90 deg
    k : axis of the pointer
    """
    x, y, arm = axis(frame, i), axis(frame, j), axis(pointer, k)
    u, v = dot3(x, arm), dot3(y, arm)
    n = minus3(times3(u, cross3(arm, y)), times3(v, cross3(arm, x)))
    return np.arctan2(v, u), times3(1.0 / (u * u + v * v), n)


@lean
def acceleration_of(kind: int, axes: IntArray, one: Array, two: Array) -> float:
    """Return the second derivative of a coordinate at zero coordinate accelerations.

    Parameters
    ----------
    kind : kind of the coordinate
    axes : numbers of the axes that it uses
    one : motion (24,) of marker one
    two : motion (24,) of marker two
    """
    if kind in (DISPLACEMENT, DISTANCE):
        d, d_d = minus3(place(two), place(one)), minus3(velocity(two), velocity(one))
        d_dd = minus3(acceleration(two), acceleration(one))
        if kind == DISTANCE:
            e = np.sqrt(dot3(d, d))
            e_d = dot3(d, d_d) / e
            return (dot3(d, d_dd) + dot3(d_d, d_d) - e_d * e_d) / e
        n = axis(one, axes[0])
        n_d, n_dd = axis_rates(one, n)
        return dot3(n_dd, d) + 2.0 * dot3(n_d, d_d) + dot3(n, d_dd)
    frame, pointer = (one, two) if axes[0] == 0 else (two, one)
    x, y, a = axis(frame, axes[1]), axis(frame, axes[2]), axis(pointer, axes[3])
    x_d, x_dd = axis_rates(frame, x)
    y_d, y_dd = axis_rates(frame, y)
    a_d, a_dd = axis_rates(pointer, a)
    u, v = dot3(x, a), dot3(y, a)
    u_d, v_d = dot3(x_d, a) + dot3(x, a_d), dot3(y_d, a) + dot3(y, a_d)
    u_dd = dot3(x_dd, a) + 2.0 * dot3(x_d, a_d) + dot3(x, a_dd)
    v_dd = dot3(y_dd, a) + 2.0 * dot3(y_d, a_d) + dot3(y, a_dd)
    s = 1.0 / (u * u + v * v)
    rate = (u * v_d - v * u_d) * s
    return (u * v_dd - v * u_dd) * s - 2.0 * (u * u_d + v * v_d) * rate * s


@inlined
def axis_rates(motion: Array, n: Triple) -> tuple[Triple, Triple]:
    """Return first and second derivative of an axis of a marker."""
    w = spin(motion)
    n_d = cross3(w, n)
    return n_d, sum3(cross3(spin_rate(motion), n), cross3(w, n_d))


@inlined
def before_end(quantities: Quantities, t: float) -> float:
    """Return the time at which laws are read: at the end of a run, the instant before.

    No step follows that would see what begins there, such as the rest after a table.
    """
    margin = LAST_INSTANT * quantities.end
    return quantities.end - margin if abs(t - quantities.end) < margin else t


@lean
def measure(
    quantities: Quantities, motion: Array, y: Array, first: int, quantity: Array, g: Array
) -> None:
    """Fill quantity (2 nm + na,) and g (nm, 12) of state y; auxiliary states begin at `first`.

    `motion` (nk, 24) holds the markers.

    Parameters
    ----------
    quantities : what expressions read (model/model.py)
    motion : motions of all markers (nk, 24)
    y : state (n,), as in dynamics/model/model.py
    first : place of the auxiliary states in y
    quantity : values (2 nm + na,), to fill
    g : rows of the coordinates (nm, 12), to fill
    """
    n = quantities.kind.shape[0]
    for j in range(quantities.rate.shape[0]):
        quantity[2 * n + j] = y[first + j]
    for m in range(n):
        one, two = motion[quantities.marker[m, 0]], motion[quantities.marker[m, 1]]
        offset = quantities.offset[m]
        e, e_d = coordinate(quantities.kind[m], quantities.axes[m], offset, one, two, g[m])
        if quantities.kind[m] not in (HEIGHT, SLIP):
            e -= offset
        if quantities.turn[m] >= 0:
            e += 2.0 * np.pi * np.round((y[first + quantities.turn[m]] - e) / (2.0 * np.pi))
        quantity[2 * m], quantity[2 * m + 1] = e, e_d


@lean
def auxiliary_rate(
    quantities: Quantities, j: int, t: float, quantity: Array
) -> tuple[float, float]:
    """Return the rate of auxiliary state j, and its derivative by the state itself.

    Parameters
    ----------
    quantities : what expressions read (model/model.py)
    j : number of the auxiliary state
    t : time [s]
    quantity : values of the last evaluation
    """
    of, n = quantities.of_coordinate[j], quantities.kind.shape[0]
    if of >= 0:
        return quantity[2 * of + 1], 0.0
    if quantities.rate[j] < 0:
        return 0.0, 0.0
    terms = evaluated(
        quantities.programs,
        quantities.rate[j],
        before_end(quantities, t),
        quantity,
        2 * n + j,
        NO_SEED,
        quantities.stack,
    )
    return terms[0], terms[1]


@lean
def force_size(quantities: Quantities, k: int, t: float, quantity: Array, out: Array) -> None:
    """Fill out (3,) with the size of force element k, and its derivatives by its own coordinate
    and by the rate of that.

    Parameters
    ----------
    quantities : what expressions read (model/model.py)
    k : number of the force element
    t : time [s]
    quantity : values of the last evaluation
    out : size and its two derivatives (3,), to fill
    """
    along = quantities.along[k]
    first, second = (2 * along, 2 * along + 1) if along >= 0 else (NO_SEED, NO_SEED)
    terms = evaluated(
        quantities.programs,
        quantities.force[k],
        before_end(quantities, t),
        quantity,
        first,
        second,
        quantities.stack,
    )
    out[0], out[1], out[2] = terms[0], terms[1], terms[2]


@inlined
def law_of_time(quantities: Quantities, law: int, t: float) -> tuple[float, float, float]:
    """Return value, first and second derivative of an expression of the time alone.

    Parameters
    ----------
    quantities : expressions of the model
    law : number of the expression
    t : time [s]
    """
    none = quantities.offset
    terms = evaluated(quantities.programs, law, t, none, BY_TIME, NO_SEED, quantities.stack)
    return terms[0], terms[1], terms[3]


@inlined
def law_at(model: Model, law: int, t: float) -> tuple[float, float, float]:
    """Value and rates of a law at t; zeros where there is none.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    law : number of the law, below 0: none
    t : time [s]
    """
    if law < 0:
        return 0.0, 0.0, 0.0
    t = before_end(model.quantities, t)
    if model.quantities.law[law] >= 0:
        return law_of_time(model.quantities, model.quantities.law[law], t)
    return law_value(model.law_start, model.law_time, model.law_coefficient, law, t)


def law_values(model: Model, t: float) -> Array:
    """Return value, rate and acceleration of every law at t, (n_law, 3)."""
    n = len(model.law_start) - 1
    return np.array([law_at(model, k, t) for k in range(n)], dtype=float).reshape(n, 3)


def with_laws(model: Model, t: float, values: Array) -> Model:
    """Return the model with laws that have these values (n_law, 3) at t.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    t : time [s]
    values : value, rate and second rate of each law at t (n_law, 3)
    """
    n = len(values)
    coefficients = np.zeros((n, N_COEFFICIENT))
    coefficients[:, :3] = values * (1.0, 1.0, 0.5)
    return model._replace(
        law_start=np.arange(n + 1, dtype=np.int64),
        law_time=np.full(n, float(t)),
        law_coefficient=coefficients,
        quantities=model.quantities._replace(law=np.full(n, -1, dtype=np.int64)),
    )


@inlined
def is_sampled(period: float, t: float) -> bool:
    """Return whether a state of a period [s], 0 for none, is sampled at the instant t [s]."""
    return period > 0.0 and abs(t / period - np.round(t / period)) < ONE_SAMPLE
