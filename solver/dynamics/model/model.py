"""The model: all data that the step loop reads, as flat arrays.

assembly.py converts readable descriptions once to a `Model`;
the step loop uses no objects per body. Data of bodies are concatenated, with
offsets; markers and joints are tables, and point masses are part of their bodies. A body without
modes is rigid. The ground is body -1 and has no coordinates.

State: y = [positions | velocities | auxiliary states | work]
  positions of a body   r_G (3), p (4 Euler parameters), q (m)
  velocities of a body  rdot_G (3), w_B (3), qdot (m)
  auxiliary states      of controllers, friction, angles over many turns
  work                  done on the system by drives, dampers, actuators and loads [J]
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...math.arrays import Array
from ...math.compiled import structure
from ...math.expressions.program import Programs
from .plan import Plan

IntArray = NDArray[np.int64]

GROUND = -1
# Kinds of coordinates. `axes` of a DISPLACEMENT and SPIN: axis of marker one; of an ANGLE: marker
# with the axes x and y (0 or 1), x, y, and the axis `arm` of the other one (joints/contract.py).
DISPLACEMENT, ANGLE, DISTANCE, SPIN = 0, 1, 2, 3
# Sizes of the reaction of a joint on its second place, about its axis z: force across and along
# it, moment about that place across and along it.
RADIAL, AXIAL, BENDING, TWISTING = 0, 1, 2, 3
LAST = 1e-14  # of the time at the end of a run: so much earlier its laws are read


@structure
class Quantities(NamedTuple):
    """Coordinates (nm) and auxiliary states (na) of a model, and the expressions that read them.

    A coordinate is a scalar e of the relative motion of two markers, with a rate
    edot = g (v_1, w_1, v_2, w_2). An angle over many turns needs to know which one it is in: an
    auxiliary state that integrates edot tells it, to within half a turn (evaluation/measures.py).

    Expressions read, in this order: value and rate of each coordinate, the auxiliary states, the
    sizes of reactions.
    """

    kind: IntArray  # (nm,)
    marker: IntArray  # (nm, 2)
    axes: IntArray  # (nm, 4)
    offset: Array  # (nm,) subtracted from the value [m, rad]
    turn: IntArray  # (nm,) auxiliary state that follows an angle; -1: none
    rate: IntArray  # (na,) expression of the rate of an auxiliary state; -1: constant
    of_coordinate: IntArray  # (na,) coordinate that it follows; -1: none
    start: Array  # (na,) value at the start: of angles about which it is looked for,
    start_expression: IntArray  # (na,) of others by an expression; -1: none
    update: IntArray  # (na,) expression of the value from an instant on; -1: none
    period: Array  # (na,) time between these instants, from t = 0 on [s]
    called: IntArray  # (n,) states with values of functions outside of the model, and
    call_start: IntArray  # (n + 1,) the first expression of the inputs of each
    scale: Array  # (na,) size, for the tolerance of its error; inf: none
    programs: Programs
    law: IntArray  # (nl,) expression that a law of time is; -1: it has pieces
    force: IntArray  # (nf,) expression of the size of a force element; -1: a law
    along: IntArray  # (nf,) coordinate along which a force element acts; -1: its own
    coupled_force: IntArray  # (nc,) force elements along a coordinate that read states,
    coupled_state: IntArray  # (nc,) and which
    coupling_start: IntArray  # (n + 1,) first term of each coupling of coordinates
    coupling_coordinate: IntArray  # (n_term,)
    coupling_ratio: Array  # (n_term,)
    reaction_joint: IntArray  # (nr,) joint of each size of a reaction,
    reaction_kind: IntArray  # (nr,) and which
    reacting: IntArray  # (k,) force elements along a coordinate whose size reads them
    feedback: IntArray  # (r,) force elements that read other coordinates than their own, reactions
    fed_row: IntArray  # (n,) pairs: of `feedback`, or behind them of `coupled_state`,
    fed_coordinate: IntArray  # (n,) and a coordinate that it reads and that is not the force's own
    event_state: IntArray  # (ne,) states that take their `update` when a coordinate
    event_coordinate: IntArray  # (ne,)
    event_level: Array  # (ne,) passes a level [m, rad]
    event_sign: Array  # (ne,) upwards (1) or downwards (-1)
    end: float  # of the run, where laws have the values of the instant before [s]; inf: none
    stack: Array  # memory of an evaluation


@structure
class Model(NamedTuple):
    """Arrays of one mechanism; built by assembly.py, read by evaluation.py."""

    n_body: int  # nb, moving bodies
    n_pos: int  # position coordinates
    n_vel: int  # velocity coordinates
    n_constraint: int  # constraint equations
    # bodies (nb); mode_start and square_start have nb + 1 entries
    n_mode: IntArray  # modes of each body
    pos_start: IntArray  # first position coordinate
    vel_start: IntArray  # first velocity coordinate
    mode_start: IntArray  # running sum of n_mode
    square_start: IntArray  # running sum of n_mode squared
    mass: Array  # (nb,)                     [kg]
    S0: Array  # (nb, 3)                     [kg m]
    T00: Array  # (nb, 3, 3)                 [kg m2]
    J0: Array  # (nb, 3, 3)                  [kg m2]
    S: Array  # flat (3, m) per body         [kg m]
    T01: Array  # flat (9, m) per body       [kg m2]
    T11: Array  # flat (9 m, m) per body     [kg m2]
    J_psi: Array  # flat (3, m) per body     [kg m2]
    M_qq: Array  # flat (m, m) per body
    K_qq: Array  # flat (m, m) per body
    D_qq: Array  # flat (m, m) per body
    gravity_G: Array  # (3,)                 [m/s2]
    # markers (nk): frames fixed to a body's interface or to the ground
    marker_body: IntArray
    marker_x: Array  # (nk, 3) rest position, body (ground: global) components [m]
    marker_A: Array  # (nk, 3, 3) marker axes to body axes
    marker_start: IntArray  # (nk,) start of its rows in marker_phi
    marker_phi: Array  # flat (3, m) per marker
    marker_psi: Array  # flat (3, m) per marker
    # joints (nj): constraint rows joint_row[j] .. joint_row[j + 1]
    joint_kind: IntArray
    joint_marker: IntArray  # (nj, 2)
    joint_row: IntArray  # (nj + 1,)
    joint_law: IntArray  # (nj,) of a drive; -1: none
    joint_parameters: Array  # (nj, N_PARAMETER), see joints/table.py
    # force elements (nf)
    force_kind: IntArray
    force_marker: IntArray  # (nf, 2)
    force_law: IntArray  # (nf,) of an actuator or load; -1: none
    force_parameters: Array  # (nf, N_PARAMETER)
    # laws of time (nl): pieces law_start[l] .. law_start[l + 1]
    law_start: IntArray  # (nl + 1,)
    law_time: Array  # (n_piece,)                         [s]
    law_coefficient: Array  # (n_piece, N_COEFFICIENT)
    # constraint treatment (dynamics/elements/constraints/treatment.py)
    inertia_scale: Array  # (n_vel,) inertia of each velocity coordinate, for scaling only
    redundant: int  # number of redundant constraint equations
    alpha: float  # feedback of velocity violations, Eq. (13)   [1/s]
    beta: float  # of position violations                      [1/s]
    penalty: float  # of the augmented Lagrangian, times each row's mass; 0: none
    multiplier_tolerance: float  # of its iteration, relative
    multiplier_iterations: int  # at most
    pair_used: NDArray[np.int8]  # (nb, 9) which pairs 3 a + b of T01 and T11 do not vanish
    added_inertia: Array  # (n_a,) what bodies without inertia of their own get  [kg, kg m2]
    added_direction: Array  # (n_a, widest) and where: rdot_G, w_B, qdot (bodies/added_inertia.py)
    plan: Plan  # structure of the linear algebra
    # geometric stiffening (dynamics/elements/bodies/second_order.py): empty for linear bodies
    second_start: IntArray  # (nb + 1,) running sum of n_mode squared of stiffened bodies
    third_start: IntArray  # (nb + 1,) the same cubed
    fourth_start: IntArray  # (nb + 1,) to the fourth
    Z: Array  # flat (12 m, m) per body: Z0 (3, m), Z1 (3, 3, m)   [kg m, kg m2]
    Z_used: NDArray[np.int8]  # (nb, 12) which tables (m, m) of them are not zero
    G3: Array  # flat (m, m m) per body        [kg m2]
    G4: Array  # flat (m m m, m) per body, rows i, j, l and columns k of G4_ij,kl -> ik,jl [kg m2]
    marker_second: IntArray  # (nk,) start of its tables in marker_H; -1: a linear marker
    marker_H: Array  # flat (6 m, m) per marker: translation (3, m), rotation (3, m)
    marker_H_used: NDArray[np.int8]  # (nk, 6) which tables (m, m) of them are not zero
    carried_start: IntArray  # (nb + 1,) point masses with second-order motion, body by body
    carried_marker: IntArray
    carried_mass: Array  # [kg]
    n_aux: int  # auxiliary states
    quantities: Quantities  # what expressions read, and the expressions


def state_size(model: Model) -> int:
    """Return the length of the state y."""
    return model.n_pos + model.n_vel + model.n_aux + 1
