"""Expressions as trees: how they are built, differentiated by time, and written as programs."""

from collections.abc import Callable, Hashable, Iterator
from dataclasses import dataclass, field

from ..curves import NamedCurve
from . import operations as op


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
    return _chain(node, rates)


def _chain(node: Node, rates: tuple[Node, ...]) -> Node:
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
