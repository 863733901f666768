"""SUNDIALS' IDA: the message where it is not installed, and the contract where it is."""

import importlib.util

import numpy as np
import pytest
from ida_integrator import SundialsIda
from samples.constraint_runs import new_run, prepared, run
from samples.mechanism_samples import chain, four_bars, pendulum

from plymotion.solver.dynamics.elements.constraints.treatment import Treatment
from plymotion.solver.errors import InputError
from plymotion.solver.integrators.generic.drive import StopRequest, integrate

GGL = Treatment("ggl")
HERE = importlib.util.find_spec("sksundae") is not None
installed = pytest.mark.skipif(not HERE, reason="scikit-sundae is not installed")


def _ida(sample=pendulum, t_end=1.0, **options):
    return new_run(*prepared(sample(), GGL), GGL, "ida", t_end, **options)


@pytest.mark.skipif(HERE, reason="scikit-sundae is installed")
def test_the_message_says_what_to_install():
    with pytest.raises(InputError, match=r"not installed: pip install scikit-sundae"):
        _ida()


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"formulation": "index3"}, "formulation: expected one of ggl"),
        ({"project": lambda t, y: y}, "project"),
    ],
)
def test_wrong_options_are_named(options, words):
    model, y0 = prepared(pendulum(), GGL)
    with pytest.raises(ValueError, match=words):
        SundialsIda(model, 0.0, y0, 1.0, **options)


@installed
def test_a_fixed_step_is_refused():
    with pytest.raises(ValueError, match="fixed_step"):
        _ida(fixed_step=0.01)


@installed
@pytest.mark.parametrize("make", [pendulum, lambda: chain(2, "spherical")])
def test_motion_is_that_of_our_own(make):
    times = np.array([0.0, 0.1, 0.1001, 0.5])
    exact = run(make(), "projection", times, rtol=1e-11).solution
    done = run(make(), "ggl", times, "ida", rtol=1e-7)
    assert done.solution.status == "finished", done.solution.message
    np.testing.assert_array_equal(done.solution.t, times)
    assert np.abs(done.solution.y - exact.y).max() < 1e-4
    assert done.position.max() < 1e-6
    assert done.velocity.max() < 1e-5
    c = done.solution.counters
    assert c.steps == done.t.size - 1
    assert c.evaluations > c.steps
    assert 0 < c.jacobians < c.steps


@installed
def test_stops_limits_and_interruption():
    assert integrate(_ida(max_step=0.01), [1.0]).counters.steps >= 100
    done = integrate(
        _ida(), [0.0, 1.0], lambda i: StopRequest(i.t, "enough") if i.t > 0.4 else None
    )
    assert (done.status, done.message) == ("stopped", "enough")

    made = _ida()
    unbalanced = made._unbalanced

    def until_enough(t, Y, Y_d):
        if t > 0.5:
            raise KeyboardInterrupt
        return unbalanced(t, Y, Y_d)

    made._unbalanced = until_enough
    done = integrate(made, np.linspace(0.0, 1.0, 21))
    assert done.status == "interrupted"
    assert 0.3 < done.t[-1] <= 0.5


@installed
def test_redundant_constraints_end_with_words():
    done = integrate(_ida(lambda: four_bars(1)), [1.0])
    assert done.status == "failed"
    assert "3 of 20 constraint equations are redundant" in done.message
    assert "generalized-alpha" in done.message
