"""`[states]`: values by differential equations that expressions read."""

import re

import numpy as np
import pytest
from samples.case_samples import run_text
from scipy.integrate import solve_ivp

from plymotion.solver.dynamics.model.model import state_size
from plymotion.solver.errors import InputError
from plymotion.solver.mechanism import consistent

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


def test_velocities_of_the_start_are_checked_with_all_states(tmp_path, monkeypatch):
    """Compiled code reads past the end of a state that lacks them, without an error."""
    lengths, balance = set(), consistent.balance

    def noted(model, times, states):
        lengths.add(states.shape[1] - state_size(model))
        return balance(model, times, states)

    monkeypatch.setattr(consistent, "balance", noted)
    run_text(tmp_path, TEXT, t_end=0.1, step=0.1)
    assert lengths == {0}


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


def test_the_latch_of_the_page(repository, tmp_path):
    """A hinge that a torque opens stays where it is locked, against three times that torque."""
    page = (repository / "docs/friction.md").read_text("utf-8")
    (latch,) = re.findall(r"^```toml\n(.*?)^```", page, re.MULTILINE | re.DOTALL)
    text = TEXT.split("[joints.j]")[0].replace("w = 3.0", "opened = 1.5") + latch
    text += """[joints.hinge]
kind = "revolute"
between = ["ground.o", "b.o"]
[forces.spring]
kind = "coordinate_force"
joint = "hinge"
expression = "2 - 8*step(t - 3)"
[signals]
x = { kind = "joint", joint = "hinge", coordinate = "angle" }
"""
    t, found, summary = run_text(tmp_path, text, t_end=6.0, step=0.1)
    free = t < np.sqrt(1.5)
    np.testing.assert_allclose(found["x"][free], t[free] ** 2, atol=1e-6)
    np.testing.assert_allclose(found["x"][t > 2.0], 1.5, atol=0.03)
    assert found["x"][-1] == pytest.approx(1.5 - 6.0 / 5e3, abs=1e-4)
    assert summary["warnings"] == []
