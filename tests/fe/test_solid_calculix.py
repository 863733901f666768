"""Frequencies of solids on the same mesh as CalculiX's C3D10.

Three nodes are held: the matrix of a free body is singular, and CalculiX's frequencies of it are
off by up to 4e-6, differently on each processor.

CalculiX integrates the mass of C3D10 with the four points of the stiffness. They are exact for
polynomials of degree 2, the products of two functions of the element have 4. Ours are exact, and
nearer to the limit of fine meshes.
"""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.sparse as sp
from samples.exchange_decks import frequencies
from samples.exchange_routes import ccx, run_program
from samples.solid_samples import (
    ALUMINIUM,
    WOUND,
    bar,
    bracket,
    calculix_deck,
    filleted,
    model_of,
    step_file,
    tube,
)
from scipy.sparse.linalg import LinearOperator, eigsh, splu

from plymotion.preprocess.exchange.free_body import FreeBody
from plymotion.preprocess.solid.forms import mass
from plymotion.preprocess.solid.solid_analysis import free_hertz
from plymotion.solver.math.arrays import Array

COUNT = 6


@pytest.mark.parametrize(
    ("draw", "size", "material", "region"),
    [
        (bar, 0.01, ALUMINIUM, {}),
        (bracket, 0.012, ALUMINIUM, {}),
        (filleted, 0.03, ALUMINIUM, {}),
        (tube, 0.015, WOUND, {"axis_about": {"point": [0, 0, 0], "direction": [0, 0, 1]}}),
    ],
    ids=["straight edges", "bores", "fillets", "orthotropic around a cylinder"],
)
@pytest.mark.one_end
def test_free_frequencies_are_those_of_calculix(
    draw: Any, size: float, material: Any, region: Any, tmp_path: Path
) -> None:
    program = ccx()
    step_file(tmp_path / "part.step", draw)
    model = model_of(tmp_path / "part.step", size, material, region=region)
    nodes = model.body.nodes
    far = np.abs(nodes - nodes[0]).sum(axis=1)
    held = np.array([0, far.argmax(), np.minimum(far, np.roll(far, 1)).argmax()])
    calculix_deck(tmp_path / "part.inp", model, material, COUNT + 14, held)
    run_program(program, ["part"], tmp_path, tmp_path / "part.dat")
    expected = frequencies(tmp_path / "part.dat")[:COUNT] / (2.0 * np.pi)
    exact = free_hertz(model.body, COUNT)
    M = model.space.matrix(mass(model.space.space, model.space.of_cells(model.materials.rho), 2))
    body = replace(model.body, M=0.5 * (M + M.T))
    np.testing.assert_allclose(hertz(body, ~np.isin(body.dof_node, held)), expected, rtol=1e-6)
    free = hertz(body, np.ones(body.dof_node.size, dtype=bool))
    np.testing.assert_allclose(free_hertz(body, COUNT), free, rtol=1e-8)
    if draw in (bar, bracket):  # the others have ten times the cells, or cells of their curvature
        finer = free_hertz(model_of(tmp_path / "part.step", size / 1.6).body, COUNT)
        assert (np.abs(exact - finer) < np.abs(free - finer)).all()


def hertz(body: FreeBody, free: Array) -> Array:
    """Lowest frequencies above zero of the free unknowns, by SciPy [Hz]."""
    K, M = (sp.csc_matrix(A)[free][:, free] for A in (body.K, body.M))
    shift = -1e-3 * K.diagonal().sum() / M.diagonal().sum()
    how = {"permc_spec": "MMD_AT_PLUS_A", "diag_pivot_thresh": 0.0}  # of a definite matrix
    factors = splu(K - shift * M, **how, options={"SymmetricMode": True})
    inverse = LinearOperator(K.shape, factors.solve, dtype=float)
    values = np.sort(
        eigsh(K, 2 * COUNT + 6, M, sigma=shift, OPinv=inverse, return_eigenvectors=False)
    )
    values = values[values > 1e-6 * values[-1]]
    return np.asarray(np.sqrt(values[:COUNT]) / (2.0 * np.pi))
