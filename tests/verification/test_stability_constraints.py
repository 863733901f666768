"""Feedback too fast for the step, and index 3 without damping.

Singular positions, treatment by treatment: test_constraints_singular.
"""

import numpy as np
import pytest
from samples.constraint_runs import new_run, prepared
from samples.mechanism_samples import pendulum
from samples.stability_samples import stepped

from plymotion.solver.dynamics.elements.constraints.treatment import Treatment
from plymotion.solver.dynamics.evaluation.accelerations import assemble, constraint_rates
from plymotion.solver.integrators.generic.advice import of_feedback
from plymotion.solver.integrators.generic.drive import integrate

H = 0.02


def _opening(treatment, integrator, t_end=4.0, **options):
    """Joint of the pendulum A01 after each step [m], and the integrator."""
    model, y0 = prepared(pendulum(), treatment)
    options = {"rtol": 1e-8, "atol": 1e-10} | options
    made = new_run(model, y0, treatment, integrator, t_end, **options)
    return stepped(made, lambda i: abs(np.linalg.norm(i.y[:3]) - 1.0)), made


def _feedback(beta_h):
    return Treatment("baumgarte", alpha=beta_h / H, beta=beta_h / H)


@pytest.mark.parametrize(("name", "above"), [("rk5", 3.6), ("rk8", 6.6)])
def test_baumgarte_beyond_the_step_diverges(name, above):
    """beta h = 2 holds with both; the real axis of their stability ends at 3.3 and 6.1."""
    held, made = _opening(_feedback(2.0), name, fixed_step=H)
    assert made.status == "finished"
    assert held.max() < 1e-3
    lost, made = _opening(_feedback(above), name, fixed_step=H)
    assert made.status == "failed"
    assert lost.max() > 1.0
    assert made.t < 2.0
    assert '"projection"' in made.message
    assert "Baumgarte" in made.message


@pytest.mark.parametrize("name", ["rk5", "rk8"])
def test_projection_and_error_control_bear_what_baumgarte_does_not(name):
    closed, made = _opening(Treatment("projection"), name, fixed_step=H)
    assert made.status == "finished"
    assert closed.max() < 2e-12
    steps = {}
    for treatment in (_feedback(6.6), Treatment("projection")):
        model, y0 = prepared(pendulum(), treatment)
        made = new_run(model, y0, treatment, name, 1.0, rtol=1e-6, atol=1e-8)
        done = integrate(made, [1.0])
        assert done.status == "finished"
        steps[treatment.name] = done.counters.steps
    beta = 6.6 / H
    assert 0.2 < beta / steps["baumgarte"] < 2.0, "the step is the feedback's"
    assert steps["baumgarte"] > 10 * steps["projection"]
    (hint,) = of_feedback(beta, 1.0 / steps["baumgarte"], made.order)
    assert "projection" in hint
    assert not of_feedback(5.0, 1.0 / steps["projection"], made.order)


def _swinging(formulation, rho, **options):
    """Largest |Phidot| after each step, the changes of the multiplier, and the integrator."""
    treatment = Treatment(formulation)
    model, y0 = prepared(pendulum(), treatment)
    options = {"spectral_radius": rho, "rtol": 1e-8, "atol": 1e-10} | options
    made = new_run(model, y0, treatment, "generalized-alpha", 4.0, **options)

    def seen(i):
        equations = assemble(model, i.t, i.y)
        return np.abs(constraint_rates(model, equations, i.y)).max()

    return stepped(made, seen), made


def test_index_3_without_damping_swings_up_and_ends_with_words():
    violation, made = _swinging("index3", 1.0, fixed_step=H)
    assert made.status == "failed"
    n = 40
    assert violation[-n:].max() > 10 * violation[:n].max()
    assert "spectral_radius = 0.8" in made.message
    assert '"ggl"' in made.message
    assert "spectral_radius = 1" in made.hints[0]


@pytest.mark.parametrize(("formulation", "rho"), [("index3", 0.8), ("ggl", 1.0), ("ggl", 0.8)])
def test_damping_or_ggl_settles_it(formulation, rho):
    violation, made = _swinging(formulation, rho, fixed_step=H)
    assert made.status == "finished"
    assert not made.hints
    assert violation[-40:].max() < 1.1 * violation[:40].max()


def test_error_control_pays_for_index_3_without_damping():
    """What swings on is taken for motion and resolved: over 4 s in 58 000 steps instead of 450."""
    steps = {}
    for rho in (1.0, 0.8):
        treatment = Treatment("index3")
        model, y0 = prepared(pendulum(), treatment)
        options = {"spectral_radius": rho, "rtol": 1e-5, "atol": 1e-7}
        made = new_run(model, y0, treatment, "generalized-alpha", 1.4, **options)
        assert integrate(made, [1.4]).status == "finished"
        steps[rho] = made.counters.steps
    assert steps[1.0] > 5 * steps[0.8]
