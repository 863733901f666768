"""The contract: status instead of exceptions, outputs where asked, limits kept."""

import numpy as np
import pytest
from samples.constraint_runs import new_generic
from scipy_integrators import SCIPY

from plymotion.solver.integrators.explicit import RungeKutta8
from plymotion.solver.integrators.generic.drive import StopRequest, integrate
from plymotion.solver.integrators.generic.gear import Gear
from plymotion.solver.integrators.table import FOR_EQUATIONS, INTEGRATORS

ALL = pytest.mark.parametrize("name", sorted(FOR_EQUATIONS | SCIPY))
WITH_JACOBIAN = ("gear", "scipy-bdf", "scipy-radau")  # LSODA needs none where nothing is stiff


def oscillator(t, y):
    return np.array([y[1], -y[0]])


def exact(t):
    return np.stack((np.cos(t), -np.sin(t)), axis=-1)


def run(name, f=oscillator, t_end=5.0, y0=(1.0, 0.0), **options):
    return new_generic(name, f, 0.0, np.array(y0), t_end, **options)


@ALL
def test_output_at_requested_times_including_both_ends(name):
    t = np.array([0.0, 0.1, 0.1001, 2.0, np.pi, 5.0])
    solution = integrate(run(name, rtol=1e-8, atol=1e-10), t)
    assert solution.status == "finished"
    assert "5 s" in solution.message
    np.testing.assert_array_equal(solution.t, t)
    np.testing.assert_array_equal(solution.y[0], [1.0, 0.0])
    np.testing.assert_allclose(solution.y, exact(t), atol=3e-6)


@ALL
def test_asking_for_output_changes_no_step(name):
    few = integrate(run(name), [5.0])
    many = integrate(run(name), np.linspace(0, 5, 333))
    assert few.counters.steps == many.counters.steps
    np.testing.assert_array_equal(few.y[-1], many.y[-1])


def test_rk8_pays_for_dense_output_only_in_steps_that_need_it():
    none = integrate(run("rk8"), [5.0]).counters
    one = integrate(run("rk8"), [1.23, 1.2301, 5.0]).counters
    assert one.evaluations == none.evaluations + 3


@pytest.mark.parametrize(
    ("times", "words"),
    [
        ([0.0, 1.0, 1.0], "ascending"),
        ([1.0, 0.5], "ascending"),
        ([0.0, np.nan], "ascending"),
        ([0.0, 6.0], r"6\.0"),
        ([-1.0, 2.0], r"-1\.0"),
        ([], "non-empty"),
    ],
)
def test_wrong_output_times_are_named(times, words):
    with pytest.raises(ValueError, match=words) as error:
        integrate(run("rk8"), times)
    assert "t_out" in str(error.value)


@ALL
def test_stop_request_keeps_everything_up_to_the_stop(name):
    def at_crossing(integrator):
        if integrator.y[0] > 0:
            return None
        a, b = integrator.t_old, integrator.t
        solution = integrator.dense_output()
        for _ in range(60):
            middle = (a + b) / 2
            a, b = (middle, b) if solution(middle)[0] > 0 else (a, middle)
        return StopRequest(b, "the oscillator passed zero", "zero")

    solution = integrate(
        run(name, rtol=1e-8, atol=1e-10), np.linspace(0, 5, 51), on_step=at_crossing
    )
    assert (solution.status, solution.code) == ("stopped", "zero")
    assert solution.message == "the oscillator passed zero"
    assert solution.t[-1] == pytest.approx(np.pi / 2, abs=1e-6)
    np.testing.assert_array_equal(solution.t[:-1], np.linspace(0, 5, 51)[:16])
    np.testing.assert_allclose(solution.y, exact(solution.t), atol=1e-6)


def test_a_stop_on_a_requested_time_gives_one_row_for_it():
    solution = integrate(
        run("rk8", max_step=0.5),
        [0.0, 1.25, 2.0],
        on_step=lambda i: StopRequest(1.25, "enough") if i.t >= 1.25 else None,
    )
    np.testing.assert_array_equal(solution.t, [0.0, 1.25])


def test_a_stop_outside_the_step_is_refused():
    with pytest.raises(ValueError, match="t_stop"):
        integrate(run("rk8"), [5.0], on_step=lambda i: StopRequest(i.t + 1.0, "later"))


@ALL
def test_a_derivative_that_becomes_nan_ends_as_failed(name):
    def broken(t, y):
        return oscillator(t, y) if t < 2 else np.full(2, np.nan)

    solution = integrate(run(name, broken), np.linspace(0, 5, 51))
    assert solution.status == "failed"
    assert "not finite" in solution.message
    assert 1.5 < solution.t[-1] <= 2
    np.testing.assert_allclose(solution.y, exact(solution.t), atol=1e-3)


@ALL
def test_a_derivative_that_is_nan_at_once(name):
    integrator = run(name, lambda t, y: np.full(2, np.nan))
    assert integrator.status == "failed"
    solution = integrate(integrator, [0.0, 5.0])
    assert solution.status == "failed"
    assert "start" in solution.message
    np.testing.assert_array_equal(solution.t, [0.0])


@ALL
def test_a_singular_matrix_in_the_derivative_is_reported_not_raised(name):
    def singular(t, y):
        M = np.eye(2) if t < 1 else np.zeros((2, 2))
        return np.linalg.solve(M, oscillator(t, y))

    solution = integrate(run(name, singular), [0.0, 5.0])
    assert solution.status == "failed"
    assert "LinAlgError" in solution.message
    assert 0.5 < solution.t[-1] <= 1


@ALL
def test_a_programming_error_in_the_derivative_is_not_swallowed(name):
    def wrong(t, y):
        return oscillator(t, y) if t < 1 else y["position"]

    with pytest.raises(IndexError):
        integrate(run(name, wrong), [5.0])


@ALL
def test_a_singularity_ends_as_failed_with_advice(name):
    """y' = y^2 from 1 has no solution beyond t = 1."""
    solution = integrate(run(name, lambda t, y: y * y, 2.0, (1.0,), rtol=1e-6), [0.0, 0.5, 2.0])
    assert solution.status == "failed"
    assert "step" in solution.message
    assert "Look for" in solution.message
    assert solution.t[-1] == pytest.approx(1.0, abs=1e-3)
    assert solution.y[1, 0] == pytest.approx(2.0, rel=1e-4)


@ALL
def test_user_limits_of_the_step(name):
    integrator = run(name, max_step=0.05)
    steps = []
    integrate(integrator, [5.0], on_step=lambda i: steps.append(i.h))
    assert max(steps) <= 0.05 * 1.01 * (1 + 1e-12)
    strict = integrate(run(name, min_step=1.0, rtol=1e-10), [5.0])
    assert strict.status == "failed"
    assert "below 1 s" in strict.message


@ALL
def test_an_interrupted_run_keeps_its_part(name):
    calls = 0

    def until_the_user_has_enough(t, y):
        nonlocal calls
        calls += 1
        if t > 3:
            raise KeyboardInterrupt
        return oscillator(t, y)

    solution = integrate(run(name, until_the_user_has_enough), np.linspace(0, 5, 51))
    assert solution.status == "interrupted"
    assert 1 < solution.t[-1] <= 3
    assert len(solution.t) == len(solution.y) > 10
    np.testing.assert_allclose(solution.y, exact(solution.t), atol=1e-3)
    assert solution.counters.evaluations == calls


@pytest.mark.parametrize("cap", [1, 2, 3, 5])
def test_order_cap(cap):
    orders = []
    gear = Gear(oscillator, 0.0, np.array([1.0, 0.0]), 3.0, max_order=cap, rtol=1e-5, atol=1e-7)
    integrate(gear, [3.0], on_step=lambda i: orders.append(i.order))
    assert max(orders) == cap
    assert orders[0] == 1


@ALL
def test_counters_count(name):
    calls = 0

    def counted(t, y):
        nonlocal calls
        calls += 1
        return oscillator(t, y)

    steps = []
    solution = integrate(run(name, counted), [5.0], on_step=lambda i: steps.append(i.t))
    assert solution.counters.evaluations == calls
    assert solution.counters.steps == len(steps)
    assert steps[-1] == 5.0
    assert (solution.counters.jacobians > 0) == (name in WITH_JACOBIAN)
    assert (solution.counters.factorisations > 0) == (name in WITH_JACOBIAN)


@ALL
def test_a_derivative_may_reuse_its_buffer(name):
    buffer = np.empty(2)

    def in_place(t, y):
        buffer[0], buffer[1] = y[1], -y[0]
        return buffer

    t = np.linspace(0, 5, 11)
    np.testing.assert_array_equal(integrate(run(name, in_place), t).y, integrate(run(name), t).y)


@ALL
def test_stepping_an_ended_run_is_a_programming_error(name):
    integrator = run(name)
    integrate(integrator, [5.0])
    with pytest.raises(RuntimeError, match="finished"):
        integrator.step()


@ALL
def test_a_run_can_be_continued(name):
    integrator = run(name, rtol=1e-8, atol=1e-10)
    first = integrate(
        integrator, [0.0, 5.0], on_step=lambda i: StopRequest(i.t, "pause") if i.t > 2 else None
    )
    assert first.status == "stopped"
    second = integrate(integrator, [4.0, 5.0])
    assert second.status == "finished"
    np.testing.assert_allclose(second.y, exact(second.t), atol=1e-6)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"rtol": 0.0}, "rtol"),
        ({"atol": -1.0}, "atol"),
        ({"atol": np.array([1.0, np.nan])}, "atol"),
        ({"max_step": 0.0}, "max_step"),
        ({"first_step": -1.0}, "first_step"),
        ({"min_step": 2.0, "max_step": 1.0}, "min_step"),
        ({"block_starts": [1]}, "block_starts"),
        ({"block_starts": [0, 2]}, "block_starts"),
        ({"fixed_step": np.inf}, "fixed_step"),
        ({"max_ordr": 2}, "did you mean 'max_order'"),
        ({"max_order": 6}, "max_order"),
        ({"fixed_order": 2}, "fixed_step"),
        ({"past": ([0.5], np.zeros((1, 2)))}, "past"),
    ],
)
def test_wrong_options_are_named(options, words):
    with pytest.raises(ValueError, match=words):
        run("gear", **options)


def test_wrong_names_and_starts():
    with pytest.raises(ValueError, match="did you mean 'gear'"):
        run("gaer")
    with pytest.raises(ValueError, match=r"option.*rtol.*max_order"):
        run("rk8", max_order=2)
    with pytest.raises(ValueError, match="t_end"):
        run("rk8", t_end=0.0)
    with pytest.raises(ValueError, match="y0"):
        run("rk8", y0=(np.inf, 0.0))
    with pytest.raises(ValueError, match="shape"):
        run("rk8", f=lambda t, y: np.zeros(3))


def test_a_component_with_infinite_atol_is_left_out_of_the_control():
    def with_quadrature(t, y):
        return np.array([y[1], -y[0], 1e6 * np.sin(40 * t)])

    loose = np.array([1e-9, 1e-9, np.inf])
    plain = integrate(run("rk8"), [5.0]).counters
    carried = integrate(run("rk8", with_quadrature, y0=(1.0, 0.0, 0.0), atol=loose), [5.0]).counters
    assert carried.steps <= 1.5 * plain.steps
    gear = integrate(run("gear", with_quadrature, y0=(1.0, 0.0, 0.0), atol=loose), [5.0])
    assert gear.status == "finished"


def test_blocks_protect_a_small_group_from_being_averaged_away():
    def many(t, y):
        return np.concatenate((oscillator(t, y), np.zeros(98)))

    y0 = np.zeros(100)
    y0[0] = 1.0
    one = RungeKutta8(many, 0.0, y0, 5.0)
    two = RungeKutta8(many, 0.0, y0, 5.0, block_starts=[0, 2])
    alone = RungeKutta8(oscillator, 0.0, y0[:2], 5.0)
    for integrator in (one, two, alone):
        integrate(integrator, [5.0])
    assert two.counters == alone.counters
    assert one.counters.steps < two.counters.steps


@pytest.mark.parametrize("name", ["radau", "gear", "generalized-alpha"])
def test_an_implicit_method_does_not_advise_one(name):
    """A run of generalized-alpha that ended: "use an implicit method if the problem is stiff"."""
    assert "implicit" not in INTEGRATORS[name].on_failure
