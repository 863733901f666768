"""Slices of a beam as point masses: rotary inertia to all orders of the motion.

A slice of mass m and rotary inertia J about its centre turns by a finite rotation with the modes.
J in body axes then changes, to first and second order in the modal coordinates. Instead of these
terms, each slice is replaced by points fixed to it, with the same mass, centre and inertia:

    E = 1/2 tr(J) 1 - J = sum m_k s_k s_k'

Along each principal axis e_a of E with E_a > 0, of which there are c, two points lie at
+-sqrt(c E_a / m) e_a, each of mass m / (2 c). A thin slice has two such axes and four points, a
lumped mass with inertia of its own along the beam six. All terms of rotary inertia are then sums
over points without rotary inertia: gyroscopic moments of the deformed body and the propeller
moment of a spinning blade (docs/stiffening.md, docs/adr/0021).
"""

from dataclasses import dataclass

import numpy as np

from ...solver.math.arrays import Array, IntArray
from ...solver.package.body.invariants import from_stations
from ...solver.package.body.schema import Invariants
from .section_mass import second_moments
from .stations import Stations

ABSENT = 1e-9  # of the largest second moment: smaller ones are round-off


@dataclass(frozen=True)
class PointMasses:
    """Point masses that move with the slices of a beam, body axes.

    Attributes
    ----------
    slice_of : (p,) slice of each point
    s_B : (p, 3) from the mass centre of the slice to the point [m]
    m : (p,) masses [kg]
    x_B : (p, 3) rest positions [m]
    phi_B : (p, 3, n_mode) translation per unit mode [m]
    """

    slice_of: IntArray
    s_B: Array
    m: Array
    x_B: Array
    phi_B: Array

    def invariants(self, mass_form: str) -> Invariants:
        """Sums over the points; no rotary inertia is left. Paper: Eq. (2), Eq. (15)."""
        none = np.zeros_like(self.phi_B)
        J = np.zeros((len(self.m), 3, 3))
        return from_stations(self.m, self.x_B, self.phi_B, none, J, mass_form)


def point_masses(stations: Stations) -> PointMasses:
    """Replace the slices of a beam by point masses."""
    E, axes = second_moments(stations.J_B)
    kept = ABSENT * np.abs(E).max(axis=1, keepdims=True) < E
    count = kept.sum(axis=1)
    slice_of, axis = np.nonzero(kept)
    share = count[slice_of]
    length = np.sqrt(share * E[slice_of, axis] / stations.m[slice_of])
    s = length[:, None] * axes[slice_of, :, axis]
    half = stations.m[slice_of] / (2.0 * share)
    bare = np.flatnonzero(count == 0)  # without rotary inertia: one point at the centre
    slice_of = np.concatenate([slice_of, slice_of, bare])
    s = np.concatenate([s, -s, np.zeros((len(bare), 3))])
    m = np.concatenate([half, half, stations.m[bare]])
    return PointMasses(
        slice_of=slice_of,
        s_B=s,
        m=m,
        x_B=stations.x_B[slice_of] + s,
        phi_B=stations.phi_B[slice_of] + np.cross(stations.psi_B[slice_of], s[:, :, None], axis=1),
    )
