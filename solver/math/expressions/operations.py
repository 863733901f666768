"""Operations of an expression: their numbers, names in a case file, and programs as arrays."""

from typing import NamedTuple

from ..arrays import Array, IntArray
from ..compiled import structure

(
    CONSTANT,
    TIME,
    LOAD,
    CURVE,
    ADD,
    SUBTRACT,
    MULTIPLY,
    DIVIDE,
    POWER,
    MINIMUM,
    MAXIMUM,
    ARCTAN2,
    LESS,
    LESS_EQUAL,
    AND,
    OR,
    SELECT,
    NEGATE,
    NOT,
    SIN,
    COS,
    TAN,
    ARCSIN,
    ARCCOS,
    ARCTAN,
    SINH,
    COSH,
    TANH,
    EXP,
    LOG,
    SQRT,
    ABS,
    SIGN,
    FLOOR,
    SMOOTH,
) = range(35)

BINARY = frozenset(range(ADD, OR + 1))
PUSHES = frozenset((CONSTANT, TIME, LOAD))


def operands(code: int) -> int:
    """Return how many values an operation takes from the stack."""
    return 0 if code in PUSHES else 3 if code == SELECT else 2 if code in BINARY else 1


# Functions of a case file: operation and number of arguments.
FUNCTIONS = {
    "sin": (SIN, 1),
    "cos": (COS, 1),
    "tan": (TAN, 1),
    "asin": (ARCSIN, 1),
    "acos": (ARCCOS, 1),
    "atan": (ARCTAN, 1),
    "atan2": (ARCTAN2, 2),
    "sinh": (SINH, 1),
    "cosh": (COSH, 1),
    "tanh": (TANH, 1),
    "exp": (EXP, 1),
    "log": (LOG, 1),
    "sqrt": (SQRT, 1),
    "abs": (ABS, 1),
    "sign": (SIGN, 1),
    "floor": (FLOOR, 1),
    "min": (MINIMUM, 2),
    "max": (MAXIMUM, 2),
}


@structure
class Programs(NamedTuple):
    """Expressions one after the other, and the curves that they read."""

    start: IntArray  # (n + 1,) first operation of each
    code: IntArray  # operations
    argument: Array  # number of a constant; place of a quantity or curve
    curve_start: IntArray  # (n_curve + 1,) as the laws of time of math/laws.py
    curve_place: Array
    curve_coefficient: Array  # (n_piece, N_COEFFICIENT)
