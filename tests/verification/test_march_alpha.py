"""Generalized-alpha's compiled loop is the method of integrate/, step by step."""

import numpy as np
import pytest
from constraint_runs import new_run, prepared
from march_samples import two_bodies
from mechanism_samples import chain, pendulum
from stability_samples import hand, stepped

from plymotion.solver.dynamics.constraints.treatment import Treatment
from plymotion.solver.integrators.generic import integrate
from plymotion.solver.math.laws import polynomial

SAMPLES = {
    "pendulum": pendulum,
    "chain": lambda: chain(2, "spherical"),
    "flexible": lambda: two_bodies(400.0),
    "stiff": lambda: two_bodies(1e8),
    "driven": lambda: two_bodies(400.0, drive=polynomial([0.0, 0.0, 3.0, -2.0])),
    "hand": lambda: hand("revolute", gravity=True)[0],
}


def _both(sample, treatment, t_end, **options):
    """The integrators of march/ and of integrate/, fresh."""
    model, y0 = prepared(sample, treatment)
    return [new_run(model, y0, treatment, name, t_end, **options) for name in ("march", "")]


@pytest.mark.parametrize(
    ("formulation", "rho"), [("ggl", 0.8), ("ggl", 0.0), ("index3", 0.8), ("index3", 0.5)]
)
@pytest.mark.parametrize("name", SAMPLES)
def test_fixed_steps_are_the_same(name, formulation, rho):
    """Newton's iterations leave little over; ggl moves along the matrix that each one has.

    That of integrate/ holds stiffness by differences, all of it, this one the bodies' own.
    """
    treatment = Treatment(formulation, spectral_radius=rho)
    options = {"fixed_step": 0.005, "rtol": 1e-12, "atol": 1e-12}
    states = [
        stepped(made, lambda i: i.y.copy())
        for made in _both(SAMPLES[name](), treatment, 0.1, **options)
    ]
    assert len(states[0]) == len(states[1]) == 20
    np.testing.assert_allclose(*states, atol=1e-10 if formulation == "index3" else 2e-8)


@pytest.mark.parametrize("formulation", ["ggl", "index3"])
@pytest.mark.parametrize("name", ["chain", "flexible", "driven"])
def test_error_control_takes_the_same_steps(name, formulation):
    treatment = Treatment(formulation)
    times = np.linspace(0.0, 0.2, 9)
    done = [
        integrate(made, times)
        for made in _both(SAMPLES[name](), treatment, 0.2, rtol=1e-4, atol=1e-6)
    ]
    assert done[0].status == done[1].status == "finished"
    steps = [d.counters.steps for d in done]
    assert abs(steps[0] - steps[1]) <= 2 + 0.02 * steps[1]
    assert done[0].counters.evaluations <= done[1].counters.evaluations
    np.testing.assert_allclose(done[0].y, done[1].y, atol=1e-4)


@pytest.mark.parametrize("rho", [0.0, 0.8])
def test_what_is_not_resolved_is_damped(rho):
    """The welded hand, h w = 100: nothing is left for rho = 0, rho per step for others."""
    sample, w = hand("fixed", bent=(1e-6,))
    treatment = Treatment("ggl", spectral_radius=rho)
    model, y0 = prepared(sample, treatment)
    options = {"fixed_step": 100 / w[0], "rtol": 1e-9, "atol": 1e-14}
    made = new_run(model, y0, treatment, "march", 60 * 100 / w[0], **options)
    q = np.abs(stepped(made, lambda i: i.y[7]))
    assert made.status == "finished"
    assert q[-1] < 1e-2 * 1e-6
