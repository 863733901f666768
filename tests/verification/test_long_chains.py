"""Long chains: their rows are independent, however little the last joint can move the chain."""

import numpy as np
import pytest
from constraint_runs import new_run, prepared
from mechanism_samples import bricard, chain, four_bars, pendulum
from two_body_samples import two_bodies

from plymotion.solver.dynamics.constraints.treatment import Treatment
from plymotion.solver.dynamics.dependence import REGULAR, is_tree
from plymotion.solver.dynamics.derivative import derivative_into
from plymotion.solver.dynamics.series import along_solution
from plymotion.solver.dynamics.workspace import new_work
from plymotion.solver.integrators.generic import integrate

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


def test_pivots_of_a_long_chain_are_as_small_as_those_of_dependent_rows(long_chain):
    model, y0 = long_chain
    work = new_work(model)
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


def test_forces_of_a_long_chain_take_no_dense_matrices(long_chain, monkeypatch):
    """The load on its first joint at the start, when all links fall freely but the first ones."""
    monkeypatch.setattr("plymotion.solver.dynamics.series.dense_derivative_into", None)
    model, y0 = long_chain
    rates, multipliers = along_solution(model, np.zeros(1), y0[None, :])
    assert np.isfinite(multipliers).all()
    assert np.abs(rates).max() < 100.0
