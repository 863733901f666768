"""Conservation laws for a real body: the off-axis hand of the double pendulum, flying freely."""

import numpy as np
from samples.flexible_samples import momenta, simulate, total_energy

from plymotion.solver.mechanism.assembly import assemble_model
from plymotion.solver.mechanism.tables import flexible_body
from plymotion.solver.package import read_package


def test_free_flying_hand_keeps_energy_and_momenta(repository):
    package = read_package(
        repository / "tests/packages/double-pendulum-limits/hand.layup-2-soft-following.vtkhdf"
    )
    model = assemble_model([flexible_body("hand", package)], [], [])
    y0 = np.zeros(model.n_pos + model.n_vel + 1)
    y0[3] = 1.0
    m = package.n_mode
    y0[7 : 7 + m] = [0.01, -0.002, 0.001, 0.0005]  # bent at the start by some centimetres
    y0[7 + m : 13 + m] = [0.3, -0.2, 0.5, 5.0, 3.0, 8.0]
    y = simulate(model, y0, np.linspace(0.0, 0.1, 6))
    energy = np.array([total_energy(model, state) for state in y])
    linear, angular = (np.array(part) for part in zip(*(momenta(model, s) for s in y), strict=True))
    assert np.abs(energy / energy[0] - 1).max() < 5e-9
    assert np.abs(linear - linear[0]).max() < 5e-9 * np.linalg.norm(linear[0])
    assert np.abs(angular - angular[0]).max() < 5e-9 * np.linalg.norm(angular[0])
    assert np.ptp(y[:, 7]) > 1e-3
