"""Bounds of expressions hold for every instant of an interval, and no break is missed."""

import numpy as np
import pytest

from plymotion.solver.math.expressions import operations as op
from plymotion.solver.math.expressions.program import (
    NO_SEED,
    TIME,
    Node,
    constant,
    evaluated,
    new_stack,
    programs,
)
from plymotion.solver.math.expressions.ranges import parts
from plymotion.solver.math.laws import NamedCurve, curve

CURVE = NamedCurve("c", curve([-1.0, 0.2, 0.5, 1.5], [0.3, -1.0, 2.0, 0.5], smooth=False))
ONE = sorted(set(range(op.NEGATE, op.SMOOTH + 1)) | {op.CURVE})
TWO = sorted(op.BINARY)


def tree(rng: np.random.Generator, levels: int) -> Node:
    """An expression of the time with operations of every kind."""
    if levels == 0:
        return TIME if rng.random() < 0.6 else constant(rng.choice([-2.0, 0.5, 1.0, 3.0]))
    kind = rng.random()
    if kind < 0.45:
        code = int(rng.choice(ONE))
        own = CURVE if code == op.CURVE else None
        return Node(code, (tree(rng, levels - 1),), quantity=own)
    if kind < 0.9:
        return Node(int(rng.choice(TWO)), (tree(rng, levels - 1), tree(rng, levels - 1)))
    return Node(op.SELECT, tuple(tree(rng, levels - 1) for _ in range(3)))


def all_of(node: Node) -> list[Node]:
    """The parts of an expression, itself at the end."""
    return [part for child in node.children for part in all_of(child)] + [node]


@pytest.mark.parametrize("seed", range(200))
def test_values_lie_within_bounds(seed: int) -> None:
    rng = np.random.default_rng(seed)
    nodes = all_of(tree(rng, int(rng.integers(1, 5))))
    every, stack = programs(nodes, lambda _: 0), new_stack(nodes)
    low = np.sort(rng.uniform(-3.0, 3.0, 8))
    high = low + rng.choice([1e-3, 0.1, 2.0], 8)
    found = parts(every, len(nodes) - 1, low, high, stack)
    assert [part.code for part in found] == [n.code for n in nodes if n.code > op.LOAD]
    for a, b, least, most in zip(low, high, found[-1].low, found[-1].high, strict=True):
        assert least <= most
        for t in np.linspace(a, b, 41):
            with np.errstate(all="ignore"):
                values = [
                    evaluated(every, p, t, np.zeros(1), NO_SEED, NO_SEED, stack)[0]
                    for p in range(len(nodes))
                ]
            if np.isfinite(values).all():  # else comparisons with what is no number
                room = 1e-12 * max(1.0, abs(values[-1]))
                assert least - room <= values[-1] <= most + room


def test_where_a_comparison_may_change() -> None:
    node = Node(op.LESS, (TIME, constant(0.5)))
    program = programs([node], lambda _: 0)
    edges = np.linspace(0.0, 1.0, 8)
    (part,) = parts(program, 0, edges[:-1], edges[1:], new_stack([node]))
    np.testing.assert_array_equal(np.flatnonzero(part.breaks), [3])
    np.testing.assert_array_equal(part.low, [1, 1, 1, 0, 0, 0, 0])
    np.testing.assert_array_equal(part.high, [1, 1, 1, 1, 0, 0, 0])
