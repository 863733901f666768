"""Text of an expression to a tree: nodes of Python's syntax from a list, and nothing else."""

import ast
import math
from collections.abc import Callable, Collection, Hashable, Mapping
from typing import Protocol, TypeGuard

from . import operations as op
from .program import TIME, ZERO, Node, NoRate, constant, rate

MOST_CHARACTERS, MOST_DEPTH = 2000, 50
MOST_SHOWN = 100  # characters of a part in a message
# Of an expression with its derivatives written out: each is evaluated at every stage of every step.
MOST_OPERATIONS = 10_000
NAMES = {"t": TIME, "pi": constant(math.pi)}
# Functions beside those of operations.py: made of them, or read by the parser itself.
MADE = {"step": 1, "smooth_step": 3, "clip": 3, "hypot": 2, "rate": 1}
_OPERATORS: dict[type[ast.operator], int] = {
    ast.Add: op.ADD,
    ast.Sub: op.SUBTRACT,
    ast.Mult: op.MULTIPLY,
    ast.Div: op.DIVIDE,
    ast.Pow: op.POWER,
}
# Of a comparison: operation, and whether the sides change places.
_COMPARISONS: dict[type[ast.cmpop], tuple[int, bool]] = {
    ast.Lt: (op.LESS, False),
    ast.LtE: (op.LESS_EQUAL, False),
    ast.Gt: (op.LESS, True),
    ast.GtE: (op.LESS_EQUAL, True),
}


class ExpressionError(ValueError):
    """An expression that cannot be used; the message names the part and what is expected.

    Attributes
    ----------
    word, known : a word without meaning, and those that have one; empty for other errors
    """

    def __init__(self, message: str, word: str = "", known: Collection[str] = ()) -> None:
        super().__init__(message)
        self.word, self.known = word, known


class Scope(Protocol):
    """What names and functions with words as arguments mean."""

    @property
    def names(self) -> Mapping[str, Node]:
        """Values of names, beside `NAMES`."""

    @property
    def functions(self) -> Mapping[str, Callable[..., Node]]:
        """Of words, and a last argument where they take one: f(*words) or f(*words, node).

        They raise ValueError if no such thing exists.
        """

    def rate(self, quantity: Hashable) -> Node:
        """Rate by time of a quantity; raises NoRate."""


class Plain:
    """The scope of an expression of time: numbers by name, no quantities."""

    functions: Mapping[str, Callable[..., Node]] = {}

    def __init__(self, names: Mapping[str, float] | None = None) -> None:
        self.names = {name: constant(value) for name, value in (names or {}).items()}

    def rate(self, quantity: Hashable) -> Node:
        """No quantities, no rates."""
        raise NoRate("has no rate by time")


def parsed(text: str, scope: Scope) -> Node:
    """Return the tree of an expression.

    Raises
    ------
    ExpressionError
    """
    if len(text) > MOST_CHARACTERS:
        raise ExpressionError(f"expected {MOST_CHARACTERS} characters at most, found {len(text)}")
    # One line: TOML's long texts have several, each with a comment of its own or none.
    text = " ".join(line.partition("#")[0] for line in text.splitlines()).strip()
    try:
        tree = ast.parse(text, mode="eval")
    except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
        where = getattr(error, "offset", None)
        at = f" at character {where}" if where else ""
        message = getattr(error, "msg", None) or str(error)
        raise ExpressionError(f"expected an expression, found {message}{at}") from error
    return _Reader(text, scope).node(tree.body, 0)


class _Reader:
    def __init__(self, text: str, scope: Scope) -> None:
        self.text, self.scope = text, scope
        self.names = {**NAMES, **scope.names}

    def node(self, tree: ast.expr, level: int) -> Node:
        """Return the tree of a part of the text."""
        if level > MOST_DEPTH:
            raise ExpressionError(
                f"expected {MOST_DEPTH} levels at most (brackets, or operations in a row; brackets "
                "around parts of a long sum save levels)"
            )
        result = self._node(tree, level)
        if result.size > MOST_OPERATIONS:
            raise self.error(
                tree, f"has {result.size:.4g} operations; expected {MOST_OPERATIONS} at most"
            )
        return result

    def _node(self, tree: ast.expr, level: int) -> Node:
        def inner(part: ast.expr) -> Node:
            return self.node(part, level + 1)

        if isinstance(tree, ast.Constant) and _is_number(tree.value):
            try:
                value = float(tree.value)
            except OverflowError:  # an integer of hundreds of digits
                value = math.inf
            if not math.isfinite(value):
                raise self.error(tree, "is not finite")
            return constant(value)
        if isinstance(tree, ast.Name):
            if tree.id in self.names:
                return self.names[tree.id]
            raise self.unknown(tree.id, self.names, "name")
        if isinstance(tree, ast.UnaryOp):
            return self.unary(tree, inner(tree.operand))
        if isinstance(tree, ast.BinOp) and type(tree.op) in _OPERATORS:
            node = Node(_OPERATORS[type(tree.op)], (inner(tree.left), inner(tree.right)))
            try:
                return _folded(node)
            except ArithmeticError as error:
                raise self.error(tree, "is not finite") from error
        if isinstance(tree, ast.Compare):
            return self.comparison(tree, level)
        if isinstance(tree, ast.BoolOp):
            code = op.AND if isinstance(tree.op, ast.And) else op.OR
            return _joined(code, [inner(part) for part in tree.values])
        if isinstance(tree, ast.IfExp):
            return Node(op.SELECT, (inner(tree.test), inner(tree.body), inner(tree.orelse)))
        if isinstance(tree, ast.Call) and isinstance(tree.func, ast.Name) and not tree.keywords:
            return self.call(tree, tree.func.id, level)
        if isinstance(tree, ast.BinOp) and isinstance(tree.op, ast.BitXor):
            raise self.error(tree, "is not allowed; a power is written x**2, not x^2")
        raise self.error(
            tree, "is not allowed; expected numbers, names, + - * / **, comparisons, functions"
        )

    def unary(self, tree: ast.UnaryOp, operand: Node) -> Node:
        """Return a sign or `not`."""
        if isinstance(tree.op, ast.UAdd):
            return operand
        if isinstance(tree.op, ast.Not):
            return Node(op.NOT, (operand,))
        if isinstance(tree.op, ast.USub):
            return _folded(Node(op.NEGATE, (operand,)))
        raise self.error(tree, "is not allowed")

    def comparison(self, tree: ast.Compare, level: int) -> Node:
        """Return 1 where all comparisons hold, else 0."""
        sides = [self.node(part, level + 1) for part in (tree.left, *tree.comparators)]
        comparisons = []
        for operator, one, two in zip(tree.ops, sides, sides[1:], strict=False):
            if type(operator) not in _COMPARISONS:
                raise self.error(tree, "compares by ==, != or another sign; expected < <= > >=")
            code, swapped = _COMPARISONS[type(operator)]
            comparisons.append(Node(code, (two, one) if swapped else (one, two)))
        return _joined(op.AND, comparisons)

    def call(self, tree: ast.Call, name: str, level: int) -> Node:
        """Return a function of its arguments."""
        if name in self.scope.functions:
            words = [a.value for a in tree.args if isinstance(a, ast.Constant) and _is_word(a)]
            rest = [self.node(a, level + 1) for a in tree.args if not _is_word(a)]
            try:
                return self.scope.functions[name](*words, *rest)
            except TypeError as error:
                raise self.error(tree, "has too many or too few arguments") from error
            except ValueError as error:
                raise self.error(tree, str(error)) from error
        known = {**{f: n for f, (_, n) in op.FUNCTIONS.items()}, **MADE}
        if name not in known:
            raise self.unknown(name, {*known, *self.scope.functions}, "function")
        several = name in ("min", "max") and len(tree.args) > 1
        if len(tree.args) != known[name] and not several:
            raise self.error(tree, f"has {len(tree.args)} arguments; expected {known[name]}")
        arguments = [self.node(a, level + 1) for a in tree.args]
        if name in op.FUNCTIONS:
            code, _ = op.FUNCTIONS[name]
            return _joined(code, arguments) if several else Node(code, tuple(arguments))
        if name == "rate":
            try:
                return rate(arguments[0], self.scope.rate)
            except NoRate as error:
                raise self.error(tree.args[0], str(error)) from error
        return _made(name, arguments)

    def error(self, tree: ast.AST, message: str) -> ExpressionError:
        """Return the error of a part of the text."""
        part = ast.get_source_segment(self.text, tree) or self.text
        if len(part) > MOST_SHOWN:
            part = f"{part[:MOST_SHOWN]}..."
        return ExpressionError(f"`{part}` {message}")

    def unknown(self, word: str, known: Collection[str], what: str) -> ExpressionError:
        """Return the error of a word."""
        functions = {*op.FUNCTIONS, *MADE, *self.scope.functions}
        if what == "name" and word in functions:
            return ExpressionError(f"`{word}` is a function; expected its arguments in brackets")
        return ExpressionError(f"there is no {what} `{word}`", word, known)


def _joined(code: int, nodes: list[Node]) -> Node:
    """Return an associative operation on any number of nodes, as a tree of few levels."""
    if len(nodes) == 1:
        return nodes[0]
    half = (len(nodes) + 1) // 2
    return Node(code, (_joined(code, nodes[:half]), _joined(code, nodes[half:])))


def _is_number(value: object) -> TypeGuard[int | float]:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _is_word(tree: ast.expr) -> bool:
    return isinstance(tree, ast.Constant) and isinstance(tree.value, str)


def _made(name: str, a: list[Node]) -> Node:
    if name == "step":
        return Node(op.LESS_EQUAL, (ZERO, a[0]))
    if name == "smooth_step":
        return Node(op.SMOOTH, ((a[0] - a[1]) / (a[2] - a[1]),))
    if name == "clip":
        return Node(op.MINIMUM, (Node(op.MAXIMUM, (a[0], a[1])), a[2]))
    return Node(op.SQRT, (a[0] * a[0] + a[1] * a[1],))


def _folded(node: Node) -> Node:
    """Return a number where all arguments are; raise ArithmeticError if it is not finite."""
    if any(child.code != op.CONSTANT for child in node.children):
        return node
    u = node.children[0].value
    if node.code == op.NEGATE:
        return constant(-u)
    w = node.children[1].value
    value = {
        op.ADD: lambda: u + w,
        op.SUBTRACT: lambda: u - w,
        op.MULTIPLY: lambda: u * w,
        op.DIVIDE: lambda: u / w,
        op.POWER: lambda: u**w,
    }[node.code]()
    if isinstance(value, complex) or not math.isfinite(value):
        raise ArithmeticError
    return constant(value)
