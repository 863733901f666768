"""Inertia invariants of a reduced flexible body, of first and second order, and their round-off.

A sum over mass stations may be zero because its terms cancel. The result is then round-off of the
terms. A check must compare it with the size of the terms, not with the sum. Paper: Eq. (2),
Eq. (15).

To second order a mass station moves with the modes to x + phi q + 1/2 q' h q. A bent beam
shortens, which the linear shapes neglect. This is equivalent to the geometric stiffness: for any
load f, sum f_k h_ij,k = -X_i' K_geo(f) X_j with the stresses of f (docs/stiffening.md).
"""

import numpy as np

from ...math.arrays import Array
from .package_schema import Invariants, ModalPackage, Pieces, SecondOrder


def from_stations(
    m: Array, x_B: Array, phi_B: Array, psi_B: Array, J_B: Array, mass_form: str
) -> Invariants:
    """Sum mass stations to the invariants that the solver needs.

    The paper sums over nodes with lumped masses (`mass_form="lumped"`). Taking
    the integration points of the consistent mass matrix as stations gives the
    consistent invariants from the same sums.

    Parameters
    ----------
    m : (k,) station masses [kg]
    x_B : (k, 3) rest positions of the stations' mass centres [m]
    phi_B : (k, 3, n_mode) translation of the mass centre per unit mode [m]
    psi_B : (k, 3, n_mode) rotation per unit mode [rad]
    J_B : (k, 3, 3) rotary inertia about the mass centre [kg m2]
    mass_form : "consistent" or "lumped"
    """
    return Invariants(
        mass=float(m.sum()),
        S0_B=np.einsum("k,ka->a", m, x_B),
        S_B=np.einsum("k,kai->ai", m, phi_B),
        T00_B=np.einsum("k,ka,kb->ab", m, x_B, x_B),
        T01_B=np.einsum("k,ka,kbi->abi", m, x_B, phi_B, optimize=True),
        T11_B=np.einsum("k,kai,kbj->abij", m, phi_B, phi_B, optimize=True),
        J0_B=J_B.sum(axis=0),
        J_psi_B=np.einsum("kab,kbi->ai", J_B, psi_B, optimize=True),
        mass_form=mass_form,
    )


def inertia_at_rest(invariants: Invariants) -> Array:
    """Inertia tensor of the undeformed body about the frame origin, (3, 3) [kg m2]."""
    T = invariants.T00_B
    return np.trace(T) * np.eye(3) - T + invariants.J0_B


def free_body_mass(package: ModalPackage) -> Array:
    """Mass matrix of the free body at rest, (6 + m, 6 + m): frame, rotation, modes.

    Paper: Eq. (2)
    """
    inv, m = package.invariants, package.n_mode
    M = np.zeros((6 + m, 6 + m))
    x, y, z = inv.S0_B
    M[:3, :3] = inv.mass * np.eye(3)
    M[:3, 3:6] = -np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    M[:3, 6:] = inv.S_B
    M[3:6, 3:6] = inertia_at_rest(inv)
    T = inv.T01_B
    moment = (T[1, 2] - T[2, 1], T[2, 0] - T[0, 2], T[0, 1] - T[1, 0])
    M[3:6, 6:] = np.array(moment) + inv.J_psi_B
    M[6:, 6:] = package.mass
    lower = np.tril_indices(6 + m, -1)
    M[lower] = M.T[lower]
    return M


def rigid_motions(nodes_B: Array) -> Array:
    """Displacement and rotation of nodes (n, 3) when the body moves as a whole, (n, 6, 6).

    The last axis counts unit translations along and small unit rotations about the body axes.
    """
    motions = np.zeros((len(nodes_B), 6, 6))
    motions[:, :3, :3] = motions[:, 3:, 3:] = np.eye(3)
    for k, axis in enumerate(np.eye(3)):
        motions[:, :3, 3 + k] = np.cross(axis, nodes_B)
    return motions


def body_size(package: ModalPackage) -> float:
    """Largest extent of the nodes along an axis of B [m]; 1 m for a single point."""
    return float(np.ptp(package.nodes_B, axis=0).max(initial=0.0)) or 1.0


def mode_motions(package: ModalPackage) -> tuple[Array, Array]:
    """Largest displacement [m] and rotation [rad] of any node per unit of each mode, (m,) both."""
    largest = np.abs(package.shapes_B).max(axis=1, initial=0.0)
    return largest[:, :3].max(axis=1, initial=0.0), largest[:, 3:].max(axis=1, initial=0.0)


def modal_mass_sizes(package: ModalPackage) -> Array:
    """Square root of the modal mass if the whole body moved like its fastest node, (m,)."""
    displacement, rotation = mode_motions(package)
    inv = package.invariants
    inertia = np.trace(inv.J0_B)
    return np.asarray(np.sqrt(np.abs(inv.mass * displacement**2 + inertia * rotation**2)))


def frame_mass_sizes(M: Array) -> Array:
    """Square root of the diagonal of `free_body_mass`; one size for the three rotations."""
    size = np.sqrt(np.abs(np.diagonal(M)))
    size[3:6] = size[3:6].max()
    return np.asarray(size)


def critical_damping(package: ModalPackage) -> Array:
    """2 sqrt(K_ii M_ii) of each mode, (m,) [N m s]."""
    product = np.diagonal(package.stiffness) * np.diagonal(package.mass)
    return np.asarray(2.0 * np.sqrt(np.maximum(product, 0.0)))


def second_order_sizes(package: ModalPackage) -> dict[str, float]:
    """Size of the terms of each second-order table, by the name of its dataset.

    A rotation r of a slender body displaces its points by up to size r^2 to second order.
    """
    displacement, rotation = (float(part.max(initial=0.0)) for part in mode_motions(package))
    reach = max(body_size(package), float(np.abs(package.nodes_B).max(initial=0.0)))
    turn = rotation**2 + (displacement / body_size(package)) ** 2
    h, mass = reach * turn, package.invariants.mass
    return {
        "Z0_B": mass * h,
        "Z1_B": mass * reach * h,
        "G3": mass * displacement * h,
        "G4": mass * h * h,
        "h_B": h,
        "H_B": h,
        "H_psi_B": turn,
    }


MOST_MODES = 40  # G4 has m^4 numbers; bodies with more modes have no second-order data


PIECES = 12  # of a body along its line


def second_order_from_stations(
    m: Array, x_B: Array, phi_B: Array, h_B: Array, along: Array | None = None
) -> SecondOrder:
    """Sum mass stations into the second-order invariants.

    Parameters
    ----------
    m, x_B, phi_B : as in `from_stations`, of the same stations
    h_B : (k, 3, n_mode, n_mode) second-order translation of the mass centres [m]
    along : (k,) places of the stations along the line of a beam, whose pieces of equal length are
        the points [m]; None: no points
    """
    n = phi_B.shape[2]
    weighted = m[:, None, None, None] * h_B
    flat = h_B.reshape(-1, n * n)
    G4 = weighted.reshape(-1, n * n).T @ flat
    return SecondOrder(
        Z0_B=weighted.sum(axis=0),
        Z1_B=np.einsum("ka,kbij->abij", x_B, weighted, optimize=True),
        G3=(phi_B.reshape(-1, n).T @ weighted.reshape(-1, n * n)).reshape(n, n, n),
        G4=(0.5 * (G4 + G4.T)).reshape(n, n, n, n),
        pieces=None if along is None else _pieces(m, x_B, phi_B, h_B, along),
    )


def _pieces(m: Array, x_B: Array, phi_B: Array, h_B: Array, along: Array) -> Pieces:
    """Return mass and mean motion of the pieces of a beam across its line.

    Products with the shortening along the line are of the order of displacements of third order,
    which are neglected: a beam in spin-up bends 0.2 % too far with them.
    """
    piece = np.minimum(PIECES * along / along.max(), PIECES - 1.0).astype(int)
    share = m * (piece == np.arange(PIECES)[:, None])
    mass = share.sum(axis=1)
    share = share[mass > 0.0] / mass[mass > 0.0, None]
    phi, h, centres = (np.tensordot(share, each, 1) for each in (phi_B, h_B, x_B))
    if len(centres) > 1:
        line = np.gradient(centres, axis=0)
        line /= np.linalg.norm(line, axis=1)[:, None]
        phi -= np.einsum("pa,pb,pbi->pai", line, line, phi)
        h -= np.einsum("pa,pb,pbij->paij", line, line, h)
    return Pieces(mass[mass > 0.0], phi, h)


def modal_mass_at(package: ModalPackage, q: Array) -> Array:
    """Modal mass of the body deformed by q (m,), (m, m): a sum over stations, so never negative."""
    second = package.second_order
    if second is None:
        return package.mass
    linear = second.G3 @ q
    bent = np.tensordot(second.G4 @ q, q, axes=(1, 0))  # G4[i, k, j, l] q[k] q[l]
    return np.asarray(package.mass + linear + linear.T + bent)
