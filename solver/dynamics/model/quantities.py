"""Quantities that expressions read: coordinates of pairs of markers with their rates, states.

A coordinate is a scalar e of the relative motion of two markers, with a rate
edot = g (v_1, w_1, v_2, w_2). An angle over many turns needs to know which one it is in: an
auxiliary state that integrates edot tells it, to within half a turn. measures.py evaluates them.
"""

from typing import NamedTuple

from ...math.arrays import Array, IntArray
from ...math.compiled import structure
from ...math.expressions.program import Programs

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
