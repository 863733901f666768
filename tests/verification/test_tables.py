"""Tables that expressions call by name: forces, drives, their derivatives, bad input."""

import numpy as np
import pytest
from samples.coordinate_samples import RADAU, carriage, force, run, wheel
from scipy.interpolate import CubicSpline, PchipInterpolator

from plymotion.solver.errors import InputError
from plymotion.solver.math.expressions import operations as op
from plymotion.solver.math.expressions.program import Node, evaluated, new_stack, programs
from plymotion.solver.math.laws import NamedCurve, curve_of_table

X = [-1.0, -0.2, 0.1, 0.5, 2.0]
Y = [-4.0, -0.5, 0.3, 0.3, 5.0]


def table(name, x, y, **keys):
    more = "".join(f'{key} = "{value}"\n' for key, value in keys.items())
    return f"[tables.{name}]\nx = {list(map(float, x))}\ny = {list(map(float, y))}\n{more}"


@pytest.mark.parametrize("interpolation", ["linear", "cubic", "pchip"])
@pytest.mark.parametrize("extrapolation", ["linear", "constant"])
def test_values_and_derivatives(interpolation, extrapolation):
    """Inside against SciPy, beyond the ends against the rule; slopes as the program has them."""
    law = curve_of_table(X, Y, interpolation, extrapolation)
    node = Node(op.CURVE, (Node(op.LOAD, quantity=0),), quantity=NamedCurve("c", law))
    made, stack = programs([node], lambda k: k), new_stack([node])

    def found(x):
        return np.array(evaluated(made, 0, 0.0, np.array([x]), 0, -1, stack))[[0, 1, 3]]

    other = {
        "linear": lambda x, k: [np.interp(x, X, Y), np.diff(Y)[np.searchsorted(X, x) - 1]
                                / np.diff(X)[np.searchsorted(X, x) - 1], 0.0][k],
        "cubic": lambda x, k: CubicSpline(X, Y)(x, k),
        "pchip": lambda x, k: PchipInterpolator(X, Y)(x, k),
    }[interpolation]  # fmt: skip
    for x in (-0.9, -0.21, 0.0, 0.3, 0.7, 1.99):
        np.testing.assert_allclose(found(x), [other(x, k) for k in range(3)], atol=1e-12)
    for end, x in ((X[0], X[0] - 0.7), (X[-1], X[-1] + 0.7)):
        slope = other(np.nextafter(end, 0.0), 1) if extrapolation == "linear" else 0.0
        value = dict(zip(X, Y, strict=True))[end] + slope * (x - end)
        np.testing.assert_allclose(found(x), [value, slope, 0.0], atol=1e-10)


def test_pchip_does_not_overshoot():
    law = curve_of_table(X, Y, "pchip", "linear")
    node = Node(op.CURVE, (Node(op.LOAD, quantity=0),), quantity=NamedCurve("c", law))
    made, stack = programs([node], lambda k: k), new_stack([node])
    x = np.linspace(0.1, 0.5, 41)
    y = [evaluated(made, 0, 0.0, np.array([s]), 0, -1, stack)[0] for s in x]
    np.testing.assert_allclose(y, 0.3, atol=1e-15)


@pytest.mark.parametrize("solver", ["", RADAU])
def test_a_spring_from_a_file(tmp_path, solver):
    """A linear spring and a damper, from a file and from lists, in one expression of a joint."""
    (tmp_path / "spring.csv").write_text("x, F\n-2, -18\n0, 0\n1, 9\n")
    text = (
        '[tables.pull]\nfile = "spring.csv"\ninterpolation = "linear"\n'
        + table("drag", [-1, 1], [-1, 1])
        + carriage(
            force(
                "s",
                "coordinate_force",
                joint="rail",
                expression="-pull(x) - drag(joint_rate('rail'))",
            ),
            speed=1.0,
        )
    )
    t, s, _ = run(tmp_path, text, 2.0, 0.1, solver)
    r = np.sqrt(9 - 0.25)
    np.testing.assert_allclose(s["x"], np.exp(-0.5 * t) * np.sin(r * t) / r, atol=1e-8)


def test_a_drive_by_a_table(tmp_path):
    """A cubic through its points is that cubic: angle, and the torque by its second derivative."""
    times = np.linspace(0.0, 2.0, 5)
    text = (
        table("way", times, times**3 - times)
        + wheel(inertia=0.5, spin=-2.0).replace(
            'kind = "revolute"', 'kind = "revolute"\ndrive = { expression = "2 * way(t)" }'
        )
        + ('[signals.M]\nkind = "reaction"\njoint = "axle"\nquantity = "moment"\ncomponent = "z"\n')
    )
    t, s, _ = run(tmp_path, text, 1.0, 0.05)
    np.testing.assert_allclose(s["angle"], 2 * (t**3 - t), atol=1e-9)
    np.testing.assert_allclose(s["M"], 0.5 * 12 * t, atol=1e-7)


def test_rate_of_a_table(tmp_path):
    """`rate` takes the slope of the curve: a damper by the rate of a table of the coordinate."""
    text = table("bend", [-2, 0, 1, 3], [-4, 0, 2, 6]) + carriage(
        force("s", "coordinate_force", joint="rail", expression="-9 * x - 0.5 * rate(bend(x))"),
        speed=1.0,
    )
    t, s, _ = run(tmp_path, text, 2.0, 0.1)
    r = np.sqrt(9 - 0.25)
    np.testing.assert_allclose(s["x"], np.exp(-0.5 * t) * np.sin(r * t) / r, atol=1e-9)


@pytest.mark.parametrize(
    ("tables", "expression", "words"),
    [
        ("", "-spring_curve(x)", "there is no function `spring_curve`"),
        (table("spring_curve", X, Y), "-sprig_curve(x)", "did you mean 'spring_curve'"),
        (table("spring_curve", X, Y), "-spring_curve(x, 2)", "too many or too few arguments"),
        (table("spring_curve", X, Y), "-spring_curve", "is a function; expected its arguments"),
        (table("sin", X, Y), "-x", "tables.sin: is a function of expressions"),
        (
            table("k", X, Y) + "[parameters]\nk = 1.0\n",
            "-x",
            "tables.k: is one of [parameters] too",
        ),
        (table("a", X[::-1], Y), "-x", ": x[1] = 0.5: expected more than 2, x must ascend"),
        (table("a", X, Y[:-1]), "-x", ": expected as many y as x, two at least, got 5, 4"),
        (table("a", X, Y, interpolation="spline"), "-x", "tables.a.interpolation"),
        ('[tables.a]\nfile = "none.csv"\n', "-x", "none.csv: cannot be read"),
        ("[tables.a]\n", "-x", "tables.a = {}: expected `x` and `y`, or `file`"),
    ],
)
def test_bad_input(tmp_path, tables, expression, words):
    text = tables + carriage(force("f", "coordinate_force", joint="rail", expression=expression))
    with pytest.raises(InputError) as caught:
        run(tmp_path, text, 0.1, 0.1)
    assert words in str(caught.value)


def test_a_drive_needs_a_smooth_table(tmp_path):
    text = table("way", [0, 1, 2], [0, 1, 1], interpolation="linear") + wheel().replace(
        'kind = "revolute"', 'kind = "revolute"\ndrive = { expression = "way(t)" }'
    )
    with pytest.raises(InputError, match=r"calls tables\.way, whose rate jumps"):
        run(tmp_path, text, 0.1, 0.1)
