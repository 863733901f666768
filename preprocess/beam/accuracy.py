"""Estimate of the discretisation error of the mode frequencies of a beam.

Every element is halved without solving again. Between its nodes a mode has the
static shape, so its strain energy on the finer mesh is the same. Its mass can
differ (lumped) by delta. Inertial forces lambda r act at the mid-nodes and displace
them by lambda Kc^-1 r. To first order the squared frequency changes by

    -(delta + lambda r' Kc^-1 r)     relative, mode of unit mass.

The total change after infinitely many halvings is at most 4/3 of it, because the
error falls at least with the square of the element length.
"""

import numpy as np

from ...solver.errors import few
from ...solver.math.arrays import Array
from .element import BeamElement, scaled_inverse
from .line import BeamLine

LIMIT = 0.01  # relative frequency error above which a mesh is reported as coarse


def frequency_error(line: BeamLine, values: Array, columns_B: Array, mass_form: str) -> Array:
    """Estimated relative error of the frequencies, (m,); positive where they are too high.

    Parameters
    ----------
    line : the beam
    values : (m,) eigenvalues [rad2/s2]
    columns_B : (6 n, m) mass-normalised modes, body axes
    mass_form : "consistent" or "lumped"
    """
    nodal_E = line.to_element(columns_B)
    change = np.zeros(len(values))
    for span in line.spans:
        element, mass = span.element, span.section.mass
        d = nodal_E[span.numbers]
        half = BeamElement(0.5 * element.length, element.K)
        # nodes of the halved element: first, last (12 values), middle (6)
        P = np.vstack([np.eye(12), element.shape(np.array([half.length]))[0]])
        first, second = np.r_[0:6, 12:18], np.r_[12:18, 6:12]
        K_fine, M_fine = np.zeros((18, 18)), np.zeros((18, 18))
        for dofs in (first, second):
            K_fine[np.ix_(dofs, dofs)] += half.stiffness()
            M_fine[np.ix_(dofs, dofs)] += half.mass_matrix(mass, mass_form)
        gained = P.T @ M_fine @ P - element.mass_matrix(mass, mass_form)
        change += np.einsum("eim,ij,ejm->m", d, gained, d, optimize=True)
        r = np.einsum("ij,ejm->eim", M_fine[12:] @ P, d)
        follow = scaled_inverse(K_fine[12:, 12:])
        change += values * np.einsum("eim,ij,ejm->m", r, follow, r, optimize=True)
    return 0.5 * 4.0 / 3.0 * change


def coarse_mesh_warnings(
    labels: tuple[str, ...], error: Array, elements: int
) -> list[dict[str, str]]:
    """Warning `mesh-coarse-for-modes` naming the modes beyond LIMIT; empty if there are none."""
    coarse = [
        f"{label} ({abs(e):.1%})" for label, e in zip(labels, error, strict=True) if abs(e) > LIMIT
    ]
    if not coarse:
        return []
    message = (
        f"{elements} elements are too few for the modes {few(coarse)}: estimated frequency "
        f"error above {LIMIT:.0%}; increase `elements`"
    )
    return [{"code": "mesh-coarse-for-modes", "message": message}]
