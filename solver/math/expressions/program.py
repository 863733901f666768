"""Expressions: trees, their derivatives by time, programs in postfix order and their evaluation."""

from collections.abc import Callable, Hashable, Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np

from ..arrays import Array
from ..compiled import lean
from ..laws import N_COEFFICIENT, Law, NamedCurve, law_value
from . import operations as op
from .operations import Programs


@dataclass(frozen=True)
class Node:
    """An operation and what it acts on.

    Attributes
    ----------
    code : of operations.py
    children : arguments
    value : of a CONSTANT
    quantity : that a LOAD reads, or the curve of a CURVE
    size : number of operations of the written expression, where shared parts stand several times
    """

    code: int
    children: tuple["Node", ...] = ()
    value: float = 0.0
    quantity: Hashable = None
    size: int = field(init=False, compare=False, default=1)

    def __post_init__(self) -> None:
        object.__setattr__(self, "size", 1 + sum(child.size for child in self.children))

    def __add__(self, other: "Node") -> "Node":
        if self == ZERO or other == ZERO:
            return other if self == ZERO else self
        return Node(op.ADD, (self, other))

    def __sub__(self, other: "Node") -> "Node":
        return self if other == ZERO else Node(op.SUBTRACT, (self, other))

    def __mul__(self, other: "Node") -> "Node":
        if ZERO in (self, other):
            return ZERO
        if ONE in (self, other):
            return other if self == ONE else self
        return Node(op.MULTIPLY, (self, other))

    def __truediv__(self, other: "Node") -> "Node":
        return ZERO if self == ZERO else Node(op.DIVIDE, (self, other))

    def leaves(self) -> Iterator["Node"]:
        """Yield the nodes that read a quantity, the time or a curve."""
        if self.code in (op.LOAD, op.TIME, op.CURVE):
            yield self
        for child in self.children:
            yield from child.leaves()


def constant(value: float) -> Node:
    """Return a number."""
    return Node(op.CONSTANT, value=float(value))


ZERO, ONE = constant(0.0), constant(1.0)
TIME = Node(op.TIME)


class NoRate(ValueError):
    """An expression without a known rate by time."""


def rate(node: Node, of_quantity: Callable[[Hashable], Node]) -> Node:
    """Return the derivative by time; `of_quantity` gives that of a quantity.

    Raises
    ------
    NoRate
        A function whose derivative is no function of this list, or as `of_quantity`.
    """
    if node.code == op.CONSTANT:
        return ZERO
    if node.code == op.TIME:
        return ONE
    if node.code == op.LOAD:
        return of_quantity(node.quantity)
    if all(leaf.code == op.CURVE for leaf in node.leaves()):
        return ZERO
    rates = tuple(rate(child, of_quantity) for child in node.children)
    return _by_parts(node, rates)


def _by_parts(node: Node, rates: tuple[Node, ...]) -> Node:
    code, c = node.code, node.children
    if code == op.ADD:
        return rates[0] + rates[1]
    if code == op.SUBTRACT:
        return rates[0] - rates[1]
    if code == op.MULTIPLY:
        return rates[0] * c[1] + c[0] * rates[1]
    if code == op.DIVIDE:
        return (rates[0] - node * rates[1]) / c[1]
    if code == op.ARCTAN2:
        return (c[1] * rates[0] - c[0] * rates[1]) / (c[0] * c[0] + c[1] * c[1])
    if code == op.POWER and rates[1] == ZERO:
        return c[1] * Node(op.POWER, (c[0], c[1] - ONE)) * rates[0]
    if code in (op.MINIMUM, op.MAXIMUM):
        first = c if code == op.MINIMUM else c[::-1]
        return Node(op.SELECT, (Node(op.LESS_EQUAL, first), rates[0], rates[1]))
    if code == op.SELECT:
        return Node(op.SELECT, (c[0], rates[1], rates[2]))
    if code in (op.LESS, op.LESS_EQUAL, op.AND, op.OR, op.NOT, op.SIGN, op.FLOOR):
        return ZERO
    if code == op.CURVE and isinstance(node.quantity, NamedCurve):
        return Node(op.CURVE, c, quantity=node.quantity.derivative()) * rates[0]
    if code in _SLOPES:
        return _SLOPES[code](node, c[0]) * rates[0]
    raise NoRate("has no derivative by time that is known here")


def _of(code: int, *children: Node) -> Node:
    return Node(code, children)


def _smooth_slope(u: Node) -> Node:
    """Return 30 (s (1 - s))^2 with s = u from 0 to 1."""
    s = Node(op.MINIMUM, (Node(op.MAXIMUM, (u, ZERO)), ONE))
    root = s * (ONE - s)
    return constant(30.0) * root * root


_SLOPES: dict[int, Callable[[Node, Node], Node]] = {
    op.NEGATE: lambda _, __: constant(-1.0),
    op.SIN: lambda _, u: _of(op.COS, u),
    op.COS: lambda _, u: _of(op.NEGATE, _of(op.SIN, u)),
    op.TAN: lambda f, _: ONE + f * f,
    op.ARCSIN: lambda _, u: ONE / _of(op.SQRT, ONE - u * u),
    op.ARCCOS: lambda _, u: constant(-1.0) / _of(op.SQRT, ONE - u * u),
    op.ARCTAN: lambda _, u: ONE / (ONE + u * u),
    op.SINH: lambda _, u: _of(op.COSH, u),
    op.COSH: lambda _, u: _of(op.SINH, u),
    op.TANH: lambda f, _: ONE - f * f,
    op.EXP: lambda f, _: f,
    op.LOG: lambda _, u: ONE / u,
    op.SQRT: lambda f, _: constant(0.5) / f,
    op.SMOOTH: lambda _, u: _smooth_slope(u),
    op.ABS: lambda _, u: _of(op.SIGN, u),
}


def written(node: Node, place: Callable[[Hashable], int]) -> Iterator[tuple[int, float]]:
    """Yield operations and their arguments in postfix order; `place` numbers quantities."""
    for child in node.children:
        yield from written(child, place)
    reads = node.code in (op.LOAD, op.CURVE)
    yield node.code, float(place(node.quantity)) if reads else node.value


def depth(node: Node) -> int:
    """Return how many numbers the evaluation keeps at once."""
    return max([1, *(k + depth(child) for k, child in enumerate(node.children))])


# Seeds of derivatives: a quantity by its number, or one of these.
NO_SEED, BY_TIME = -1, -2
N_NUMBER = 4  # of each entry of the stack: value, two first derivatives, a second one


def programs(
    nodes: Sequence[Node], place: Callable[[Hashable], int], curves: Sequence[Law] = ()
) -> Programs:
    """Return expressions as arrays; `place` numbers the quantities and curves that they read.

    Curves that they call by name follow `curves`.

    Parameters
    ----------
    nodes : trees of the expressions
    place : number of a quantity among those that are read
    curves : laws that expressions call by number
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
        if code <= op.LOAD:
            k += 1
            stack[k, 1] = stack[k, 2] = stack[k, 3] = 0.0
            if code == op.CONSTANT:
                stack[k, 0] = programs.argument[i]
            elif code == op.TIME:
                stack[k, 0] = t
                stack[k, 1] = 1.0 if first == BY_TIME else 0.0
            else:
                which = int(programs.argument[i])
                stack[k, 0] = quantity[which]
                stack[k, 1] = 1.0 if which == first else 0.0
                stack[k, 2] = 1.0 if which == second else 0.0
        elif code == op.SELECT:
            k -= 2
            chosen = k + 1 if stack[k, 0] != 0.0 else k + 2
            for j in range(4):
                stack[k, j] = stack[chosen, j]
        elif code >= op.NEGATE:
            u = stack[k, 0]
            f, f_1, f_2 = unary(code, u)
            _compose(stack, k, f, f_1, f_2)
        elif code == op.CURVE:
            f, f_1, f_2 = law_value(
                programs.curve_start,
                programs.curve_place,
                programs.curve_coefficient,
                int(programs.argument[i]),
                stack[k, 0],
            )
            _compose(stack, k, f, f_1, f_2)
        else:
            k -= 1
            _binary(code, stack, k)
    return stack[0, 0], stack[0, 1], stack[0, 2], stack[0, 3]


@lean
def _compose(stack: Array, k: int, f: float, f_1: float, f_2: float) -> None:
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
def unary(code: int, u: float) -> tuple[float, float, float]:
    """Return f(u), f'(u), f''(u)."""
    if code == op.NEGATE:
        return -u, -1.0, 0.0
    if code == op.SIN:
        return np.sin(u), np.cos(u), -np.sin(u)
    if code == op.COS:
        return np.cos(u), -np.sin(u), -np.cos(u)
    if code == op.TAN:
        f = np.tan(u)
        return f, 1.0 + f * f, 2.0 * f * (1.0 + f * f)
    if code == op.ARCSIN:
        s = 1.0 / np.sqrt(1.0 - u * u)
        return np.arcsin(u), s, u * s * s * s
    if code == op.ARCCOS:
        s = 1.0 / np.sqrt(1.0 - u * u)
        return np.arccos(u), -s, -u * s * s * s
    if code == op.ARCTAN:
        s = 1.0 / (1.0 + u * u)
        return np.arctan(u), s, -2.0 * u * s * s
    if code == op.SINH:
        return np.sinh(u), np.cosh(u), np.sinh(u)
    if code == op.COSH:
        return np.cosh(u), np.sinh(u), np.cosh(u)
    if code == op.TANH:
        f = np.tanh(u)
        return f, 1.0 - f * f, -2.0 * f * (1.0 - f * f)
    if code == op.EXP:
        f = np.exp(u)
        return f, f, f
    if code == op.LOG:
        return np.log(u), 1.0 / u, -1.0 / (u * u)
    if code == op.SQRT:
        f = np.sqrt(u)
        return f, 0.5 / f, -0.25 / (u * f)
    if code == op.ABS:
        return abs(u), np.sign(u), 0.0
    if code == op.SIGN:
        return np.sign(u), 0.0, 0.0
    if code == op.FLOOR:
        return np.floor(u), 0.0, 0.0
    if code == op.NOT:
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
    if code == op.ADD:
        stack[k, 0], stack[k, 1], stack[k, 2], stack[k, 3] = u + w, a + c, b + d, aa + cc
    elif code == op.SUBTRACT:
        stack[k, 0], stack[k, 1], stack[k, 2], stack[k, 3] = u - w, a - c, b - d, aa - cc
    elif code == op.MULTIPLY:
        stack[k, 0], stack[k, 1], stack[k, 2] = u * w, a * w + u * c, b * w + u * d
        stack[k, 3] = aa * w + 2.0 * a * c + u * cc
    elif code == op.DIVIDE:
        f = u / w
        f_a, f_b = (a - f * c) / w, (b - f * d) / w
        stack[k, 0], stack[k, 1], stack[k, 2] = f, f_a, f_b
        stack[k, 3] = (aa - 2.0 * f_a * c - f * cc) / w
    elif code == op.POWER:
        f = u**w
        if c == 0.0 and d == 0.0 and cc == 0.0:
            _compose(stack, k, f, w * u ** (w - 1.0), w * (w - 1.0) * u ** (w - 2.0))
        else:  # exp(w log u)
            log = np.log(u)
            e_a, e_b = c * log + w * a / u, d * log + w * b / u
            e_aa = cc * log + (2.0 * c * a + w * aa) / u - w * a * a / (u * u)
            stack[k, 0], stack[k, 1], stack[k, 2] = f, f * e_a, f * e_b
            stack[k, 3] = f * (e_aa + e_a * e_a)
    elif code == op.ARCTAN2:  # of u over w
        s = 1.0 / (u * u + w * w)
        f_a, f_b = (w * a - u * c) * s, (w * b - u * d) * s
        stack[k, 0], stack[k, 1], stack[k, 2] = np.arctan2(u, w), f_a, f_b
        stack[k, 3] = (w * aa - u * cc) * s - 2.0 * f_a * (u * a + w * c) * s
    elif code in (op.MINIMUM, op.MAXIMUM):
        other = w < u if code == op.MINIMUM else w > u
        if other:
            for j in range(4):
                stack[k, j] = stack[k + 1, j]
    else:
        if code == op.LESS:
            holds = u < w
        elif code == op.LESS_EQUAL:
            holds = u <= w
        elif code == op.AND:
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
