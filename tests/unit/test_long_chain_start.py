"""The start of a long chain needs no dense matrix, whose time grows with the third power."""

import numpy as np
import pytest
from samples.mechanism_samples import chain

from plymotion.solver.dynamics.analysis import rank as freedom
from plymotion.solver.dynamics.analysis.rank import degrees_of_freedom
from plymotion.solver.dynamics.evaluation.accelerations import assemble
from plymotion.solver.mechanism import consistent as initial
from plymotion.solver.mechanism.consistent import consistent_state, redundancy

LINKS = 40


@pytest.mark.parametrize("spin", [0.0, 2.0])
def test_without_dense_matrices(spin, monkeypatch):
    """Every spin is given: the chain hangs still, or turns about its support as one."""
    sample = chain(LINKS)
    model, start = sample.model, sample.start
    for i in range(model.n_body):
        j = int(model.vel_start[i])
        start.given[j + 3 : j + 6] = True
        start.velocities[j + 5] = spin

    def refuse(*_):
        raise AssertionError("dense matrices")

    with monkeypatch.context() as patch:
        patch.setattr(initial, "assemble", refuse)
        patch.setattr(freedom, "assemble", refuse)
        y = consistent_state(model, start, sample.names)
        assert redundancy(model, y, sample.names).count == 0
        assert degrees_of_freedom(model, y) == model.n_vel - model.n_constraint
    equations = assemble(model, 0.0, y)
    v = y[model.n_pos : model.n_pos + model.n_vel]
    assert np.abs(equations.Phi_q @ v + equations.Phi_t).max() < 1e-12 * max(1.0, np.abs(v).max())
    assert v[model.vel_start[-1] + 5] == spin
