"""Generalized-alpha keeps the contract of the integrators: status, outputs, limits, counters."""

from dataclasses import replace

import numpy as np
import pytest
from constraint_runs import new_run, prepared
from mechanism_samples import chain, pendulum

from plymotion.solver.dynamics.constraints.treatment import Treatment
from plymotion.solver.integrators.closures import constrained_system
from plymotion.solver.integrators.generic import StopRequest, integrate, new_constrained_integrator

BOTH = pytest.mark.parametrize("formulation", ["ggl", "index3"])


def _run(formulation, t_end=1.0, make=pendulum, **options):
    model, y0 = prepared(make(), Treatment(formulation))
    return new_run(model, y0, Treatment(formulation), "", t_end, **options)


def _broken(formulation, terms, **options):
    model, y0 = prepared(pendulum(), Treatment(formulation))
    system = constrained_system(model)
    changed = replace(system, terms=lambda t, y: terms(t, system.terms(t, y)))
    return new_constrained_integrator(
        "generalized-alpha", changed, 0.0, y0, 1.0, formulation=formulation, **options
    )


@BOTH
def test_output_at_requested_times_including_both_ends(formulation):
    times = np.array([0.0, 0.1, 0.1001, 0.7, 1.0])
    done = integrate(_run(formulation), times)
    assert done.status == "finished"
    np.testing.assert_array_equal(done.t, times)
    assert np.linalg.norm(done.y[3, :3]) == pytest.approx(1.0, abs=1e-6)


@BOTH
def test_stop_request(formulation):
    done = integrate(
        _run(formulation),
        [0.0, 1.0],
        lambda i: StopRequest(0.5 * (i.t_old + i.t), "enough", "code") if i.t > 0.4 else None,
    )
    assert (done.status, done.code, done.message) == ("stopped", "code", "enough")
    assert 0.35 < done.t[-1] <= 0.45


@BOTH
def test_interruption_keeps_the_part(formulation):
    def until_enough(t, terms):
        if t > 0.6:
            raise KeyboardInterrupt
        return terms

    done = integrate(_broken(formulation, until_enough), np.linspace(0, 1, 21))
    assert done.status == "interrupted"
    assert 0.4 < done.t[-1] <= 0.6


@BOTH
def test_equations_that_become_nan_end_as_failed(formulation):
    def nan(t, terms):
        return terms if t < 0.5 else terms._replace(f=np.nan * terms.f)

    done = integrate(_broken(formulation, nan), [0.0, 1.0])
    assert done.status == "failed"
    assert "not finite" in done.message
    assert 0.4 < done.t[-1] <= 0.5


@BOTH
def test_numerical_errors_are_reported_programming_errors_raised(formulation):
    def singular(t, terms):
        if t > 0.5:
            raise np.linalg.LinAlgError("singular matrix")
        return terms

    done = integrate(_broken(formulation, singular), [0.0, 1.0])
    assert done.status == "failed"
    assert "LinAlgError" in done.message

    def wrong(t, terms):
        return terms if t < 0.5 else terms.stiffness

    with pytest.raises(AttributeError):
        integrate(_broken(formulation, wrong), [1.0])


@BOTH
def test_constraints_that_cannot_be_met_end_as_failed(formulation):
    """From half way on, a rod that wants to be in two places at once."""

    def torn(t, terms):
        return terms if t < 0.5 else terms._replace(Phi=terms.Phi + 1.0, Phi_q=0 * terms.Phi_q)

    done = integrate(_broken(formulation, torn), [0.0, 1.0])
    assert done.status == "failed"
    assert done.t[-1] <= 0.5


@BOTH
def test_limits_and_counters(formulation):
    made = _run(formulation, make=lambda: chain(2), max_step=0.01)
    steps = []
    done = integrate(made, [1.0], lambda i: steps.append(i.h))
    assert max(steps) <= 0.01 * 1.01 * (1 + 1e-12)
    c = done.counters
    assert c.steps == len(steps)
    assert c.evaluations >= 2 * c.steps
    assert 1 <= c.jacobians < c.steps / 10
    assert c.factorisations >= c.steps


@BOTH
def test_a_run_can_be_continued(formulation):
    made = _run(formulation)
    first = integrate(made, [1.0], lambda i: StopRequest(i.t, "pause") if i.t > 0.4 else None)
    assert first.status == "stopped"
    assert integrate(made, [1.0]).status == "finished"


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"spectral_radius": 1.1}, "spectral_radius"),
        ({"spectral_radiu": 0.5}, "did you mean 'spectral_radius'"),
        ({"rtol": 0.0}, "rtol"),
        ({"max_step": -1.0}, "max_step"),
    ],
)
def test_wrong_options_are_named(options, words):
    model, y0 = prepared(pendulum(), Treatment("ggl"))
    with pytest.raises(ValueError, match=words):
        new_constrained_integrator(
            "generalized-alpha", constrained_system(model), 0.0, y0, 1.0, **options
        )


def test_wrong_names():
    model, y0 = prepared(pendulum(), Treatment("ggl"))
    system = constrained_system(model)
    with pytest.raises(ValueError, match="did you mean 'generalized-alpha'"):
        new_constrained_integrator("generalised-alpha", system, 0.0, y0, 1.0)
    with pytest.raises(ValueError, match="formulation"):
        new_constrained_integrator("generalized-alpha", system, 0.0, y0, 1.0, formulation="index2")
