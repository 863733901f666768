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

`Workspace` is the memory of one evaluation: allocated once, filled every time.
"""

from typing import Annotated, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...math.arrays import Array, zeros_of
from ...math.compiled import lean, structure
from ...math.expressions.operations import Programs
from .layout import Layout, RowOrder
from .motion import N_ELEMENT_ROW, N_MOTION, stand

IntArray = NDArray[np.int64]

GROUND = -1
# Kinds of coordinates. `axes` of a DISPLACEMENT and SPIN: axis of marker one; of an ANGLE: marker
# with the axes x and y (0 or 1), x, y, and the axis `arm` of the other one (joints/contract.py).
# Of a HEIGHT and SLIP of a contact: axis of marker one, and what touches; `offset` is its radius.
DISPLACEMENT, ANGLE, DISTANCE, SPIN, HEIGHT, SLIP = 0, 1, 2, 3, 4, 5
SPHERES, PLANE, RIM = 0, 1, 2
# Sizes of the reaction of a joint on its second place, about its axis z: force across and along
# it, moment about that place across and along it.
RADIAL, AXIAL, BENDING, TWISTING = 0, 1, 2, 3


@structure
class Quantities(NamedTuple):
    """Coordinates (nm) and auxiliary states (na) of a model, and the expressions that read them.

    A coordinate is a scalar e of the relative motion of two markers, with a rate
    edot = g (v_1, w_1, v_2, w_2). An angle over many turns needs to know which one it is in: an
    auxiliary state that integrates edot gives it, to within half a turn (evaluation/laws.py).

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


# Numbers of a section of a blade, of a polar behind lift and drag, and of a rotor.
CHORD, WIDTH, OFFSET, TIP_GAP, ROOT_GAP = 0, 1, 2, 3, 4
N_SHAPE = 5
MOMENT, SEPARATION, SPAN = 2, 3, 4
N_POLAR = 5
AIR_DENSITY, BLADES, RADIUS, SHEAR, REFERENCE_HEIGHT, UP, DIRECTION = 0, 1, 2, 3, 4, 5, 8
POLYNOMIAL, N_ROTOR = 11, 12
ANGLE_STEP = np.pi / 360.0  # of polars [rad]
# What a section computes: rates of its states, then what these go to at rest.
N_SECTION_STATE, QUASI, STALLED, N_FLOW = 7, 7, 9, 12


@structure
class Rotor(NamedTuple):
    """The sections (ns) of the blades of a rotor in the wind (evaluation/rotor.py); none: ns = 0.

    Each section is a force element, a load at its marker two; marker one is that of the hub.
    """

    section: IntArray  # (nf,) section that a force element is; -1: another element
    polar: IntArray  # (ns,)
    # (ns, N_SHAPE): chord, width [m]; aerodynamic centre ahead of the marker [m]; distances to tip
    # over radius and to root over radius of the root, at rest
    shape: Array
    # (n, n_angle, N_POLAR) from -pi to pi: coefficients of lift, drag and moment, separation point
    # (1: attached), and lift of attached flow less that of separated flow
    polars: Array
    # (N_ROTOR,): air density [kg/m3], number of blades, radius [m], exponent of shear, its height
    # [m], unit vectors upwards and along the wind, global; 1: induction by Madsen's polynomial
    numbers: Array
    law: IntArray  # (2,) of the speed of the wind [m/s], and of its turn about `up` [rad]
    state: int  # first auxiliary state


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
    layout: Layout  # structure of the linear algebra
    # geometric stiffening (dynamics/elements/floating_frame.py): empty for linear bodies
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
    # (nb + 1,) point masses and pieces of bodies with second-order motion, body by body
    carried_start: IntArray
    carried_marker: IntArray
    carried_mass: Array  # [kg]
    carried_whole: NDArray[np.int8]  # 1 of a point mass, 0 of a piece
    n_aux: int  # auxiliary states
    quantities: Quantities  # what expressions read, and the expressions
    rotor: Rotor


def state_size(model: Model) -> int:
    """Return the length of the state y."""
    return model.n_pos + model.n_vel + model.n_aux + 1


# A constraint row: coefficients C of v_1, w_1, v_2, w_2 in global components, then these.
PHI, PHI_T, GAMMA = 12, 13, 14
N_ROW = 15


@structure
class Factors(NamedTuple):
    """Bodies eliminated from [K Phi_q'; Phi_q 0], K of one block per body (elimination.py)."""

    L: Annotated[Array, "nb, n, n"]  # unit lower triangles of each body's block
    pivot: Annotated[Array, "nb, n"]  # reciprocals of the diagonal
    W: Annotated[Array, "nb, n, r"]  # L^-T Phi_q'
    P: Annotated[Array, "nb, 7, 6"]  # factors of the rows that drive a frame, and their order
    S: Annotated[Array, "profile"]  # of Phi_q K^-1 Phi_q', then its unit lower triangle
    S_pivot: Annotated[Array, "n_p"]  # reciprocals of its diagonal
    regular: Array  # (1,) least pivot over its diagonal entry before elimination
    z: Annotated[Array, "nb, n"]
    mu: Annotated[Array, "n_p"]  # in the order of elimination


@structure
class Workspace(NamedTuple):
    """Arrays that an evaluation fills; arrays of bodies have the size of the largest body."""

    A: Annotated[Array, "nb, 3, 3"]  # rotation matrices A_GB
    M: Annotated[Array, "nb, n, n"]  # mass matrices, lower triangles
    f: Annotated[Array, "nb, n"]  # loads, quadratic velocity terms, elastic and damping forces
    J: Annotated[Array, "nb, n, r"]  # Jacobian of the rows of layout.mass at each body, transposed
    # of dampers, actuators and loads [W]; energy in force elements [J]
    power: Annotated[Array, "2"]
    rows: Annotated[Array, "n_c, row"]  # of the constraints, laid out as above
    # markers (nk)
    motion: Annotated[Array, "nk, motion"]  # (dynamics/model/motion.py)
    J_m: Annotated[Array, "nk, 6, n"]  # Jacobians of velocity and angular velocity
    # of one body at a time
    D: Annotated[Array, "9, m"]
    R: Annotated[Array, "9, m"]
    B: Annotated[Array, "3, 3"]
    P: Annotated[Array, "3, 3"]
    # solution
    factors: Factors  # of the mass matrix
    load: Annotated[Array, "nb, n"]  # right-hand side
    acceleration: Annotated[Array, "nb, n"]
    gamma: Annotated[Array, "n_c"]  # right-hand side of the constraint rows
    multipliers: Annotated[Array, "n_c"]
    left: Annotated[Array, "n_c"]  # residual of the constraint rows after a solution
    softness: Annotated[Array, "n_p"]  # of the rows of layout.mass: reciprocals of penalties in use
    change: Annotated[Array, "nb, n"]  # of accelerations and multipliers, where these are iterated
    change_multipliers: Annotated[Array, "n_c"]
    # of one body at a time
    C: Annotated[Array, "3, m"]  # slope of the first moment of mass by the modes
    # first moment of mass, its rate, its second rate at steady modal rates
    first: Annotated[Array, "3, 3"]
    twist: Annotated[Array, "3"]  # rate of the moment of momentum in the body at steady modal rates
    # of one force element at a time
    element: Annotated[Array, "e, element"]  # all rows that its kind can have
    element_used: Annotated[Array, "e, element"]  # the same of those that it has
    # what expressions read, and what they give
    # values and rates of coordinates (2 nm), auxiliary states (na), reactions (nr)
    quantity: Annotated[Array, "read"]
    g: Annotated[Array, "nm, 12"]  # rows of the coordinates
    # of force elements, and derivatives by their coordinate and its rate
    size: Annotated[Array, "nf, 3"]
    unsettled: Annotated[Array, "nf + 1, 2"]  # of forces that read reactions (evaluation.py)
    wind: Annotated[Array, "3"]  # at the reference height of a rotor, global [m/s]
    flow: Annotated[Array, "ns, flow"]  # of the sections of a rotor


def new_factors(model: Model, order: RowOrder, one: Any) -> Factors:
    """Return memory for factors with the rows of `order`, of the type of `one`.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    order : order of the rows, and their profile
    one : 1.0 or 1.0 + 0.0j: real or complex factors
    """
    nb, n, r = model.n_body, model.layout.widest, order.most_rows
    n_p = order.first.shape[0]
    profile = int(order.profile_start[n_p])
    sizes = {"nb": nb, "n": n, "r": r, "n_p": n_p, "profile": profile}
    return zeros_of(Factors, sizes, one, regular=np.ones(1))


def new_workspace(model: Model) -> Workspace:
    """Return the memory for evaluations of a model.

    Ground markers and the rows of added inertia are filled once for all.
    """
    layout = model.layout
    nb, n, r, m = model.n_body, layout.widest, layout.mass.most_rows, layout.most_modes
    n_c, nk = model.n_constraint, model.marker_body.shape[0]
    quantities, nf, e = model.quantities, model.force_kind.shape[0], layout.most_element_rows
    nm, nr = quantities.kind.shape[0], quantities.reaction_kind.shape[0]
    sizes = {"nb": nb, "n": n, "r": r, "m": m, "n_c": n_c, "nk": nk, "nf": nf, "nf + 1": nf + 1}
    sizes |= {"e": e, "nm": nm, "read": 2 * nm + model.n_aux + nr, "row": N_ROW}
    sizes |= {"n_p": layout.mass.place.shape[0], "ns": model.rotor.polar.shape[0]}
    sizes |= {"motion": N_MOTION, "element": N_ELEMENT_ROW, "flow": N_FLOW}
    work = zeros_of(Workspace, sizes, factors=new_factors(model, layout.mass, 1.0))
    for k in range(nk):
        if model.marker_body[k] < 0:
            stand(work.motion[k], model.marker_x[k], model.marker_A[k])
    place_added_rows(model, work.J)
    return work


def spare_workspace(model: Model) -> Workspace:
    """Return memory for evaluations that are over when the caller returns.

    One for each layout: models that differ in numbers only share it.
    """
    own = model.marker_x, model.marker_A, model.added_direction  # what `new_workspace` fills in
    known = model.layout.__dict__.get("_spare")
    if known is None or any(one is not other for one, other in zip(known[0], own, strict=True)):
        known = model.layout.__dict__["_spare"] = own, new_workspace(model)
    return known[1]  # type: ignore[no-any-return]


def modal_matrix(model: Model, flat: Array, i: int) -> Array:
    """Return the part (m, m) of body i of M_qq, K_qq or D_qq, as a view.

    Parameters
    ----------
    model : arrays of the mechanism (dynamics/model/model.py)
    flat : M_qq, K_qq or D_qq of all bodies, end to end
    i : number of the body
    """
    m, first = int(model.n_mode[i]), int(model.square_start[i])
    return flat[first : first + m * m].reshape(m, m)


@lean
def place_added_rows(model: Model, J: Array) -> None:
    """Fill the columns of J (nb, n, r) that belong to added inertia."""
    layout = model.layout
    for i in range(model.n_body):
        begin = layout.row_start[i + 1] - layout.row_start[i] - layout.added_start[i]
        for a in range(layout.added_start[i], layout.added_start[i + 1]):
            for k in range(layout.size[i]):
                J[i, k, begin + a] = model.added_direction[a, k]
