"""The compiled step loops of rk8 and rk5 take the steps of the classes for plain equations."""

import numpy as np
import pytest
from samples.constraint_runs import new_run, prepared
from samples.mechanism_samples import chain
from samples.two_body_samples import two_bodies

from plymotion.solver.dynamics.elements.constraints.treatment import Treatment
from plymotion.solver.integrators.explicit import ExplicitLoop
from plymotion.solver.integrators.generic.drive import integrate
from plymotion.solver.integrators.step_loop import projection, right_hand_side
from plymotion.solver.integrators.table import new_integrator
from plymotion.solver.math.laws import polynomial


def _pair(name, treatment, sample, t_end, **options):
    """The loop, and the class for plain equations, at the same start."""
    model, y0 = prepared(sample, Treatment(treatment))
    loop = new_run(model, y0, Treatment(treatment), name, t_end, **options)
    assert isinstance(loop, ExplicitLoop)
    if treatment == "projection":
        options = options | {"project": projection(model)}
    starts = [0, model.n_pos, model.n_pos + model.n_vel]
    f = right_hand_side(model)
    return loop, new_integrator(name, f, 0.0, y0, t_end, block_starts=starts, **options)


@pytest.mark.parametrize("name", ["rk8", "rk5"])
@pytest.mark.parametrize("treatment", ["projection", "baumgarte"])
@pytest.mark.parametrize("options", [{}, {"max_step": 0.01}, {"fixed_step": 0.01}])
def test_steps_and_outputs_are_those_of_the_class(name, treatment, options):
    sample = two_bodies(400.0, drive=polynomial([0.0, 0.0, 3.0]))
    options = {"rtol": 1e-5, "atol": 1e-7} | options
    times = np.linspace(0.0, 0.4, 11)
    loop, plain = _pair(name, treatment, sample, 0.4, **options)
    stride, one_by_one = integrate(loop, times), integrate(plain, times)
    assert stride.status == one_by_one.status == "finished"
    assert stride.counters.steps == one_by_one.counters.steps
    assert stride.counters.rejected == one_by_one.counters.rejected
    assert stride.counters.evaluations == one_by_one.counters.evaluations + 1  # its own start
    np.testing.assert_allclose(stride.y, one_by_one.y, rtol=1e-9, atol=1e-10)


# With rk5 at 1e-7 one estimate almost vanishes, and its rounding is seen in the size of a step.
@pytest.mark.parametrize(("name", "rtol"), [("rk8", 1e-7), ("rk5", 1e-5)])
def test_sizes_of_steps_are_those_of_the_class(name, rtol):
    loop, plain = _pair(name, "projection", chain(3), 1.0, rtol=rtol, atol=0.01 * rtol)
    sizes = []
    for made in (loop, plain):
        found = []
        integrate(made, [1.0], lambda i, found=found: found.append((i.t, i.h)))
        sizes.append(found)
    # Errors of 1e-9 are what is left of sums of size 1: the sizes agree to 1e-7 of the largest.
    np.testing.assert_allclose(*sizes, atol=1e-8)


@pytest.mark.parametrize("name", ["rk8", "rk5"])
def test_a_stiff_motion_leaves_the_hint_of_the_class(name):
    """Modes with a damper far faster than the motion."""
    sample = two_bodies(1e4, damping=2e3)
    hints = []
    for made in _pair(name, "projection", sample, 0.5, rtol=1e-2, atol=1e-3):
        assert integrate(made, [0.5]).status == "finished"
        hints.append([hint.split(":")[0] for hint in made.hints])
    assert hints[0] == hints[1] == ["stiff"]
