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
from ...beam.element import MASS_POINTS, BeamElement, gauss
from ...beam.line import SectionMass
from ...beam.stations import Stations
from ..mesh import ShellMesh
from ..model.links import carried, cross_matrix
from ..model.regions import Region
from ..model.stiffeners import Stiffener


def mass_stations(
    mesh: ShellMesh,
    regions: Sequence[Region],
    stiffeners: Sequence[Stiffener],
    u: Array,
    form: str,
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
    parts += [_of_stiffener(mesh, stiffener, u, form) for stiffener in stiffeners]
    columns = ("m", "x_B", "phi_B", "psi_B", "J_B")
    return Stations(*(np.concatenate([getattr(p, name) for p in parts]) for name in columns))


def nodal_mass(
    mesh: ShellMesh, regions: Sequence[Region], stiffeners: Sequence[Stiffener]
) -> tuple[Array, Array]:
    """Lumped mass of each node, (n,) [kg], and inertia about the node, (n, 3, 3) [kg m2]."""
    mass, rotary = np.zeros(mesh.n_node), np.zeros(mesh.n_node)
    for region in regions:
        m0, _, m2 = region.stiffness.mass
        nodes, share = corner_areas(mesh.points_G, region.nodes)
        area = np.bincount(nodes, weights=share, minlength=mesh.n_node)
        mass += m0 * area
        rotary += m2 * area
    inertia = rotary[:, None, None] * np.eye(3)
    for stiffener in stiffeners:
        M = stiffener.mass("lumped").reshape(-1, 2, 6, 2, 6)
        for end in range(2):
            np.add.at(mass, stiffener.ends[:, end], M[:, end, 0, end, 0])
            np.add.at(inertia, stiffener.ends[:, end], M[:, end, 3:, end, 3:])
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


def _of_stiffener(mesh: ShellMesh, stiffener: Stiffener, u: Array, form: str) -> Stations:
    try:
        slice_ = SectionMass.from_matrix(stiffener.M)
    except ValueError as error:
        raise SpecError(f"shell.stiffeners.{stiffener.name}: {error}") from error
    A, L = stiffener.A_GE, stiffener.length
    offset = np.concatenate([[0.0], stiffener.offset])
    # motion of the reference line at the ends, section axes, (l, 2, 6, m)
    turn = np.zeros((len(L), 6, 6))
    turn[:, :3, :3] = turn[:, 3:, 3:] = np.swapaxes(A, 1, 2)
    ends = (carried(offset[None])[0] @ turn)[:, None] @ u[stiffener.ends]
    nodal = ends.reshape(len(L), 12, u.shape[2])
    parts = []
    for row, length in enumerate(L):
        if form == "consistent":
            x, w = gauss(length, MASS_POINTS)
            motion = BeamElement(length, stiffener.K).shape(x) @ nodal[row]
        else:
            x, w = np.array([0.0, length]), np.full(2, 0.5 * length)
            motion = ends[row]
        parts.append((x, w, motion))
    count = len(parts[0][0])
    x, w = (np.concatenate([part[i] for part in parts]) for i in (0, 1))
    motion = np.concatenate([part[2] for part in parts])
    A = np.repeat(A, count, axis=0)
    start = np.repeat(mesh.points_G[stiffener.ends[:, 0]], count, axis=0)
    line = np.stack([x, np.zeros_like(x), np.zeros_like(x)], axis=1) + offset + slice_.centre_E
    phi = motion[:, :3] - cross_matrix(slice_.centre_E) @ motion[:, 3:]
    return Stations(
        m=w * slice_.m,
        x_B=start + np.einsum("kab,kb->ka", A, line),
        phi_B=A @ phi,
        psi_B=A @ motion[:, 3:],
        J_B=w[:, None, None] * (A @ slice_.J_E @ np.swapaxes(A, 1, 2)),
    )
