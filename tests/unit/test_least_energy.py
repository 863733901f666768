"""Velocities of least kinetic energy are those of the dense equations."""

import numpy as np
import pytest
from samples.constraint_runs import prepared
from samples.mechanism_samples import chain

from plymotion.solver.dynamics.analysis.projection import least_energy
from plymotion.solver.dynamics.elements.constraints.treatment import Treatment
from plymotion.solver.dynamics.evaluation.accelerations import assemble


@pytest.mark.parametrize("given", [[], [5], [5, 11], [5, 11, 17, 23, 29]])
def test_they_solve_the_dense_equations(given):
    model, y0 = prepared(chain(5), Treatment())
    given = np.array(given, dtype=np.int64)
    values = np.array([3.0, -2.0, 1.0, 0.0, 5.0])[: given.size]
    v = least_energy(model, 0.0, y0, given, values)
    equations = assemble(model, 0.0, y0)
    J = np.vstack([equations.Phi_q, np.eye(model.n_vel)[given]])
    goal = np.concatenate([-equations.Phi_t, values])
    A = np.block([[equations.M, J.T], [J, np.zeros((len(J), len(J)))]])
    expected = np.linalg.solve(A, np.concatenate([np.zeros(model.n_vel), goal]))[: model.n_vel]
    assert given.size == 0 or np.abs(expected).max() > 1.0
    np.testing.assert_allclose(v, expected, atol=1e-10)
