"""Long chains: their rows are independent, however little the last joint can move the chain."""

import numpy as np
import pytest
from samples.constraint_runs import new_run, prepared
from samples.mechanism_samples import bricard, chain, four_bars, pendulum
from samples.two_body_samples import two_bodies

from plymotion.solver.checks.constraint_rank import observe
from plymotion.solver.checks.singularity import SingularityMonitor
from plymotion.solver.dynamics.analysis.rank import degrees_of_freedom
from plymotion.solver.dynamics.elements.constraints.treatment import Treatment
from plymotion.solver.dynamics.elements.joints.table import DRIVES, NAMES
from plymotion.solver.dynamics.evaluation.accelerations import derivative_into
from plymotion.solver.dynamics.evaluation.elimination import is_tree
from plymotion.solver.dynamics.evaluation.series import along_solution
from plymotion.solver.dynamics.model.model import new_workspace
from plymotion.solver.dynamics.tolerances import REGULAR
from plymotion.solver.integrators.generic.drive import integrate
from plymotion.solver.math.laws import polynomial

LINKS = 400


@pytest.fixture(scope="module")
def long_chain():
    return prepared(chain(LINKS), Treatment("projection"))


@pytest.mark.parametrize(
    ("sample", "tree"),
    [
        (pendulum, True),
        (lambda: chain(3), True),
        (lambda: chain(3, "spherical"), True),
        (lambda: two_bodies(400.0), True),
        (lambda: four_bars(1), False),
        (bricard, False),
    ],
)
def test_mechanisms_without_loops_are_trees(sample, tree):
    assert is_tree(prepared(sample(), Treatment("projection"))[0]) == tree


def test_a_chain_of_1500_links_starts_without_dense_matrices(monkeypatch):
    """Its smallest singular value, 3e-7, alone would say that rows may depend on each other."""

    def refuse(*arrays, **options):
        raise AssertionError("a dense decomposition")

    monkeypatch.setattr(np.linalg, "svd", refuse)
    monkeypatch.setattr(np.linalg, "lstsq", refuse)
    model, y0 = prepared(chain(1500), Treatment("projection"))
    assert model.redundant == 0
    assert degrees_of_freedom(model, y0) == 1500


def test_a_joint_that_is_driven_twice_is_no_tree():
    model = two_bodies(400.0, drive=polynomial([0.0, 1.0])).model
    drives = np.flatnonzero([NAMES[kind] in DRIVES for kind in model.joint_kind])
    assert is_tree(model)
    again = [*range(len(model.joint_kind)), drives[0]]
    twice = model._replace(
        joint_kind=model.joint_kind[again], joint_marker=model.joint_marker[again]
    )
    assert not is_tree(twice)


def test_pivots_of_a_long_chain_are_as_small_as_those_of_dependent_rows(long_chain):
    model, y0 = long_chain
    work = new_workspace(model)
    derivative_into(model._replace(penalty=0.0), work, 0.0, y0, np.zeros(y0.size))
    assert work.factors.regular[0] < REGULAR


def test_radau_takes_a_long_chain_as_easily_as_a_short_one(long_chain):
    """Softened rows need three times the iterations with 512 links, and fail with 1024."""
    cost = {}
    for n in (8, LINKS):
        model, y0 = long_chain if n == LINKS else prepared(chain(n), Treatment("projection"))
        made = new_run(
            model, y0, Treatment("projection"), "radau", 0.02, fixed_step=1e-3, rtol=1e-6
        )
        solution = integrate(made, [0.02])
        assert solution.status == "finished"
        assert not made._workspace.frozen.softness.any()
        cost[n] = solution.counters.evaluations
    assert cost[LINKS] < 1.5 * cost[8]


@pytest.mark.parametrize(("sample", "tree"), [(chain(3, "spherical"), True), (four_bars(1), False)])
def test_steps_without_loops_need_no_certificate(sample, tree):
    """Of a chain, every step has the pivot of the start, inside the limits."""
    model, y0 = prepared(sample, Treatment("projection"))
    names = [f"j{k}" for k in range(len(model.joint_kind))]
    monitor = SingularityMonitor(model, names, "projection")
    monitor.at_start(0.0, y0)
    away = y0.copy()
    away[[3, 6]] = np.cos(1.2), np.sin(1.2)
    energy, pivots = np.empty((1, 3)), np.empty(1)
    observe(model, monitor._observation, np.array([1e-3]), away[None], energy, pivots)
    low, high = monitor._observation.limits
    assert (monitor._observation.regular[0] == pivots[0]) == tree
    assert low < pivots[0] < high


def test_forces_of_a_long_chain_take_no_dense_matrices(long_chain, monkeypatch):
    """The load on its first joint at the start, when all links fall freely but the first ones."""
    monkeypatch.setattr("plymotion.solver.dynamics.evaluation.series.dense_derivative_into", None)
    model, y0 = long_chain
    rates, multipliers = along_solution(model, np.zeros(1), y0[None, :])
    assert np.isfinite(multipliers).all()
    assert np.abs(rates).max() < 100.0
