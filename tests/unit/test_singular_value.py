"""The smallest singular value that counts is that of a dense decomposition."""

import numpy as np
import pytest
from samples.constraint_runs import prepared
from samples.mechanism_samples import bricard, chain, four_bars

from plymotion.solver.dynamics.analysis.rank import (
    difference,
    new_independence,
    new_spectrum,
    smallest_at,
)
from plymotion.solver.dynamics.elements.constraints.treatment import Treatment, scaled_jacobian
from plymotion.solver.dynamics.evaluation.accelerations import assemble
from plymotion.solver.dynamics.model.model import new_workspace


def _search(model):
    """Return a function of a state: its smallest singular value, and the blocks of C."""
    rows, work = new_independence(model), new_workspace(model)
    memory = new_spectrum(rows)

    def found(y):
        C = np.zeros_like(rows.C)
        return smallest_at(model, work, rows, memory, model.redundant, 0.0, y, C), C

    return found, memory


def _dense(model, y):
    return scaled_jacobian(assemble(model, 0.0, y).Phi_q, model.inertia_scale)


@pytest.mark.parametrize("sample", [chain(1), chain(30), four_bars(1), four_bars(6), bricard()])
def test_it_is_that_of_a_dense_decomposition(sample):
    """Of the start, and of states that violate the joints; redundant rows stay nearly so."""
    model, y0 = prepared(sample, Treatment())
    search, _ = _search(model)
    for shift in (0.0, 1e-9, 0.1):
        y = y0.copy()
        y[: model.n_pos] += shift * np.sin(np.arange(model.n_pos))
        singular = np.linalg.svd(_dense(model, y), compute_uv=False)
        expected = singular[model.n_constraint - model.redundant - 1]
        assert search(y)[0] == pytest.approx(expected, rel=1e-11)


def _nearly_flat(angle):
    """A four-bar linkage of unit lengths whose uprights are `angle` above the line of its feet."""
    sample = four_bars(1)
    model, y = prepared(sample, Treatment())
    turn = angle - 0.5 * np.pi
    c, s = np.cos(0.5 * turn), np.sin(0.5 * turn)
    Q = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    for i in range(model.n_body):
        a = int(model.pos_start[i])
        upright = abs(y[a + 1] - 0.5) < 1e-9
        if upright:
            foot = np.array([y[a], 0.0])
            y[a : a + 2] = foot + Q @ (y[a : a + 2] - foot)
            y[a + 3 : a + 7] = c, 0.0, 0.0, s
        else:
            middle = np.array([y[a], 0.0])
            y[a : a + 2] = middle + Q @ np.array([0.0, 1.0])
    return model, y


@pytest.mark.parametrize("angle", [1e-1, 1e-3, 1e-5])
def test_near_a_singular_position_it_keeps_its_digits(angle):
    model, y = _nearly_flat(angle)
    assert np.abs(assemble(model, 0.0, y).Phi).max() < 1e-12
    singular = np.linalg.svd(_dense(model, y), compute_uv=False)
    expected = singular[model.n_constraint - model.redundant - 1]
    assert 0.01 * angle < expected < angle
    assert _search(model)[0](y)[0] == pytest.approx(expected, rel=1e-9 / angle)


def test_in_a_singular_position_it_vanishes():
    model, y = _nearly_flat(0.0)
    assert _search(model)[0](y)[0] < 1.01e-7


def test_the_bound_of_a_difference_is_one():
    model, y0 = prepared(four_bars(2), Treatment())
    y = y0.copy()
    y[: model.n_pos] += 0.1 * np.sin(np.arange(model.n_pos))
    search, memory = _search(model)
    bound = difference(model, memory, search(y)[1], search(y0)[1])
    change = np.abs(_dense(model, y) - _dense(model, y0))
    assert bound == pytest.approx((change.sum(axis=0).max() * change.sum(axis=1).max()) ** 0.5)
    assert bound >= np.linalg.norm(_dense(model, y) - _dense(model, y0), 2)
