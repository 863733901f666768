"""A free rigid body about its middle axis (Dzhanibekov): the accuracy that is asked for."""

import numpy as np
import pytest
from samples.case_samples import HEAD, computed_file
from scipy.integrate import solve_ivp

J, W, T_END = np.array([1.0, 2.0, 3.0]), np.array([0.01, 5.0, 0.01]), 20.0
BODY = f"""
[bodies.b]
kind = "rigid"
mass = 1.0
inertia = {np.diag(J).tolist()}
interfaces = {{ p = {{ position = [1.0, 0.0, 0.0] }} }}
angular_velocity = {W.tolist()}
[signals]
x = {{ kind = "position", at = "b.p", component = "x" }}
y = {{ kind = "position", at = "b.p", component = "y" }}
z = {{ kind = "position", at = "b.p", component = "z" }}
"""


def exact(t):
    """Place of the point to 2e-9, by Euler's equations and the rotation of its axis."""

    def rate(_, s):
        w, A = s[:3], s[3:].reshape(3, 3)
        turn = np.array([[0, -w[2], w[1]], [w[2], 0, -w[0]], [-w[1], w[0], 0]])
        return np.concatenate([-(turn @ (J * w)) / J, (A @ turn).ravel()])

    start = np.concatenate([W, np.eye(3).ravel()])
    found = solve_ivp(rate, (0, t[-1]), start, "DOP853", t, rtol=1e-10, atol=1e-11)
    return found.y[3:].reshape(3, 3, -1)[:, 0]


ALPHA = 'generalized-alpha"\nconstraints = "ggl'


@pytest.mark.parametrize(
    ("integrator", "rtol", "factor"), [("rk8", 1e-5, 4), ("rk8", 1e-6, 4), (ALPHA, 1e-4, 10)]
)
def test_errors_are_within_a_small_factor_of_what_is_asked(tmp_path, integrator, rtol, factor):
    solver = (
        f'[solver]\nt_end = {T_END}\noutput_step = 0.1\nintegrator = "{integrator}"\n'
        f"rtol = {rtol}\n[runs.base]\n"
    )
    result, _ = computed_file(tmp_path / "case.toml", HEAD + BODY + solver)
    found = np.array([signal.values for signal in result.signals])
    assert np.abs(found - exact(result.t)).max() < factor * rtol
