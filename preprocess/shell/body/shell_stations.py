"""Mass stations of a shell body: positions of its mass and their motion in the modes.

The inertia invariants of a body are sums over stations (solver/package/body/invariants.py). A
fibre of the wall along the normal n, with the moments m0, m1, m2 of its density about the mesh,
is a rigid piece: mass m0, centre at m1/m0 n from the mesh, rotary inertia about it
(m2 - m1^2/m0) (1 - n n'). With consistent mass there are fibres at three points of each triangle
and at four of each quadrilateral, which integrate the motions of their corners exactly. With lumped
mass they are at its corners, and m2 also acts on the drilling rotation, as in `mass_work`. The sums
then equal the mass matrix to round-off, with one exception: consistent mass also acts on the
difference of the drilling rotation from that of the cell. This part is zero for rigid
motions and has no momentum; only the modal mass includes it.
"""

from collections.abc import Sequence

import numpy as np

from ....solver.math.arrays import Array
from ....solver.package.common.cells import corner_areas
from ....solver.package.common.plain_data import SpecError
from ...beam.beam_stations import Stations
from ...beam.beam_stations import mass_stations as line_stations
from ..model.links import cross_matrix
from ..model.regions import Region
from ..model.stiffeners import Stiffener
from ..shell_cells import ShellMesh


def mass_stations(
    mesh: ShellMesh, regions: Sequence[Region], stiffeners: Sequence[Stiffener], u: Array, form: str
) -> Stations:
    """Mass stations of a shell and their motion. Paper: Eq. (31).

    Parameters
    ----------
    u : (n, 6, m) displacements and rotations of the mesh's nodes in m modes, body axes [m, rad]
    form : "consistent" or "lumped", that of the mass matrix

    Raises
    ------
    SpecError : the mass of a stiffener is not that of rigid slices.
    """
    parts = [_of_region(mesh, region, u, form) for region in regions]
    for stiffener in stiffeners:
        ends = stiffener.carried @ u.reshape(-1, u.shape[2])
        try:
            parts.append(line_stations(stiffener.line, ends, form))
        except ValueError as error:
            raise SpecError(f"shell.stiffeners.{stiffener.name}: {error}") from error
    return Stations.joined(parts)


def nodal_mass(
    mesh: ShellMesh, regions: Sequence[Region], stiffeners: Sequence[Stiffener]
) -> tuple[Array, Array]:
    """Lumped mass of each node, (n,) [kg], and inertia about the node, (n, 3, 3) [kg m2].

    Parameters
    ----------
    mesh : of the shell, n nodes
    regions : with their laminates
    stiffeners : on curves of the mesh
    """
    mass, rotary = np.zeros(mesh.n_node), np.zeros(mesh.n_node)
    for region in regions:
        m0, _, m2 = region.stiffness.mass
        nodes, share = corner_areas(mesh.points_G, region.nodes)
        area = np.bincount(nodes, weights=share, minlength=mesh.n_node)
        mass += m0 * area
        rotary += m2 * area
    inertia = rotary[:, None, None] * np.eye(3)
    for stiffener in stiffeners:
        M = stiffener.mass("lumped")
        mass += M.diagonal()[::6]
        for i, j in np.ndindex(3, 3):
            inertia[:, i, j] += M[3 + i :: 6, 3 + j :: 6].diagonal()
    return mass, inertia


def _of_region(mesh: ShellMesh, region: Region, u: Array, form: str) -> Stations:
    m0, m1, m2 = region.stiffness.mass
    cells, count = region.nodes, region.nodes.shape[1]
    consistent = form == "consistent"
    N = region.geometry.interpolation if consistent else np.eye(count)
    corners = u[cells]  # (c, 3|4, 6, m)
    flat = corners.reshape(len(cells), count, 6 * u.shape[2])
    motion = (N @ flat).reshape(count * len(cells), *u.shape[1:])
    normal = np.repeat(region.geometry.A_GE[:, :, 2], count, axis=0)
    weight = region.geometry.weight.ravel()
    if not consistent:
        weight = corner_areas(mesh.points_G, cells)[1]
    across = np.eye(3) - normal[:, :, None] * normal[:, None, :]
    inertia = (m2 - m1**2 / m0) * across
    if form == "lumped":
        inertia = m2 * np.eye(3) - m1**2 / m0 * across
    arm = m1 / m0 * normal
    phi, psi = motion[:, :3], motion[:, 3:]
    if m1 != 0.0:
        phi = phi - cross_matrix(arm) @ psi
    return Stations(
        m=m0 * weight,
        x_B=(N @ mesh.points_G[cells]).reshape(-1, 3) + arm,
        phi_B=phi,
        psi_B=psi,
        J_B=weight[:, None, None] * inertia,
    )
