"""Expressions: parsed by a whitelist, derivatives against differences, errors in words."""

import numpy as np
import pytest

from plymotion.solver.math.expressions import operations as op
from plymotion.solver.math.expressions.parse import ExpressionError, Plain, parsed
from plymotion.solver.math.expressions.program import (
    BY_TIME,
    NO_SEED,
    TIME,
    Node,
    depth,
    evaluated,
    new_stack,
    programs,
    rate,
    value_at,
)
from plymotion.solver.math.laws import curve, law_value

NAMES = {"a": 2.0, "b": -0.3}
TEXTS = [
    "3 * t**2 - a / (1 + t) + -b",
    "sin(2 * t) * cos(t) + tan(t / 3)",
    "asin(t / 3) + acos(t / 4) + atan(t) + atan2(t, 1 + t**2)",
    "sinh(t) + cosh(t) * tanh(a * t)",
    "exp(-t) * log(1 + t) + sqrt(2 + t)",
    "abs(b * t) + sign(t) * floor(2.7) + hypot(t, 2)",
    "min(t, 5, a * t) + max(t, 0.1) + clip(t**3, -1, 9)",
    "smooth_step(t, 0, 2) + step(t - 0.2)",
    "t**2.5 + t**t + 2**t",
    "1 if t < 0.1 or t > 3 else t**2",
    "t * (0 < t <= 2 and not t > 3)",
]


class Quantities(Plain):
    """x and v, read as quantities 0 and 1."""

    def __init__(self):
        self.names = {"x": Node(op.LOAD, quantity=0), "v": Node(op.LOAD, quantity=1)}

    def rate(self, quantity):
        assert quantity == 0
        return self.names["v"]


def values(node, t, quantity=(0.0,), first=BY_TIME, second=NO_SEED):
    made = programs([node], int)
    return evaluated(made, 0, t, np.array(quantity, dtype=float), first, second, new_stack([node]))


def plain(text, t):
    """The same in Python, whose words they are."""
    words = {name: getattr(np, f"arc{name[1:]}") for name in ("asin", "acos", "atan", "atan2")}
    words |= {
        n: getattr(np, n)
        for n in ["sin", "cos", "tan", "sinh", "cosh", "tanh", "exp", "log", "sqrt", "sign"]
    }
    words |= {"abs": abs, "min": min, "max": max, "floor": np.floor, "hypot": np.hypot}
    words |= {"clip": lambda x, low, high: min(max(x, low), high), "step": lambda x: float(x >= 0)}
    words["smooth_step"] = lambda x, p, q: ((s := (x - p) / (q - p)) ** 3) * (10 + s * (6 * s - 15))
    return float(eval(text, {"__builtins__": {}}, {**words, **NAMES, "t": t}))


@pytest.mark.parametrize("text", TEXTS)
def test_value_and_derivatives_by_time(text):
    node, t, h = parsed(text, Plain(NAMES)), 0.7, 1e-3
    f, f_d, _, f_dd = values(node, t)
    assert f == pytest.approx(plain(text, t), rel=1e-14)
    weights = np.array([-1, 9, -45, 0, 45, -9, 1]) / 60
    ahead = [values(node, t + k * h)[:2] for k in range(-3, 4)]
    slope, bend = weights @ np.array(ahead) / h
    assert f_d == pytest.approx(slope, abs=1e-9)
    assert f_dd == pytest.approx(bend, abs=1e-9)


def test_lines_of_a_long_expression_are_one():
    """As TOML's texts in three quotes have them; what follows # is a comment of its line."""
    text = "\n  3 * t   # of time\n  + (a -\n  1)\n"
    assert values(parsed(text, Plain(NAMES)), 2.0)[0] == 7.0


def test_derivatives_by_two_quantities():
    node = parsed("sin(x * v) * v**3 / (1 + x**2) + atan2(v, x) + t * x**v", Quantities())
    at, h = np.array([0.6, 1.7]), 1e-6
    f, f_x, f_v, _ = values(node, 0.4, at, 0, 1)
    expected = []
    for k in range(2):
        step = h * np.eye(2)[k]
        ends = [values(node, 0.4, at + s * step)[0] for s in (1, -1)]
        expected.append((ends[0] - ends[1]) / (2 * h))
    assert f == pytest.approx(np.sin(1.02) * 1.7**3 / 1.36 + np.arctan2(1.7, 0.6) + 0.4 * 0.6**1.7)
    assert (f_x, f_v) == pytest.approx(expected, rel=1e-8)


@pytest.mark.parametrize("text", [x for x in TEXTS if "t**t" not in x])
def test_rate_is_the_derivative_by_time(text):
    node = parsed(text, Plain(NAMES))
    assert values(rate(node, lambda _: TIME), 0.7)[0] == pytest.approx(values(node, 0.7)[1])


def test_rate_of_a_quantity():
    node = parsed("rate(sin(x) * t)", Quantities())
    assert values(node, 0.3, (0.5, 2.0))[0] == pytest.approx(np.sin(0.5) + 0.3 * np.cos(0.5) * 2.0)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("sn(t)", "there is no function `sn`"),
        ("a + q", "there is no name `q`"),
        ("__import__('os').system('true')", "is not allowed"),
        ("__import__('os')", "there is no function `__import__`"),
        ("t.real", "`t.real` is not allowed"),
        ("[t for t in (1, 2)]", "is not allowed"),
        ("(lambda: 1)()", "is not allowed"),
        ("(y := 3)", "is not allowed"),
        ("True", "is not allowed"),
        ("t // 2", "`t // 2` is not allowed"),
        ("-5*t^3", "a power is written x**2, not x^2"),
        ("sin(1, 2)", "has 2 arguments; expected 1"),
        ("sin", "is a function; expected its arguments in brackets"),
        ("t == 1", "expected < <= > >="),
        ("1 +", "expected an expression"),
        ("", "expected an expression"),
        ("1 / 0", "`1 / 0` is not finite"),
        ("10 ** 400", "`10 ** 400` is not finite"),
        ("(-2) ** 0.5", "is not finite"),
        ("'t'", "is not allowed"),
        ("rate(t ** t)", "has no derivative by time"),
        ("+".join(["t"] * 100), "50 levels"),
        ("9" * 400, "is not finite"),
        ("hypot(" * 40 + "t" + ", 1)" * 40, "operations; expected 10000 at most"),
        ("rate(" * 10 + "sin(t ** 3) * t" + ")" * 10, "operations; expected 10000 at most"),
        ("t" * 3000, "2000 characters"),
    ],
)
def test_bad_expressions(text, words):
    with pytest.raises(ExpressionError, match=None) as caught:
        parsed(text, Plain(NAMES))
    assert words in str(caught.value)


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("<".join(["t"] * 500), 0.0),
        ("<=".join(["t"] * 500), 1.0),
        (" and ".join(["t"] * 150 + ["0"] + ["t"] * 150), 0.0),
        ("max(" + ", ".join(f"{k}" for k in range(400)) + ", t)", 399.0),
    ],
)
def test_many_parts_of_one_operation_are_few_levels(text, value):
    tree = parsed(text, Plain(NAMES))
    assert value_at(tree, 0.5) == value
    assert depth(tree) < 20


@pytest.mark.parametrize("smooth", [True, False])
def test_curves_pass_their_points_and_go_on_straight(smooth):
    x, y = [-1.0, 0.0, 0.5, 2.0], [3.0, 0.0, 1.0, -1.0]
    law = curve(x, y, smooth=smooth)
    start = np.array([0, law.times.size])

    def at(place):
        return law_value(start, law.times, law.coefficients, 0, place)

    for place, value in zip(x, y, strict=True):
        assert at(place)[0] == pytest.approx(value, abs=1e-14)
        ends = [at(place + s * 1e-9) for s in (-1, 1)]
        if smooth or place in (-1.0, 2.0):
            assert ends[0][1] == pytest.approx(ends[1][1], abs=1e-7)
    for end, further in ((-1.0, -4.0), (2.0, 7.0)):
        value, slope, _ = at(end)
        assert at(further) == pytest.approx((value + slope * (further - end), slope, 0.0))
    if not smooth:
        assert at(0.25)[:2] == pytest.approx((0.5, 2.0))


def test_curves_need_ascending_points():
    with pytest.raises(ValueError, match=r"x\[1\] = 0: expected more than 1, x must ascend"):
        curve([1.0, 0.0], [0.0, 1.0])
