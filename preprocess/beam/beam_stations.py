"""Mass of a beam as stations and as point masses: positions and motion in the modes."""

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np

from ...solver.math.arrays import Array, IntArray
from ...solver.math.rotations import skew
from ...solver.package.body.invariants import from_stations
from ...solver.package.body.package_schema import Invariants
from .element import MASS_POINTS, gauss
from .line import BeamLine, second_moments


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

    @staticmethod
    def joined(parts: "Sequence[Stations]") -> "Stations":
        """All stations, one part after the other."""
        names = (one.name for one in fields(Stations))
        return Stations(*(np.concatenate([getattr(p, name) for p in parts]) for name in names))

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


def nodal_mass(line: BeamLine) -> tuple[Array, Array]:
    """Lumped mass of each node, (n,) [kg], and inertia about the node, (n, 3, 3) [kg m2]."""
    mass, inertia = np.zeros(line.n_node), np.zeros((line.n_node, 3, 3))
    for span in line.spans:
        half, A = 0.5 * span.element.length, line.A_BE[span.numbers]
        J_B = half * A @ span.section.mass[3:, 3:] @ A.transpose(0, 2, 1)
        for end in range(2):
            nodes = line.step * span.numbers + end
            np.add.at(mass, nodes, half * span.section.slice_mass.m)
            np.add.at(inertia, nodes, J_B)
    return mass, inertia


def station_places(length: float, mass_form: str) -> tuple[Array, Array]:
    """Places of the stations of an element and the lengths that belong to them, (g,) each [m]."""
    if mass_form == "lumped":
        return np.array([0.0, length]), np.full(2, 0.5 * length)
    return gauss(length, MASS_POINTS)


def places_along(line: BeamLine, mass_form: str) -> Array:
    """Places of `mass_stations` along the line, (k,) [m]."""
    return np.concatenate(
        [
            np.add.outer(
                line.along[span.numbers],
                station_places(span.element.length, mass_form)[0],
            ).ravel()
            for span in line.spans
        ]
    )


def mass_stations(line: BeamLine, columns_B: Array, mass_form: str) -> Stations:
    """Mass stations of a beam and their motion under nodal displacement columns.

    Parameters
    ----------
    line : the beam
    columns_B : (6 n, n_mode) nodal displacements and rotations, body axes [m, rad]
    mass_form : "consistent" (Gauss points) or "lumped" (the ends of each element)
    """
    nodal_E = line.to_element(columns_B)
    parts = []
    for span in line.spans:
        x, w = station_places(span.element.length, mass_form)
        motion = span.element.shape(x) @ nodal_E[span.numbers][:, None]  # (e, g, 6, m)
        slice_, A = span.section.slice_mass, line.A_BE[span.numbers][:, None]
        place = slice_.centre_E + x[:, None] * np.array([1.0, 0.0, 0.0])
        phi = motion[:, :, :3] - skew(slice_.centre_E) @ motion[:, :, 3:]
        inertia = A @ slice_.J_E @ A.swapaxes(-1, -2)
        start = line.nodes_B[line.step * span.numbers][:, None]
        count = len(x) * len(span.numbers)
        parts.append(
            Stations(
                m=np.tile(w * slice_.m, len(span.numbers)),
                x_B=(start + np.einsum("eab,gb->ega", A[:, 0], place)).reshape(count, 3),
                phi_B=(A @ phi).reshape(count, 3, -1),
                psi_B=(A @ motion[:, :, 3:]).reshape(count, 3, -1),
                J_B=(w[:, None, None] * inertia).reshape(count, 3, 3),
            )
        )
    return Stations.joined(parts)


ABSENT = 1e-9  # of the largest second moment: smaller ones are round-off


@dataclass(frozen=True)
class PointMasses(Stations):
    """Point masses that move with the slices of a beam: stations without rotary inertia.

    Attributes
    ----------
    slice_of : (p,) slice of each point
    s_B : (p, 3) from the mass centre of the slice to the point [m]
    """

    slice_of: IntArray
    s_B: Array


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
    turned = np.cross(stations.psi_B[slice_of], s[:, :, None], axis=1)
    phi_B = stations.phi_B[slice_of] + turned
    none = np.zeros_like(phi_B), np.zeros((len(m), 3, 3))
    return PointMasses(m, stations.x_B[slice_of] + s, phi_B, *none, slice_of, s)
