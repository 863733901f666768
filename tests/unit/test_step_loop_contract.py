"""The compiled loops keep the contract of the integrators: status, outputs, limits, counters."""

import json

import numpy as np
import pytest
from harness.processes import this_python
from samples.constraint_runs import new_run, prepared
from samples.mechanism_samples import chain, pendulum
from samples.two_body_samples import torn, two_bodies

from plymotion.solver.dynamics.elements.constraints.treatment import Treatment
from plymotion.solver.integrators import step_loop
from plymotion.solver.integrators.generalized_alpha import GeneralizedAlpha
from plymotion.solver.integrators.generic.drive import StopRequest, integrate
from plymotion.solver.integrators.radau import Radau
from plymotion.solver.math.compiled import COMPILED
from plymotion.solver.math.laws import polynomial
from plymotion.solver.mechanism.assembly import assemble_model
from plymotion.solver.mechanism.tables import ForceTable, MarkerTable, rigid_body

IMPLICIT = [
    ("radau", "projection"),
    ("radau", "index1"),
    ("generalized-alpha", "ggl"),
    ("generalized-alpha", "index3"),
]
EXPLICIT = [("rk8", "projection"), ("rk5", "index1")]
ALL = pytest.mark.parametrize(("name", "treatment"), IMPLICIT + EXPLICIT)
WITH_NEWTON = pytest.mark.parametrize(("name", "treatment"), IMPLICIT)


def _new(name, treatment, t_end=0.3, sample=None, **options):
    model, y0 = prepared(sample or chain(2), Treatment(treatment))
    return new_run(model, y0, Treatment(treatment), name, t_end, **options)


def _pushed(law):
    return two_bodies(400.0, forces=[ForceTable("push", "force", 0, 4, (1.0, 0.0, 0.0), law)])


@ALL
@pytest.mark.parametrize("options", [{}, {"max_step": 0.01}, {"fixed_step": 0.02}])
def test_strides_are_the_steps_in_one_call(name, treatment, options):
    times = np.linspace(0.0, 0.3, 7)[::2]  # not in one piece
    stride = integrate(_new(name, treatment, **options), times)
    lengths = []
    steps = integrate(_new(name, treatment, **options), times, lambda i: lengths.append(i.h))
    assert stride.status == steps.status == "finished"
    assert stride.message == steps.message
    assert stride.counters == steps.counters
    assert len(lengths) == steps.counters.steps
    np.testing.assert_array_equal(stride.t, times)
    np.testing.assert_allclose(stride.y, steps.y, atol=1e-14)
    if "fixed_step" in options:
        np.testing.assert_allclose(lengths[:-1], 0.02, rtol=1e-12)
    if "max_step" in options:
        assert max(lengths) <= 0.01 * 1.01 * (1 + 1e-12)
    # asking for output changes no step
    few = integrate(_new(name, treatment, **options), [0.3])
    assert few.counters.steps == stride.counters.steps
    np.testing.assert_array_equal(few.y[-1], stride.y[-1])


@ALL
def test_start_and_end_of_a_step_are_in_its_dense_output(name, treatment):
    made = _new(name, treatment, fixed_step=0.02)
    made.step()
    before = made.y.copy()
    made.step()
    inside = made.dense_output()
    values = inside(np.array([made.t_old, made.t]))
    np.testing.assert_allclose(values, [before, made.y], atol=1e-10)
    assert inside(made.t).shape == (made.n,)
    made.step()
    np.testing.assert_allclose(inside(0.04), values[1], atol=1e-12)  # stays valid


@ALL
def test_stop_request_and_continuation(name, treatment):
    whole = integrate(_new(name, treatment), [0.3])
    made = _new(name, treatment)
    first = integrate(
        made,
        [0.0, 0.3],
        lambda i: StopRequest(0.5 * (i.t_old + i.t), "enough", "code") if i.t > 0.1 else None,
    )
    assert (first.status, first.code, first.message) == ("stopped", "code", "enough")
    assert 0.05 < first.t[-1] <= 0.12
    rest = integrate(made, [0.3])
    assert rest.status == "finished"
    np.testing.assert_array_equal(rest.y, whole.y)
    with pytest.raises(RuntimeError, match="finished"):
        made.step()


@ALL
def test_limits_of_the_step(name, treatment):
    strict = integrate(_new(name, treatment, min_step=0.1, rtol=1e-10), [0.3])
    assert strict.status == "failed"
    assert "below 0.1 s" in strict.message
    made = _new(name, treatment, first_step=1e-5)
    made.step()
    assert made.h == 1e-5
    assert _new(name, treatment, first_step=1)._workspace.clock.dtype == float


@WITH_NEWTON
def test_a_fixed_step_that_is_too_long_ends_as_failed(name, treatment):
    for on_step in (None, lambda i: None):
        done = integrate(_new(name, treatment, 5.0, fixed_step=1.0), [0.0, 5.0], on_step)
        assert done.status == "failed"
        assert "fixed step of 1 s fails" in done.message
        assert "does not converge" in done.message
        assert "shorter step" in done.message


@ALL
@pytest.mark.parametrize("law", [[0.0, 0.0, 0.0, 1e300], [1e200]])
@pytest.mark.parametrize("on_step", [None, lambda i: None])
def test_forces_beyond_all_measure_end_as_failed(name, treatment, law, on_step):
    done = integrate(_new(name, treatment, sample=_pushed(polynomial(law))), [0.0, 0.3], on_step)
    assert done.status == "failed"
    assert "step" in done.message
    assert np.isfinite(done.y).all()


@WITH_NEWTON
def test_forces_that_become_infinite_end_as_failed(name, treatment):
    """Half way the force jumps to inf: what was there is kept."""
    from plymotion.solver.math.laws import N_COEFFICIENT, Law

    coefficients = np.zeros((2, N_COEFFICIENT))
    coefficients[1] = polynomial([np.inf]).coefficients[0]
    law = Law(np.array([0.0, 0.1]), coefficients)
    done = integrate(_new(name, treatment, sample=_pushed(law)), np.linspace(0, 0.3, 13))
    assert done.status == "failed"
    # steps as short as rounding fail in index 3 for that alone
    assert "not finite" in done.message or treatment == "index3"
    assert 0.09 < done.t[-1] <= 0.1
    assert np.isfinite(done.y).all()


@ALL
def test_equations_that_are_not_finite_at_the_start(name, treatment):
    model, y0 = prepared(chain(2), Treatment(treatment))
    model = model._replace(gravity_G=np.full(3, np.inf))
    made = new_run(model, y0, Treatment(treatment), name, 1.0)
    done = integrate(made, [0.0, 1.0])
    assert done.status == "failed"
    assert "start" in done.message


@pytest.mark.parametrize(
    ("name", "treatment"),
    [("radau", "projection"), ("generalized-alpha", "ggl"), ("generalized-alpha", "index3")],
)
def test_constraints_that_contradict_end_as_failed(name, treatment):
    done = integrate(_new(name, treatment, 1.0, torn(), rtol=1e-4, atol=1e-6), [0.0, 1.0])
    assert done.status == "failed"
    assert "contradict" in done.message or "projected onto the constraints" in done.message
    assert done.t[-1] < 0.1


@ALL
def test_a_free_body(name, treatment):
    """No constraints: a spinning top thrown upwards, against rk8."""
    ball = rigid_body("ball", 1.0, np.zeros(3), np.diag([1.0, 2.0, 2.5]))
    model = assemble_model([ball], [MarkerTable(-1, np.zeros(3))], [], gravity_G=(0.0, -9.81, 0.0))
    y0 = np.zeros(14)
    y0[3], y0[7:13] = 1.0, (1.0, 2.0, 0.0, 0.1, 3.0, 0.2)
    exact = integrate(
        new_run(model, y0, Treatment("index1"), "rk8", 1.0, rtol=1e-10, atol=1e-12), [1.0]
    )
    made = new_run(model, y0, Treatment(treatment), name, 1.0, rtol=1e-5, atol=1e-7)
    done = integrate(made, [1.0])
    assert done.status == "finished"
    np.testing.assert_allclose(done.y, exact.y, atol=2e-3 if name == "generalized-alpha" else 1e-5)


@ALL
def test_an_interrupted_run_keeps_its_part(name, treatment, monkeypatch):
    """Ctrl-C inside a stride, as it is heard in plain NumPy, and between two."""
    monkeypatch.setattr(step_loop, "CHUNK", 5)
    made = _new(name, treatment, max_step=0.01)
    loop, calls = made._call, 0

    def until_enough(*arguments):
        nonlocal calls
        calls += 1
        if calls == 4:
            raise KeyboardInterrupt
        return loop(*arguments)

    monkeypatch.setattr(made, "_call", until_enough)
    done = integrate(made, np.linspace(0.0, 0.3, 61))
    assert done.status == "interrupted"
    assert made.counters.steps == 15
    assert done.t[-1] == made.t > 0.0
    assert f"t = {made.t:.9g} s" in done.message
    assert len(done.t) == len(done.y) > 2
    np.testing.assert_array_equal(done.y[-1], made.y)
    whole = integrate(_new(name, treatment, max_step=0.01), np.linspace(0.0, 0.3, 61))
    np.testing.assert_array_equal(done.y[:-1], whole.y[: len(done.y) - 1])


@WITH_NEWTON
def test_counters_count(name, treatment):
    steps = []
    done = integrate(_new(name, treatment), [0.3], lambda i: steps.append(i.t))
    c = done.counters
    assert c.steps == len(steps)
    assert steps[-1] == 0.3
    tried = c.steps + c.rejected
    closed = c.jacobians - tried  # matrices that close the joints after a step
    assert closed >= c.steps if treatment == "projection" else closed == 0
    assert c.factorisations == (2 if name == "radau" else 1) * tried + closed
    assert c.evaluations >= (4 if name == "radau" else 2) * c.steps


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"spectral_radius": 1.1}, "spectral_radius"),
        ({"formulation": "index2"}, "formulation"),
        ({"rtol": 0.0}, "rtol"),
        ({"max_step": -1.0}, "max_step"),
        ({"min_step": 2.0, "max_step": 1.0}, "min_step"),
        ({"block_starts": [1]}, "block_starts"),
    ],
)
def test_wrong_options_are_named(options, words):
    model, y0 = prepared(pendulum(), Treatment("ggl"))
    with pytest.raises(ValueError, match=words):
        GeneralizedAlpha(model, 0.0, y0, 1.0, **options)


def test_without_blocks_the_norm_is_over_all():
    model, y0 = prepared(pendulum(), Treatment())
    assert integrate(Radau(model, 0.0, y0, 0.1, block_starts=None), [0.1]).status == "finished"


def motions():
    """Whether it was compiled, and the motion of a driven flexible pair by each kind of loop."""
    rows = []
    implicit = ("generalized-alpha", "ggl")
    explicit = ("rk8", "projection")
    for name, treatment in (("radau", "projection"), ("radau", "baumgarte"), implicit, explicit):
        sample = two_bodies(400.0, drive=polynomial([0.0, 0.0, 3.0]))
        model, y0 = prepared(sample, Treatment(treatment))
        made = new_run(model, y0, Treatment(treatment), name, 0.2, rtol=1e-5, atol=1e-7)
        done = integrate(made, np.linspace(0.0, 0.2, 6))
        assert done.status == "finished", done.message
        rows.append(done.y.tolist())
    return COMPILED, rows


PLAIN = """
import json, sys
sys.path[:0] = sys.argv[1:]
from unit.test_step_loop_contract import motions
print(json.dumps(motions()))
"""


def test_compiled_loops_give_the_same_motion(repository):
    """The compiled path and plain NumPy are one set of formulas."""
    pytest.importorskip("numba")
    folders = repository / "tests", repository / "benchmarks"
    done = this_python("-c", PLAIN, *folders, more={"PLYMOTION_COMPILED": "0"})
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout), motions()
    assert [compiled for compiled, _ in found] == [False, True]
    for plain, compiled in zip(*(rows for _, rows in found), strict=True):
        np.testing.assert_allclose(plain, compiled, atol=1e-10)
