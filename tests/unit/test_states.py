"""`[states]`: values by differential equations that expressions read."""

import numpy as np
import pytest
from samples.case_samples import run_text
from scipy.integrate import solve_ivp

from plymotion.solver.errors import InputError

TEXT = """
[parameters]
w = 3.0
[ground.o]
position = [0.0, 0.0, 0.0]
[bodies.b]
kind = "rigid"
mass = 1.0
inertia = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
interfaces = { o = { position = [0.0, 0.0, 0.0] } }
[joints.j]
kind = "revolute"
between = ["ground.o", "b.o"]
[states.twice]  # of what is below: states may read those that follow
rate = "w * (state('slow') - state('twice'))"
[states.slow]
rate = "w * (sin(2*t) - state('slow'))"
start = "w/3"
[forces.f]
kind = "coordinate_force"
joint = "j"
expression = "state('slow')"
[forces.g]
kind = "coordinate_force"
joint = "j"
expression = "state('twice')"
[signals]
f = { kind = "force", of = "f" }
g = { kind = "force", of = "g" }
"""


def test_two_filters_in_a_row(tmp_path):
    t, found, _ = run_text(tmp_path, TEXT, t_end=2.0, step=0.1)
    expected = solve_ivp(lambda t, x: 3.0 * np.array([np.sin(2.0 * t) - x[0], x[0] - x[1]]),
                         (0.0, 2.0), [1.0, 0.0], t_eval=t, rtol=1e-10, atol=1e-12).y  # fmt: skip
    np.testing.assert_allclose([found["f"], found["g"]], expected, atol=1e-7)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ("state('slwo')", r"states\.twice\.rate.*no known state; did you mean 'slow'"),
        ("w * sloow", r"states\.twice\.rate"),
        ("rate(state('slow'))", r"states\.twice\.rate.*not known"),
    ],
)
def test_wrong_rates_are_named(tmp_path, given, words):
    text = TEXT.replace("w * (state('slow') - state('twice'))", given)
    with pytest.raises(InputError, match=words):
        run_text(tmp_path, text, t_end=2.0, step=0.1)
