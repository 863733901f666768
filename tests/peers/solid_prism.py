"""A prism of quadratic hexahedra between two rigid faces: compliance of one of them."""

from collections.abc import Callable
from typing import Any

import numpy as np
import ufl
from mpi4py import MPI
from peers.dolfinx_forms import assembled

from plymotion.preprocess import fenicsx
from plymotion.preprocess.fenicsx.libraries import dolfinx  # after MPI, which its wheel needs
from plymotion.preprocess.fenicsx.spaces import dof_coordinates, vector_space


def held_compliance(
    size: tuple[float, float, float], count: tuple[int, int, int], stiffness: Callable[[Any], Any]
) -> np.ndarray:
    """Return the compliance (6, 6) at the face x1 = L, for [F1, F2, F3, M1, M2, M3] there.

    Parameters
    ----------
    size : length, width along x2, height along x3 [m]
    count : elements along them
    stiffness : of UFL coordinates, UFL matrix (6, 6), order 11, 22, 33, 23, 13, 12
    """
    length, width, height = size
    mesh = dolfinx.mesh.create_box(
        MPI.COMM_SELF,
        [[0.0, -width / 2, -height / 2], [length, width / 2, height / 2]],
        list(count),
        dolfinx.mesh.CellType.hexahedron,
    )
    space = vector_space(mesh, 2, 3)
    u, v = ufl.TrialFunction(space), ufl.TestFunction(space)

    def strain(w: Any) -> Any:
        e = ufl.sym(ufl.grad(w))
        return ufl.as_vector([e[0, 0], e[1, 1], e[2, 2], 2 * e[1, 2], 2 * e[0, 2], 2 * e[0, 1]])

    dx = ufl.Measure("dx", domain=mesh, metadata={"quadrature_degree": 4})
    C = stiffness(ufl.SpatialCoordinate(mesh))
    (K,) = assembled([ufl.inner(C * strain(u), strain(v)) * dx])
    x = dof_coordinates(space)
    ends = [np.flatnonzero(np.isclose(x[:, 0], place)) for place in (0.0, length)]
    motion = np.zeros((len(x), 3, 6))  # of the far face, about its centre
    _, x2, x3 = x[ends[1]].T
    for i in range(3):
        motion[ends[1], i, i] = 1.0
    motion[ends[1], 1, 3], motion[ends[1], 2, 3] = -x3, x2
    motion[ends[1], 0, 4], motion[ends[1], 0, 5] = x3, -x2
    motion = motion.reshape(-1, 6)
    held = np.concatenate(ends)
    free = np.setdiff1d(np.arange(K.shape[0]), (3 * held[:, None] + np.arange(3)).ravel())
    field = motion.copy()
    factor = fenicsx.cholesky(K[free][:, free])
    field[free] = -factor.solve((K @ motion)[free])
    return np.asarray(np.linalg.inv(field.T @ (K @ field)))
