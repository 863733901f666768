"""Heavy loads on chains of light links, default settings: steps follow the load.

The links vibrate across the taut chain at up to 3e4 rad/s; the load swings at 1 rad/s. SciPy
integrates the angles of the links from the vertical.
"""

import numpy as np
import pytest
from samples.case_samples import rigid
from samples.coordinate_samples import DEFAULT, run
from samples.crane_samples import DENSITY, LOAD, WIRE, G, beam_crane, crane_text
from samples.segment_samples import run_of
from scipy.integrate import solve_ivp

from plymotion.solver.run.execution import execute

WAY, MOVES, T_END, STEP = 3.0, 3.0, 4.0, 0.05
LAW = {"value": WAY, "duration": MOVES}
DRIVE = f"drive = {{ smooth_step = {{ value = {WAY}, duration = {MOVES} }} }}"
ALPHA = 'integrator = "generalized-alpha"\nconstraints = "ggl"\nrtol = 1.26e-3'


def trolley(t):
    """Position and acceleration."""
    s = np.clip(t / MOVES, 0.0, 1.0)
    way = WAY * s**3 * (10.0 - 15.0 * s + 6.0 * s**2)
    return way, WAY * (60.0 * s - 180.0 * s**2 + 120.0 * s**3) / MOVES**2


def swing(t, links, mass, length, hook=0.0):
    """Path (x, down) of the end of the last link; the load is a body that far below it, or a point.

    The load has the radius of inertia 0.1^(1/2) m about its centre if it is a body.
    """
    n = links + (hook > 0.0)
    own = np.append(np.full(links, length), np.full(n - links, hook))
    below = np.tril(np.ones((n, n)), -1) * own
    arms = np.vstack([below + np.diag(np.where(np.arange(n) < links, own / 2.0, own))])
    masses = np.append(np.full(links, mass), np.full(n - links, LOAD))
    inertia = np.append(np.full(links, mass * length**2 / 12.0), np.full(n - links, 0.1 * LOAD))
    if hook == 0.0:
        arms, masses = np.vstack([arms, own]), np.append(masses, LOAD)

    def rate(t, y):
        q, w = y[:n], y[n:]
        J_x, J_z = arms * np.cos(q), arms * np.sin(q)
        M = (J_x.T * masses) @ J_x + (J_z.T * masses) @ J_z + np.diag(inertia)
        a_x = trolley(t)[1] - arms @ (np.sin(q) * w**2)
        a_z = G + arms @ (np.cos(q) * w**2)
        return np.append(w, np.linalg.solve(M, -(J_x.T * masses) @ a_x - (J_z.T * masses) @ a_z))

    # Within 1e-5 m of one with a tolerance of 1e-6, which takes six times as long.
    q = solve_ivp(rate, (0.0, t[-1]), np.zeros(2 * n), "Radau", t, rtol=1e-5, atol=1e-7).y[:links]
    return trolley(t)[0] + length * np.sin(q).sum(0), length * np.cos(q).sum(0)


def judged(summary, steps):
    """No more than so many steps, few attempts refused, nothing to warn of."""
    cost = summary["cost"]
    assert cost["steps"] < steps, cost
    assert cost["rejected"] < 0.2 * (cost["steps"] + cost["rejected"]), cost
    assert summary["warnings"] == []


@pytest.mark.parametrize(
    ("links", "mass", "length", "keys", "solver", "steps"),
    [
        (6, 0.05, 1.0, {}, DEFAULT, 200),  # 4026 without the tension in the matrix
        (20, 1e-3, 0.3, {}, DEFAULT, 200),  # 60,006
        (8, 0.05, 1.0, {"joint": "spherical"}, DEFAULT, 200),  # 4162
        (8, 0.05, 1.0, {"point": False}, DEFAULT, 200),  # 4181
        (8, 0.05, 1.0, {}, ALPHA, 2000),  # 9392
    ],
    ids=["six", "twenty", "balls", "body", "generalized-alpha"],
)
def test_crane(links, mass, length, keys, solver, steps, tmp_path):
    text = crane_text(links, mass, length, drive=DRIVE, **keys)
    t, s, summary = run(tmp_path, text, T_END, STEP, solver)
    x, down = swing(t, links, mass, length, 0.0 if keys.get("point", True) else 0.5)
    np.testing.assert_allclose(s["x"], x, atol=1e-4 * WAY)
    np.testing.assert_allclose(s["z"], -down, atol=1e-4 * WAY)
    judged(summary, steps)


def test_crane_of_wires():
    """Flexible links, held straight by the tension: 3931 steps without it in the matrix."""
    spec = run_of(*beam_crane(4, T_END, {"smooth_step": LAW}))
    result, summary = execute(spec, progress=False)
    y, down = swing(result.t, 4, DENSITY * np.pi * WIRE**2 / 4.0, 1.0)
    signals = {s.name: s.values for s in result.signals}
    np.testing.assert_allclose(signals["y"], y, atol=1e-3 * WAY)
    np.testing.assert_allclose(signals["x"], down, atol=1e-3 * WAY)
    judged(summary, 300)


def test_chain_that_spins(tmp_path):
    """100 kg at 20 rad/s hold four links of 1 g in line: 39,667 steps without the tension."""
    spin, links, mass = 20.0, 4, 1e-3
    text = "[ground.axle]\nposition = [0.0, 0.0, 0.0]\n"
    above = "ground.axle"
    for i in range(links):
        text += rigid(
            f"link{i}",
            mass,
            (2e-8, mass / 12.0, mass / 12.0),
            {"near": (0, 0, 0), "far": (1, 0, 0)},
            centre=(0.5, 0, 0),
            position=(i, 0, 0),
            velocity=(0, spin * i, 0),
            angular_velocity=(0, 0, spin),
        )
        text += f'[joints.pin{i}]\nkind = "revolute"\nbetween = ["{above}", "link{i}.near"]\n'
        text += "axis = [0.0, 0.0, 1.0]\n"
        above = f"link{i}.far"
    text += f'[masses.load]\nmass = 100.0\nat = "{above}"\n'
    for c in "xy":
        text += f'[signals.{c}]\nkind = "position"\nat = "{above}"\ncomponent = "{c}"\n'
    t, s, summary = run(tmp_path, text, 2.0, STEP, DEFAULT)
    np.testing.assert_allclose(s["x"], links * np.cos(spin * t), atol=1e-3)
    np.testing.assert_allclose(s["y"], links * np.sin(spin * t), atol=1e-3)
    judged(summary, 400)
