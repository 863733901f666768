"""Aerodynamic loads on the blade sections of a rotor: blade element momentum theory.

A section (a strip of a blade) is a load on its marker: x along the blade, y to the leading edge, z
to the suction side. Marker one of the load is that of the hub, z along the shaft. Each section has
seven auxiliary states:

- two stages of the induced velocity, along the shaft and tangential: dynamic inflow by Oye's filter
  (H. Snel and J. G. Schepers, Joint investigation of dynamic inflow effects, ECN-C--94-107, 1995;
  as states in E. Branlard et al., J. Phys.: Conf. Ser. 2265 (2022) 032044);
- the separation point: dynamic stall by Oye's model (M. H. Hansen et al., Riso-R-1354, 2004,
  section 3.1.1, M. O. L. Hansen, Aerodynamics of Wind Turbines, 2nd ed. (2008), section 9.3);
- two of the wake that a section sheds: lift of attached flow follows the angle of attack at three
  quarters of the chord by Jones' indicial function (R. T. Jones, NACA Report 681, 1940; as states
  in Riso-R-1354, section 2). Lift and moment of the pitch rate are there besides: pi T alpha' and
  -pi/2 T alpha', T = c / 2V. Without these, torsion of long blades flutters.

The induced velocity of momentum theory follows from the loads in the present state, so that
nothing is iterated: at rest of the states it is the solution of the usual equations, with Prandtl's
losses at tip and root and Buhl's relation of high thrust (A. Ning, Wind Energy 17 (2014) 1327), or
by the polynomial of HAWC2 (H. A. Madsen et al., Wind Energ. Sci. 5 (2020) 1).
Skewed inflow takes the factor of Pitt and Peters.
"""

import numpy as np

from ...math.arrays import Array, Triple
from ...math.compiled import inlined, lean
from ...math.rotations import cross3, dot3, minus3, sum3, times3
from ..elements.forces.contract import Wrench
from ..model.model import (
    AIR_DENSITY,
    ANGLE_STEP,
    BLADES,
    CHORD,
    DIRECTION,
    MOMENT,
    N_FLOW,
    N_SECTION_STATE,
    OFFSET,
    POLYNOMIAL,
    QUASI,
    RADIUS,
    REFERENCE_HEIGHT,
    ROOT_GAP,
    SEPARATION,
    SHEAR,
    SPAN,
    STALLED,
    TIP_GAP,
    UP,
    WIDTH,
    Model,
    Workspace,
)
from ..model.motion import axis, place, spin, velocity
from ..tolerances import INFLOW_FOUND, LEAST_FLOW, LEAST_LOSS, LEAST_RADIUS, LEAST_SINE, LEAST_WIND

MOST_INDUCTION = 0.95  # of the wind: beyond it, flow reverses in the wake
BUHL = 0.96  # thrust coefficient over the loss from which on Buhl's relation holds: a = 0.4
MADSEN = (0.2460, 0.0586, 0.0883)  # of induction over thrust
QUASI_SHARE = 0.6  # k of Oye's filter
A_1, A_2, B_1, B_2 = 0.165, 0.335, 0.0455, 0.3  # of the indicial function
LIFT, DRAG = 0, 1  # columns of a polar, before those of model.py


@lean
def wind_into(model: Model, work: Workspace, speed: float, turned: float) -> None:
    """Fill work.wind (3,) with a wind at the reference height, turned about `up`, global [m/s].

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    work : memory of one evaluation
    speed : wind speed at the reference height [m/s]
    turned : turn of its direction about `up` [rad]
    """
    rotor = model.rotor
    c, s = np.cos(turned), np.sin(turned)
    up, along = _three(rotor.numbers, UP), _three(rotor.numbers, DIRECTION)
    side = cross3(up, along)
    for i in range(3):
        work.wind[i] = speed * (c * along[i] + s * side[i])


@inlined
def _three(numbers: Array, first: int) -> Triple:
    return numbers[first], numbers[first + 1], numbers[first + 2]


@inlined
def wind_at(model: Model, work: Workspace, x: Triple) -> Triple:
    """Return the wind at a point: by height, a power law [m/s].

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    work : memory of one evaluation
    x : point, global [m]
    """
    numbers, share = model.rotor.numbers, 1.0
    if numbers[SHEAR] != 0.0:
        height = max(dot3(_three(numbers, UP), x), 0.0) / numbers[REFERENCE_HEIGHT]
        share = height ** numbers[SHEAR]
    return times3(share, _three(work.wind, 0))


@lean
def section_wrench(model: Model, work: Workspace, k: int, s: int) -> Wrench:
    """Wrench of section s, force element k; fills work.flow[s] with the rates of its states.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    work : memory of one evaluation
    k : number of the force element
    s : number of the section
    """
    rotor, numbers, shape = model.rotor, model.rotor.numbers, model.rotor.shape[s]
    hub, at = work.motion[model.force_marker[k, 0]], work.motion[model.force_marker[k, 1]]
    first = 2 * model.quantities.kind.shape[0] + rotor.state + N_SECTION_STATE * s
    n = axis(hub, 2)
    out = minus3(place(at), place(hub))
    out = minus3(out, times3(dot3(out, n), n))
    r = max(np.sqrt(dot3(out, out)), LEAST_RADIUS)
    out = times3(1.0 / r, out)
    t = cross3(n, out)
    lever = times3(shape[OFFSET], axis(at, 1))
    wind = wind_at(model, work, place(at))
    moving = sum3(velocity(at), cross3(spin(at), lever))
    v = dot3(minus3(wind, velocity(hub)), n)
    if abs(v) < LEAST_WIND:
        v = LEAST_WIND if v >= 0.0 else -LEAST_WIND
    w_n, w_t = work.quantity[first + 2], work.quantity[first + 3]
    skewed = w_n * _skew(wind, n, out, min(max(-w_n / v, 0.0), 0.5), r / numbers[RADIUS])
    flow = sum3(minus3(wind, moving), sum3(times3(skewed, n), times3(w_t, t)))
    forward, up = -dot3(flow, axis(at, 1)), dot3(flow, axis(at, 2))
    speed = max(np.sqrt(forward * forward + up * up), LEAST_FLOW)
    # the angle at three quarters of the chord, behind which that of the polar lags by the wake
    turn_rate = dot3(spin(at), axis(at, 0))
    behind = up + 0.5 * shape[CHORD] * turn_rate
    share = behind / np.sqrt(forward * forward + behind * behind + LEAST_FLOW**2)
    slow_down = 2.0 * speed / shape[CHORD]
    for i in range(2):
        b, part = (B_1, A_1 * share) if i == 0 else (B_2, A_2 * share)
        work.flow[s, 5 + i] = b * slow_down * (part - work.quantity[first + 5 + i])
        work.flow[s, STALLED + 1 + i] = part
    lag = work.quantity[first + 5] + work.quantity[first + 6] - (A_1 + A_2) * share
    lag *= max(forward / speed, 0.0)
    # the polar, and the lift of a separation point that lags behind
    angle = np.arctan2(behind, forward) + lag
    x = min(max((angle + np.pi) / ANGLE_STEP, 0.0), rotor.polars.shape[1] - 1.0)
    i = min(int(x), rotor.polars.shape[1] - 2)
    x -= i
    low, high = rotor.polars[rotor.polar[s], i], rotor.polars[rotor.polar[s], i + 1]
    still = low[SEPARATION] + x * (high[SEPARATION] - low[SEPARATION])
    lift = low[LIFT] + x * (high[LIFT] - low[LIFT])
    lift += (work.quantity[first + 4] - still) * (low[SPAN] + x * (high[SPAN] - low[SPAN]))
    drag = low[DRAG] + x * (high[DRAG] - low[DRAG])
    drag -= lag * lift  # across the flow that the wake turns
    moment = low[MOMENT] + x * (high[MOMENT] - low[MOMENT])
    lift += np.pi * turn_rate / slow_down
    moment -= 0.5 * np.pi * turn_rate / slow_down
    q = 0.5 * numbers[AIR_DENSITY] * speed * shape[CHORD]
    ahead = q * (lift * up - drag * forward)
    across = q * (lift * forward + drag * up)
    force = sum3(times3(ahead, axis(at, 1)), times3(across, axis(at, 2)))
    _rates(model, work, s, first, force, flow, n, t, dot3(axis(at, 0), out), v, r)
    work.flow[s, 4] = (still - work.quantity[first + 4]) * speed / (4.0 * shape[CHORD])
    work.flow[s, STALLED] = still
    force = times3(shape[WIDTH], force)
    twist = times3(shape[WIDTH] * q * speed * shape[CHORD] * moment, axis(at, 0))
    turn = sum3(twist, cross3(lever, force))
    return Wrench(force, turn, 0.0, dot3(force, velocity(at)) + dot3(turn, spin(at)))


@inlined
def _skew(wind: Triple, n: Triple, out: Triple, a: float, share: float) -> float:
    """Factor on the axial induction at a section: larger on the side to which the wake goes."""
    along = dot3(wind, n)
    aside = minus3(wind, times3(along, n))
    size = np.sqrt(dot3(aside, aside))
    if size == 0.0:
        return 1.0
    wake = min((0.6 * a + 1.0) * np.arctan2(size, abs(along)), 0.45 * np.pi)
    return 1.0 + 15.0 * np.pi / 32.0 * np.tan(0.5 * wake) * share * dot3(out, aside) / size


@inlined
def _rates(
    model: Model,
    work: Workspace,
    s: int,
    first: int,
    force: Triple,
    flow: Triple,
    n: Triple,
    t: Triple,
    slope: float,
    v: float,
    r: float,
) -> None:
    """Fill rates of the induced velocity and its value by momentum theory, of a force per length.

    slope : radius over length of the blade; v : wind along the shaft [m/s]
    """
    numbers, shape = model.rotor.numbers, model.rotor.shape[s]
    across, around = dot3(flow, n), dot3(flow, t)
    sine = abs(across) / max(np.sqrt(across * across + around * around), LEAST_FLOW)
    half = 0.5 * numbers[BLADES] / max(sine, LEAST_SINE)
    loss = np.arccos(np.exp(-half * shape[TIP_GAP])) * np.arccos(np.exp(-half * shape[ROOT_GAP]))
    loss = max(loss * (2.0 / np.pi) ** 2, LEAST_LOSS)
    # thrust of the ring over its dynamic pressure: 1/2 rho v^2 2 pi r
    ring = numbers[BLADES] / (max(slope, 0.1) * np.pi * numbers[AIR_DENSITY] * r * abs(v))
    thrust = ring * dot3(force, n) / v
    if numbers[POLYNOMIAL] > 0.0:
        c = thrust / loss
        a = c * (MADSEN[0] + c * (MADSEN[1] + c * MADSEN[2]))
    elif thrust < BUHL * loss:
        a = 0.5 * (1.0 - np.sqrt(1.0 - thrust / loss))
    else:
        root = np.sqrt(thrust * (50.0 - 36.0 * loss) + 12.0 * loss * (3.0 * loss - 4.0))
        a = (18.0 * loss - 20.0 - 3.0 * root) / (36.0 * loss - 50.0)
    a = min(a, MOST_INDUCTION)
    quasi_n, quasi_t = -a * v, -0.25 * ring * dot3(force, t) / (loss * (1.0 - a))
    slow = 1.1 * numbers[RADIUS] / (abs(v) * (1.0 - 1.3 * min(max(a, 0.0), 0.5)))
    fast = slow * (0.39 - 0.26 * min(r / numbers[RADIUS], 1.0) ** 2)
    for i in range(2):
        quasi = quasi_n if i == 0 else quasi_t
        stage, induced = work.quantity[first + i], work.quantity[first + 2 + i]
        work.flow[s, i] = ((1.0 - QUASI_SHARE) * quasi - stage) / slow
        work.flow[s, 2 + i] = (stage + QUASI_SHARE * quasi - induced) / fast
        work.flow[s, QUASI + i] = quasi


@inlined
def section_rates_into(model: Model, work: Workspace, out: Array) -> None:
    """Fill the rates of the sections' states in out (n,), after an evaluation.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    work : memory of one evaluation
    out : dy/dt (n,), filled at the states of the sections
    """
    first = model.n_pos + model.n_vel + model.rotor.state
    for s in range(model.rotor.polar.shape[0]):
        for i in range(N_SECTION_STATE):
            out[first + N_SECTION_STATE * s + i] = work.flow[s, i]


RELAXATION, PASSES = 0.1, 400  # of the inflow at rest


def move_inflow(model: Model, flow: Array, y: Array) -> bool:
    """Move the sections' states in y towards steady inflow; return whether they are at rest.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    flow : flow of the last evaluation (ns, N_FLOW)
    y : state (n,), as in dynamics/model/model.py
    """
    first = model.n_pos + model.n_vel + model.rotor.state
    states = y[first : first + N_SECTION_STATE * len(flow)].reshape(-1, N_SECTION_STATE)
    goal = flow[:, QUASI:N_FLOW]
    gap = goal - states[:, 2:]
    states[:, 2:] += RELAXATION * gap
    states[:, :2] = (1.0 - QUASI_SHARE) * states[:, 2:4]
    return bool(
        np.abs(gap).max(initial=0.0) <= INFLOW_FOUND * (1.0 + np.abs(goal).max(initial=0.0))
    )
