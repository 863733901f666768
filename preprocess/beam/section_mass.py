"""A slice of a beam as a rigid plate: mass, mass centre, rotary inertia."""

from dataclasses import dataclass

import numpy as np

from ...solver.math.arrays import Array
from ...solver.math.rotations import skew

TOLERANCE = 1e-9  # relative deviation from the mass matrix of a rigid slice


@dataclass(frozen=True)
class SectionMass:
    """Inertia of a slice, per length, in section axes.

    Attributes
    ----------
    m : mass per length [kg/m]
    centre_E : (3,) mass centre from the reference line [m]
    J_E : (3, 3) rotary inertia about the mass centre [kg m]
    """

    m: float
    centre_E: Array
    J_E: Array

    @classmethod
    def from_matrix(cls, mass: Array) -> "SectionMass":
        """Decompose the 6x6 mass per length: [[m, -m c~], [m c~, J - m c~ c~]].

        Raises
        ------
        ValueError : the matrix is not that of a rigid slice, so it has no mass
            centre and inertia; or no distribution of mass has this inertia.
        """
        m = float(np.trace(mass[:3, :3]) / 3.0)
        if not m > 0.0:
            raise ValueError(f"the section's mass per length must be positive, it is {m:.6g} kg/m")
        moment = mass[3:, :3] / m
        centre = np.array([moment[2, 1], moment[0, 2], moment[1, 0]])
        J = mass[3:, 3:] + m * skew(centre) @ skew(centre)
        slice_ = cls(m, centre, 0.5 * (J + J.T))
        scale = np.sqrt(np.diagonal(mass).clip(min=0.0))
        scale[3:] = scale[3:].max()  # a flat strip has no rotary inertia about one of its axes
        gap = np.abs(slice_.matrix() - mass) - TOLERANCE * np.outer(scale, scale)
        if gap.max() > 0.0:
            i, j = (int(k) for k in np.unravel_index(np.argmax(gap), gap.shape))
            raise ValueError(
                "the section's 6x6 mass is not that of a rigid slice: entry "
                f"[{i}, {j}] is {mass[i, j]:.9g}, expected {slice_.matrix()[i, j]:.9g}"
            )
        E = second_moments(slice_.J_E[None])[0][0]
        if E.min() < -TOLERANCE * float(np.trace(mass[3:, 3:])):
            a, b, c = np.linalg.eigvalsh(slice_.J_E)
            raise ValueError(
                f"the section's rotary inertia about its mass centre is impossible: {a:.6g}, "
                f"{b:.6g}, {c:.6g} kg m, expected no value above the sum of the others"
            )
        return slice_

    def matrix(self) -> Array:
        """The 6x6 mass per length at the reference line, section axes."""
        c = skew(self.centre_E)
        lower = self.m * c
        return np.block([[self.m * np.eye(3), -lower], [lower, self.J_E - self.m * c @ c]])


def second_moments(J: Array) -> tuple[Array, Array]:
    """Principal second moments of mass of rotary inertias (k, 3, 3): E = 1/2 tr(J) 1 - J.

    Returns the moments (k, 3), negative only in an impossible inertia and in round-off, and their
    axes, the columns of (k, 3, 3).
    """
    half = 0.5 * np.trace(J, axis1=1, axis2=2)
    E, axes = np.linalg.eigh(half[:, None, None] * np.eye(3) - J)
    return E, axes
