"""Expressions as arrays: programs in postfix order, and their evaluation with derivatives."""

from collections.abc import Callable, Hashable, Sequence
from typing import NamedTuple

import numpy as np

from ..arrays import Array, IntArray
from ..compiled import lean, structure
from ..curves import NamedCurve
from ..laws import N_COEFFICIENT, Law, law_value
from .operations import (
    ABS,
    ADD,
    AND,
    ARCCOS,
    ARCSIN,
    ARCTAN,
    ARCTAN2,
    CONSTANT,
    COS,
    COSH,
    CURVE,
    DIVIDE,
    EXP,
    FLOOR,
    LESS,
    LESS_EQUAL,
    LOAD,
    LOG,
    MAXIMUM,
    MINIMUM,
    MULTIPLY,
    NEGATE,
    NOT,
    POWER,
    SELECT,
    SIGN,
    SIN,
    SINH,
    SQRT,
    SUBTRACT,
    TAN,
    TANH,
    TIME,
)
from .tree import Node, depth, written

# Seeds of derivatives: a quantity by its number, or one of these.
NO_SEED, BY_TIME = -1, -2
N_NUMBER = 4  # of each entry of the stack: value, two first derivatives, a second one


@structure
class Programs(NamedTuple):
    """Expressions one after the other, and the curves that they read."""

    start: IntArray  # (n + 1,) first operation of each
    code: IntArray  # operations
    argument: Array  # number of a constant; place of a quantity or curve
    curve_start: IntArray  # (n_curve + 1,) as the laws of time of math/laws.py
    curve_place: Array
    curve_coefficient: Array  # (n_piece, N_COEFFICIENT)


def programs(
    nodes: Sequence[Node], place: Callable[[Hashable], int], curves: Sequence[Law] = ()
) -> Programs:
    """Return expressions as arrays; `place` numbers the quantities and curves that they read.

    Curves that they call by name follow `curves`.
    """
    called = {leaf.quantity: None for node in nodes for leaf in node.leaves()}
    named = [quantity for quantity in called if isinstance(quantity, NamedCurve)]
    numbers = {quantity: len(curves) + k for k, quantity in enumerate(named)}
    curves = [*curves, *(quantity.law for quantity in named)]

    def number(quantity: Hashable) -> int:
        if isinstance(quantity, NamedCurve):
            return numbers[quantity]
        return place(quantity)

    lists = [list(written(node, number)) for node in nodes]
    flat = [pair for pairs in lists for pair in pairs]
    sizes = [len(curve.times) for curve in curves]
    return Programs(
        np.cumsum([0, *(len(pairs) for pairs in lists)], dtype=np.int64),
        np.array([code for code, _ in flat], dtype=np.int64),
        np.array([argument for _, argument in flat], dtype=float),
        np.cumsum([0, *sizes], dtype=np.int64),
        np.concatenate([np.zeros(0), *(curve.times for curve in curves)]),
        np.concatenate([np.zeros((0, N_COEFFICIENT)), *(c.coefficients for c in curves)]),
    )


def new_stack(nodes: Sequence[Node]) -> Array:
    """Return memory for the evaluation of any of these expressions."""
    return np.zeros((max([1, *(depth(node) for node in nodes)]), N_NUMBER))


@lean
def evaluated(
    programs: Programs, p: int, t: float, quantity: Array, first: int, second: int, stack: Array
) -> tuple[float, float, float, float]:
    """Return value, derivatives by two quantities, and the second derivative by the first one.

    Parameters
    ----------
    p : number of the expression
    t, quantity : time [s], quantities (n,) that it reads
    first, second : numbers of the quantities; BY_TIME: the time; NO_SEED: none
    stack : memory
    """
    k = -1
    for i in range(programs.start[p], programs.start[p + 1]):
        code = programs.code[i]
        if code <= LOAD:
            k += 1
            stack[k, 1] = stack[k, 2] = stack[k, 3] = 0.0
            if code == CONSTANT:
                stack[k, 0] = programs.argument[i]
            elif code == TIME:
                stack[k, 0] = t
                stack[k, 1] = 1.0 if first == BY_TIME else 0.0
            else:
                which = int(programs.argument[i])
                stack[k, 0] = quantity[which]
                stack[k, 1] = 1.0 if which == first else 0.0
                stack[k, 2] = 1.0 if which == second else 0.0
        elif code == SELECT:
            k -= 2
            chosen = k + 1 if stack[k, 0] != 0.0 else k + 2
            for j in range(4):
                stack[k, j] = stack[chosen, j]
        elif code >= NEGATE:
            u = stack[k, 0]
            f, f_1, f_2 = _unary(code, u)
            _chain(stack, k, f, f_1, f_2)
        elif code == CURVE:
            f, f_1, f_2 = law_value(
                programs.curve_start,
                programs.curve_place,
                programs.curve_coefficient,
                int(programs.argument[i]),
                stack[k, 0],
            )
            _chain(stack, k, f, f_1, f_2)
        else:
            k -= 1
            _binary(code, stack, k)
    return stack[0, 0], stack[0, 1], stack[0, 2], stack[0, 3]


@lean
def _chain(stack: Array, k: int, f: float, f_1: float, f_2: float) -> None:
    """Replace u in entry k by f(u), with its derivatives f_1 and f_2."""
    a, b = stack[k, 1], stack[k, 2]
    stack[k, 0] = f
    # A slope without bound acts on nothing that does not move.
    stack[k, 3] = (f_1 * stack[k, 3] if stack[k, 3] != 0.0 else 0.0) + (
        f_2 * a * a if a != 0.0 else 0.0
    )
    stack[k, 1] = f_1 * a if a != 0.0 else 0.0
    stack[k, 2] = f_1 * b if b != 0.0 else 0.0


@lean
def _unary(code: int, u: float) -> tuple[float, float, float]:
    """Return f(u), f'(u), f''(u)."""
    if code == NEGATE:
        return -u, -1.0, 0.0
    if code == SIN:
        return np.sin(u), np.cos(u), -np.sin(u)
    if code == COS:
        return np.cos(u), -np.sin(u), -np.cos(u)
    if code == TAN:
        f = np.tan(u)
        return f, 1.0 + f * f, 2.0 * f * (1.0 + f * f)
    if code == ARCSIN:
        s = 1.0 / np.sqrt(1.0 - u * u)
        return np.arcsin(u), s, u * s * s * s
    if code == ARCCOS:
        s = 1.0 / np.sqrt(1.0 - u * u)
        return np.arccos(u), -s, -u * s * s * s
    if code == ARCTAN:
        s = 1.0 / (1.0 + u * u)
        return np.arctan(u), s, -2.0 * u * s * s
    if code == SINH:
        return np.sinh(u), np.cosh(u), np.sinh(u)
    if code == COSH:
        return np.cosh(u), np.sinh(u), np.cosh(u)
    if code == TANH:
        f = np.tanh(u)
        return f, 1.0 - f * f, -2.0 * f * (1.0 - f * f)
    if code == EXP:
        f = np.exp(u)
        return f, f, f
    if code == LOG:
        return np.log(u), 1.0 / u, -1.0 / (u * u)
    if code == SQRT:
        f = np.sqrt(u)
        return f, 0.5 / f, -0.25 / (u * f)
    if code == ABS:
        return abs(u), np.sign(u), 0.0
    if code == SIGN:
        return np.sign(u), 0.0, 0.0
    if code == FLOOR:
        return np.floor(u), 0.0, 0.0
    if code == NOT:
        return 1.0 if u == 0.0 else 0.0, 0.0, 0.0
    # SMOOTH: from 0 at 0 to 1 at 1
    s = min(1.0, max(0.0, u))
    slope, bend = 30.0 * (s * (1.0 - s)) ** 2, 60.0 * s * (1.0 - s) * (1.0 - 2.0 * s)
    return s * s * s * (10.0 + s * (6.0 * s - 15.0)), slope, bend


@lean
def _binary(code: int, stack: Array, k: int) -> None:
    """Replace u and w in entries k and k + 1 by f(u, w) in entry k."""
    u, a, b, aa = stack[k, 0], stack[k, 1], stack[k, 2], stack[k, 3]
    w, c, d, cc = stack[k + 1, 0], stack[k + 1, 1], stack[k + 1, 2], stack[k + 1, 3]
    if code == ADD:
        stack[k, 0], stack[k, 1], stack[k, 2], stack[k, 3] = u + w, a + c, b + d, aa + cc
    elif code == SUBTRACT:
        stack[k, 0], stack[k, 1], stack[k, 2], stack[k, 3] = u - w, a - c, b - d, aa - cc
    elif code == MULTIPLY:
        stack[k, 0], stack[k, 1], stack[k, 2] = u * w, a * w + u * c, b * w + u * d
        stack[k, 3] = aa * w + 2.0 * a * c + u * cc
    elif code == DIVIDE:
        f = u / w
        f_a, f_b = (a - f * c) / w, (b - f * d) / w
        stack[k, 0], stack[k, 1], stack[k, 2] = f, f_a, f_b
        stack[k, 3] = (aa - 2.0 * f_a * c - f * cc) / w
    elif code == POWER:
        f = u**w
        if c == 0.0 and d == 0.0 and cc == 0.0:
            _chain(stack, k, f, w * u ** (w - 1.0), w * (w - 1.0) * u ** (w - 2.0))
        else:  # exp(w log u)
            log = np.log(u)
            e_a, e_b = c * log + w * a / u, d * log + w * b / u
            e_aa = cc * log + (2.0 * c * a + w * aa) / u - w * a * a / (u * u)
            stack[k, 0], stack[k, 1], stack[k, 2] = f, f * e_a, f * e_b
            stack[k, 3] = f * (e_aa + e_a * e_a)
    elif code == ARCTAN2:  # of u over w
        s = 1.0 / (u * u + w * w)
        f_a, f_b = (w * a - u * c) * s, (w * b - u * d) * s
        stack[k, 0], stack[k, 1], stack[k, 2] = np.arctan2(u, w), f_a, f_b
        stack[k, 3] = (w * aa - u * cc) * s - 2.0 * f_a * (u * a + w * c) * s
    elif code in (MINIMUM, MAXIMUM):
        other = w < u if code == MINIMUM else w > u
        if other:
            for j in range(4):
                stack[k, j] = stack[k + 1, j]
    else:
        if code == LESS:
            holds = u < w
        elif code == LESS_EQUAL:
            holds = u <= w
        elif code == AND:
            holds = u != 0.0 and w != 0.0
        else:
            holds = u != 0.0 or w != 0.0
        stack[k, 0] = 1.0 if holds else 0.0
        stack[k, 1] = stack[k, 2] = stack[k, 3] = 0.0


def value_at(node: Node, t: float = 0.0) -> float:
    """Return the value of an expression of the time alone."""
    made = programs([node], lambda _: 0)
    none = np.zeros(1)
    return float(evaluated(made, 0, t, none, NO_SEED, NO_SEED, new_stack([node]))[0])
