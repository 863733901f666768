"""Section resultants of the modes at the nodes of a beam.

A shape d is the deformation under a distributed load M a and forces at nodes. a = lambda d for
a mode of eigenvalue lambda, and a = 0 for the static shape of forces at nodes. The forces at
the ends of an element in equilibrium with that load,

    f = K_e d - M_e a,     F6(0) = -f_1,     F6(L) = f_2,

are the resultants there. Both elements of a node give the same value because the node is in
equilibrium: the resultants are continuous where nothing is attached. They are
exact to round-off for static shapes under loads at nodes. For modes with consistent mass
their error falls with the fourth power of the element length in slender bending. It falls with the
second power, from a small value, for rotary inertia, twist or extension, and with
lumped mass. K e6 from the static shape functions inside the element would have an error of
lambda m u L^2 / 12 in the moments at its ends, where the moments are largest.
"""

import numpy as np

from ...solver.math.arrays import Array
from ...solver.package.body.schema import BodyRecovery
from .line import BeamLine


def shape_resultants(
    line: BeamLine,
    columns_B: Array,
    accelerations_B: Array,
    mass_form: str,
    breaks: tuple[int, ...] = (),
) -> BodyRecovery:
    """Resultants at the nodes per unit modal coordinate.

    Parameters
    ----------
    line : the beam
    columns_B : (6 n, m) shapes, body axes
    accelerations_B : (6 n, m) a of the distributed load M a of each shape; 0 for
        static shapes of forces at nodes [m/s2, rad/s2]
    mass_form : "consistent" or "lumped", that of the loads
    breaks : held or loaded nodes, where the resultants jump: each gives two stations

    Returns
    -------
    Stations in order of x: the nodes, all with the section 0. Those of `breaks` are present twice,
    first as the end of the element before them, then as the start of the element after them.
    """
    d, a = line.to_element(columns_B), line.to_element(accelerations_B)
    ends = np.zeros((line.n_node - 1, 2, 6, d.shape[2]))
    for span in line.spans:
        element, numbers = span.element, span.numbers
        M = element.mass_matrix(span.section.mass, mass_form)
        inner = np.einsum("ij,ejm->eim", element.stiffness(), d[numbers])
        inertial = np.einsum("ij,ejm->eim", M, a[numbers])
        ends[numbers] = (inner - inertial).reshape(len(numbers), 2, 6, d.shape[2])
    ends[:, 0] *= -1.0
    last = line.n_node - 1
    inner_breaks = np.array(sorted({b for b in breaks if 0 < b < last}), dtype=np.int64)
    # The start of each element, and its end if it is the last element or the resultants jump.
    node = np.concatenate([np.arange(last), inner_breaks, [last]])
    resultants = np.concatenate([ends[:, 0], ends[inner_breaks - 1, 1], ends[-1:, 1]])
    at_end = np.concatenate([np.ones(last), np.zeros(len(inner_breaks) + 1)])
    order = np.lexsort([at_end, node])
    return BodyRecovery(
        station_x=line.along[node][order],
        section=np.zeros(len(order), dtype=np.int64),
        resultants_E=resultants[order],
        A_BE=line.A_BE[0],
    )
