"""Scaled constraint equations without units, for rank and penalties."""

import numpy as np

from ...math.arrays import Array


def row_masses(Phi_q: Array, inertia_scale: Array) -> Array:
    """Return the effective mass of each constraint row, (n_c,): 1 / sum_j Phi_ij^2 / scale_j.

    [kg] for a distance, [kg m2] for an angle; zero for a zero row.
    """
    mobility = (Phi_q * Phi_q) @ (1.0 / inertia_scale)
    masses = np.zeros(mobility.shape[0])
    np.divide(1.0, mobility, out=masses, where=mobility > 0.0)
    return masses


def scaled_jacobian(Phi_q: Array, inertia_scale: Array) -> Array:
    """Return C (n_c, n): rows of length one in the metric of the inertia.

    C = D Phi_q S^-1/2 with D^2 = `row_masses` and S = diag(inertia_scale): it does not depend on
    the units of rows and coordinates, so a singular value of 1e-8 has the same meaning everywhere.
    """
    root = np.sqrt(row_masses(Phi_q, inertia_scale))
    return root.reshape(-1, 1) * Phi_q / np.sqrt(inertia_scale)
