"""Mass stations of a beam: positions of its mass and their motion in the modes.

The inertia invariants of a body are sums over stations (solver/package/
invariants.py). With lumped mass the stations are the nodes. With consistent
mass they are the Gauss points of int N' m N dx. There the modes move the section
by phi = N_t X and psi = N_r X. The quadrature is exact, so the sums equal
the consistent mass to round-off.
"""

from dataclasses import dataclass

import numpy as np

from ...solver.math.arrays import Array
from ...solver.math.rotations import skew
from ...solver.package.body.invariants import from_stations
from ...solver.package.body.schema import Invariants
from .element import MASS_POINTS, gauss
from .line import BeamLine


@dataclass(frozen=True)
class Stations:
    """Rigid pieces of the body, referred to their own mass centres, body axes.

    Attributes
    ----------
    m : (k,) masses [kg]
    x_B : (k, 3) rest positions of the mass centres [m]
    phi_B : (k, 3, n_mode) translation of the mass centre per unit mode [m]
    psi_B : (k, 3, n_mode) rotation per unit mode [rad]
    J_B : (k, 3, 3) rotary inertia about the mass centre [kg m2]
    """

    m: Array
    x_B: Array
    phi_B: Array
    psi_B: Array
    J_B: Array

    def invariants(self, mass_form: str) -> Invariants:
        """Sums over the stations. Paper: Eq. (2), Eq. (15)."""
        return from_stations(self.m, self.x_B, self.phi_B, self.psi_B, self.J_B, mass_form)

    def participation(self) -> Array:
        """Modal mass by kind of motion, (4, n_mode, n_mode).

        In the order of `modes.KINDS`: bending-xy (along y, turning about z),
        bending-xz (along z, turning about y), torsion, axial. Their sum is the
        modal mass without products of inertia.
        """
        phi, psi = self.phi_B, self.psi_B
        along = [np.einsum("k,ki,kj->ij", self.m, phi[:, a], phi[:, a]) for a in range(3)]
        about = [
            np.einsum("k,ki,kj->ij", self.J_B[:, a, a], psi[:, a], psi[:, a]) for a in range(3)
        ]
        return np.array([along[1] + about[2], along[2] + about[1], about[0], along[0]])


def mass_stations(line: BeamLine, columns_B: Array, mass_form: str) -> Stations:
    """Mass stations of a beam and their motion under nodal displacement columns.

    Parameters
    ----------
    line : the beam
    columns_B : (6 n, n_mode) nodal displacements and rotations, body axes [m, rad]
    mass_form : "consistent" (Gauss points) or "lumped" (nodes)
    """
    if mass_form == "lumped":
        return _lumped(line, columns_B)
    return _consistent(line, columns_B)


def nodal_mass(line: BeamLine) -> tuple[Array, Array]:
    """Lumped mass of each node, (n,) [kg], and inertia about the node, (n, 3, 3) [kg m2]."""
    lengths = np.zeros(line.n_node)
    for element, numbers in line.spans:
        np.add.at(lengths, numbers, 0.5 * element.length)
        np.add.at(lengths, numbers + 1, 0.5 * element.length)
    J_node_B = line.A_BE @ line.mass[3:, 3:] @ line.A_BE.T
    return lengths * line.section_mass.m, lengths[:, None, None] * J_node_B


def _lumped(line: BeamLine, columns_B: Array) -> Stations:
    mass, _ = nodal_mass(line)
    nodal = columns_B.reshape(line.n_node, 6, -1)
    return _at_mass_centre(line, mass, line.nodes_B, nodal[:, :3], nodal[:, 3:])


def _consistent(line: BeamLine, columns_B: Array) -> Stations:
    nodal_E = line.to_element(columns_B)
    mass, position, motion = [], [], []
    for element, numbers in line.spans:
        x, w = gauss(element.length, MASS_POINTS)
        motion_E = np.einsum("gai,eim->egam", element.shape(x), nodal_E[numbers], optimize=True)
        motion.append(motion_E.reshape(x.size * len(numbers), 6, motion_E.shape[-1]))
        position.append((line.x_B[numbers][:, None] + x).ravel())
        mass.append(np.tile(w * line.section_mass.m, len(numbers)))
    x_B = np.zeros((sum(map(len, mass)), 3))
    x_B[:, 0] = np.concatenate(position)
    motion_all = np.concatenate(motion)
    phi_B = np.einsum("ab,kbm->kam", line.A_BE, motion_all[:, :3])
    psi_B = np.einsum("ab,kbm->kam", line.A_BE, motion_all[:, 3:])
    return _at_mass_centre(line, np.concatenate(mass), x_B, phi_B, psi_B)


def _at_mass_centre(
    line: BeamLine, mass: Array, x_B: Array, phi_B: Array, psi_B: Array
) -> Stations:
    """Move stations from the reference line to the section's mass centre."""
    slice_ = line.section_mass
    centre_B = line.A_BE @ slice_.centre_E
    J_B = line.A_BE @ slice_.J_E @ line.A_BE.T
    lengths = mass / slice_.m
    return Stations(
        m=mass,
        x_B=x_B + centre_B,
        phi_B=phi_B - skew(centre_B) @ psi_B,
        psi_B=psi_B,
        J_B=lengths[:, None, None] * J_B,
    )
