"""Explicit methods beyond the highest mode, and stiff modes beside slow motion."""

import numpy as np
import pytest
from samples.constraint_runs import new_run, prepared
from samples.stability_samples import amplitude, hand, stepped

from plymotion.solver.dynamics.elements.constraints.treatment import Treatment
from plymotion.solver.integrators.explicit import RungeKutta5, RungeKutta8, stability_limit
from plymotion.solver.integrators.generic.advice import fastest_motion
from plymotion.solver.integrators.generic.drive import integrate
from plymotion.solver.integrators.generic.gear import Gear

INDEX_1 = Treatment("index1")
METHODS = {"rk5": RungeKutta5, "rk8": RungeKutta8}


def stability_function(kind, z):
    """Growth per step on y' = lambda y at z = h lambda, from the tableau alone."""
    A, B = kind.tableau.A, kind.tableau.B
    s = B.size
    return 1.0 + z * B @ np.linalg.solve(np.eye(s) - z * A, np.ones(s))


@pytest.mark.parametrize("name", METHODS)
@pytest.mark.parametrize("damping", [0.0, 0.01, 0.1, 0.7, 1.0])
def test_limit_of_stability(name, damping):
    """The growth passes one there; directions near the imaginary axis count as less damped."""
    kind, doubt = METHODS[name], 0.01
    limit = stability_limit(kind.tableau, complex(-damping, (1 - damping**2) ** 0.5))
    damped = max(damping - doubt, 0.0)
    direction = complex(-damped, (1 - damped**2) ** 0.5)
    assert abs(stability_function(kind, 0.99 * limit * direction)) <= 1.0
    assert abs(stability_function(kind, 1.01 * limit * direction)) > 1.0


@pytest.mark.parametrize("damping", [0.0, 0.02, 0.3, 0.9])
def test_direction_of_the_fastest_motion(damping):
    w = np.array([1.0, 300.0])
    J = np.block([[np.zeros((2, 2)), np.eye(2)], [-np.diag(w**2), -2 * damping * np.diag(w)]])
    found = fastest_motion(lambda t, y: J @ y, 0.0, np.ones(4), np.full(4, 1e6))
    assert found.direction.real == pytest.approx(-damping, abs=1e-3)
    assert found.rate == pytest.approx(300.0, rel=1e-2 if damping == 0.0 else 3.0)


def _highest_mode(name, w_h, n_step):
    sample, w = hand("fixed", bent=(0.0, 0.0, 0.0, 1e-9))
    model, y0 = prepared(sample, INDEX_1)
    h = w_h / w[3]
    options = {"fixed_step": h, "rtol": 1e-6, "atol": 1e-9}
    made = new_run(model, y0, INDEX_1, name, n_step * h, **options)
    return stepped(made, amplitude(model, 3, w[3])), made


@pytest.mark.parametrize(
    ("name", "w_h"), [("rk5", 0.9), ("rk5", 1.5), ("rk5", 3.6), ("rk8", 5.0), ("rk8", 6.6)]
)
def test_growth_on_the_highest_mode_is_the_stability_function(name, w_h):
    values, _ = _highest_mode(name, w_h, 25)
    expected = abs(stability_function(METHODS[name], 1j * w_h))
    assert (values[-1] / values[0]) ** (1 / 24) == pytest.approx(expected, rel=1e-3)


@pytest.mark.parametrize(("name", "below", "above"), [("rk5", 0.9, 3.6), ("rk8", 5.9, 6.6)])
def test_beyond_the_highest_mode_a_run_ends_with_words(name, below, above):
    values, made = _highest_mode(name, below, 300)
    assert made.status == "finished"
    assert values.max() <= values[0] * (1 + 1e-9)
    _, made = _highest_mode(name, above, 2000)
    assert made.status == "failed"
    for words in ("highest mode", "radau", "generalized-alpha", "max_order = 2", "fewer modes"):
        assert words in made.message


def _stiff(zeta):
    """A pendulum's swing, and a mode of 2000 rad/s that follows its centrifugal force."""
    w = 2000.0

    def f(t, y):
        pull = y[2] - 1e-4 * y[1] ** 2
        return np.array([y[1], -np.sin(y[0]), y[3], -w * w * pull - 2 * zeta * w * y[3]])

    return f


@pytest.mark.parametrize("zeta", [0.0, 0.05])
def test_a_stiff_mode_costs_explicit_methods_their_step_and_implicit_ones_nothing(zeta):
    start, t_end = np.array([1.0, 0.0, 0.0, 0.0]), 2.0
    explicit = integrate(
        RungeKutta8(_stiff(zeta), 0.0, start, t_end, rtol=1e-5, atol=1e-7), [t_end]
    )
    assert explicit.status == "finished"
    h_w = t_end / explicit.counters.steps * 2000.0
    assert 2.0 < h_w < 6.2
    fifth = integrate(RungeKutta5(_stiff(zeta), 0.0, start, t_end, rtol=1e-5, atol=1e-7), [t_end])
    assert fifth.counters.rejected < 0.01 * fifth.counters.steps, "below the limit"
    limit = stability_limit(RungeKutta5.tableau, complex(-zeta, (1 - zeta**2) ** 0.5))
    assert 0.9 * limit < t_end / fifth.counters.steps * 2000.0 < limit
    (hint,) = explicit.hints
    assert "stability" in hint
    assert "gear" in hint
    assert "radau" in hint

    implicit = integrate(
        Gear(_stiff(zeta), 0.0, start, t_end, max_order=2, rtol=1e-5, atol=1e-7), [t_end]
    )
    assert implicit.status == "finished"
    assert not implicit.hints
    assert implicit.counters.evaluations < explicit.counters.evaluations / 20
    np.testing.assert_allclose(implicit.y[-1, :2], explicit.y[-1, :2], atol=5e-4)


def test_thin_and_stiff_modes_of_a_body_that_swings():
    """The hinged hand under gravity: modes up to 45 000 rad/s beside a swing of seconds."""
    sample, w = hand("revolute", gravity=True)
    t_end, runs = 0.03, {}
    closed = [(name, "projection") for name in ("rk5", "gear", "radau")]
    for name, treatment in (*closed, ("generalized-alpha", "ggl")):
        model, y0 = prepared(sample, Treatment(treatment))
        atol = np.full(y0.size, 1e-2)  # what vibrates by less than 1e-5 m does not count
        atol[: model.n_pos] = 1e-5
        options = {"rtol": 1e-3, "atol": atol} | ({"max_order": 2} if name == "gear" else {})
        made = new_run(model, y0, Treatment(treatment), name, t_end, **options)
        runs[name] = integrate(made, [t_end])
        assert runs[name].status == "finished"
    steps = {name: run.counters.steps for name, run in runs.items()}
    assert t_end / steps["rk5"] * w[3] < 1.0
    assert "stability" in runs["rk5"].hints[0]
    for name in ("gear", "radau", "generalized-alpha"):
        assert t_end / steps[name] * w[3] > 20.0
        assert not runs[name].hints
        angle = 2 * (runs[name].y[-1] - runs["rk5"].y[-1])[6]
        assert abs(angle) < 1e-3
