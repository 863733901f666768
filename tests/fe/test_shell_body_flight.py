"""A shell that flies freely keeps energy, momentum and angular momentum."""

from typing import Any

import numpy as np
import pytest
from samples.body_specs import panel_body
from samples.flexible_samples import momenta, simulate, total_energy
from samples.shell_specs import CFRP, plate

from plymotion.preprocess.body import build_body
from plymotion.solver.math.arrays import Array
from plymotion.solver.mechanism.assembly import assemble_model
from plymotion.solver.mechanism.tables import flexible_body
from plymotion.solver.package import ModalPackage

# The solver flies: another DOLFINx would give it the same package.
pytestmark = pytest.mark.one_end


def panel(mass_form: str, reference: dict[str, Any]) -> dict[str, Any]:
    """An unsymmetric laminate off its mesh, so that nothing decouples."""
    plies = [{"material": "cfrp", "angle_deg": a, "thickness": 5e-4} for a in (30.0, -15.0, 75.0)]
    shell = plate((10, 4), 1.0, 0.5, 0.2) | {
        "materials": {"cfrp": CFRP},
        "laminates": {"skin": {"plies": plies, "offset": "bottom"}},
        "regions": {"all": {"laminate": "skin", "axis": [1.0, 0.0, 0.0]}},
    }
    return panel_body(shell, 3, body="panel", mass_form=mass_form, reference=reference)


def fly(package: ModalPackage, *, stiffening: bool = False) -> Array:
    """States of a free flight, (5, n); energy and both momenta stay."""
    model = assemble_model([flexible_body("panel", package, stiffening=stiffening)], [], [])
    m = package.n_mode
    y0 = np.zeros(model.n_pos + model.n_vel + 1)
    y0[3] = 1.0
    y0[7 : 7 + m] = [4e-3, -1e-3, 5e-4]
    y0[7 + m : 13 + m] = [0.3, -0.2, 0.5, 2.0, 3.0, -4.0]
    y = simulate(model, y0, np.linspace(0.0, 0.05, 5))
    energy = np.array([total_energy(model, state) for state in y])
    linear, angular = (np.array(part) for part in zip(*(momenta(model, s) for s in y), strict=True))
    assert np.abs(energy / energy[0] - 1.0).max() < 1e-8
    assert np.abs(linear - linear[0]).max() < 1e-8 * np.linalg.norm(linear[0])
    assert np.abs(angular - angular[0]).max() < 1e-8 * np.linalg.norm(angular[0])
    return y


@pytest.mark.parametrize("mass_form", ["consistent", "lumped"])
@pytest.mark.parametrize("reference", [{"kind": "clamped", "at": "root"}, {"kind": "mean-axis"}])
def test_free_flight(mass_form: str, reference: dict[str, Any]) -> None:
    y = fly(build_body(panel(mass_form, reference)))
    assert np.ptp(y[:, 7]) > 1e-3


@pytest.mark.parametrize("reference", [{"kind": "clamped", "at": "root"}, {"kind": "mean-axis"}])
def test_free_flight_of_a_stiffened_shell(reference: dict[str, Any]) -> None:
    """With second-order displacements too."""
    fly(build_body({**panel("consistent", reference), "second_order": True}), stiffening=True)
