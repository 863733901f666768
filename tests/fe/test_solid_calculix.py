"""Frequencies of solids on the same mesh as CalculiX's C3D10.

CalculiX integrates the mass of C3D10 with the four points of the stiffness. They are exact for
polynomials of degree 2, the products of two functions of the element have 4. Ours are exact, and
nearer to the limit of fine meshes.
"""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
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

from plymotion.preprocess.solid.forms import mass
from plymotion.preprocess.solid.solid_analysis import free_hertz

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
    found = []
    for more in (14, 24):  # so that the first ones converge
        calculix_deck(tmp_path / "part.inp", model, material, COUNT + more)
        run_program(program, ["part"], tmp_path, tmp_path / "part.dat")
        found.append(frequencies(tmp_path / "part.dat")[6 : 6 + COUNT] / (2.0 * np.pi))
    # The matrix of a free body is singular: CalculiX differs from itself by up to 4e-6.
    expected, own_error = found[0], np.abs(found[1] - found[0])
    assert (own_error < 1e-5 * expected).all()
    exact = free_hertz(model.body, COUNT)
    M = model.space.matrix(mass(model.space.space, model.space.of_cells(model.materials.rho), 2))
    model.__dict__["body"] = replace(model.body, M=0.5 * (M + M.T))
    assert (np.abs(free_hertz(model.body, COUNT) - expected) <= 1e-6 * expected + own_error).all()
    if draw in (bar, bracket):  # the others have ten times the cells, or cells of their curvature
        finer = free_hertz(model_of(tmp_path / "part.step", size / 2.0).body, COUNT)
        assert (np.abs(exact - finer) < np.abs(expected - finer)).all()
