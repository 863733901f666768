"""BDF of order 3 and above on the modes of a real body (one mode: test_integrators_growth)."""

import tomllib

import numpy as np
import pytest
from samples.constraint_runs import new_run, prepared
from samples.stability_samples import amplitude, hand, stepped

from plymotion.solver.dynamics.elements.constraints.treatment import Treatment
from plymotion.solver.integrators.generic.drive import integrate
from plymotion.solver.integrators.generic.gear import Gear

INDEX_1 = Treatment("index1")


@pytest.fixture(scope="module")
def growth(repository):
    """Order -> growth per step at w h = 1."""
    table = tomllib.loads((repository / "tests/reference/integrators/bdf_growth.toml").read_text())
    column = table["w_h"].index(1.0)
    return {int(order): row[column] for order, row in table["growth_per_step"].items()}


def _vibrating(w_h, n_step, bent=1e-9, **options):
    """The welded hand in its first mode, fixed steps; amplitudes, and the integrator."""
    sample, w = hand("fixed", bent=(bent,))
    model, y0 = prepared(sample, INDEX_1)
    h = w_h / w[0]
    options = {"fixed_step": h, "rtol": 1e-10, "atol": 1e-16} | options
    made = new_run(model, y0, INDEX_1, "gear", n_step * h, **options)
    return stepped(made, amplitude(model, 0, w[0])), made


@pytest.mark.parametrize("order", [2, 3, 4, 5, 6])
def test_the_first_mode_of_a_body_grows_by_the_root_of_the_formula(order, growth):
    """The first mode alone is in the state: the second, at w h = 6.2, is amplified by order 5."""
    values, made = _vibrating(1.0, 80, fixed_order=order)
    assert made.status == "finished"
    measured = (values[-1] / values[-30]) ** (1 / 29)
    assert measured == pytest.approx(growth[order], rel=0.01)


def test_growth_ends_the_run_with_the_remedy():
    """Grown to large motion, the run fails and says why; tolerances as cases have them.

    The weld's accelerations are zero but for rounding, some 1e-12 of those of the mode.
    """
    values, made = _vibrating(1.0, 1000, bent=1e-3, fixed_order=4, rtol=1e-6, atol=1e-6)
    assert made.status == "failed"
    assert made.counters.steps < 500
    assert values.max() > 1e3 * values[0]
    assert "max_order = 2" in made.message
    assert "error control" in made.message


def test_order_2_and_error_control_prevent_it():
    capped, made = _vibrating(1.0, 500, fixed_order=2)
    assert made.status == "finished"
    assert capped.max() <= 1.01 * capped[0]
    for max_order in (2, 5):
        controlled, made = _vibrating(
            1.0, 100, fixed_step=None, max_order=max_order, rtol=1e-4, atol=1e-12
        )
        assert made.status == "finished"
        assert controlled.max() < 1.01e-9


def test_a_run_kept_short_by_growth_is_told_of_the_cap():
    """A slow swing whose fast mode is of no interest: order 2 lets it die, and takes long steps."""

    def swing(t, y):
        follow = 1e-4 * y[1] ** 2
        return np.array([y[1], -np.sin(y[0]), y[3], -1e4 * (y[2] - follow)])

    start = np.array([1.0, 0.0, 0.0, 0.0])
    runs = {
        cap: integrate(Gear(swing, 0.0, start, 5.0, max_order=cap, rtol=1e-5, atol=1e-7), [5.0])
        for cap in (2, 5)
    }
    assert runs[5].counters.steps > 3 * runs[2].counters.steps
    assert len(runs[5].hints) == 1
    assert "max_order = 2" in runs[5].hints[0]
    assert "radau" in runs[5].hints[0]
    assert "a rate of 100 1/s" in runs[5].hints[0]
    assert not runs[2].hints
