"""A beam divided into straight elements: nodes, section axes, assembled matrices.

The reference line of a beam may be curved and its sections may twist and change along it. Each
element is straight between its two nodes and has its own section and section axes. A straight
beam lies on the x axis of the body frame `_B`, from the origin; the section's x2 axis is given
in this frame, x3 = x cross x2.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
import scipy.sparse as sp

from ...solver.math.arrays import Array, IntArray
from ...solver.math.rotations import skew
from .element import BeamElement

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


@dataclass(frozen=True)
class LineSection:
    """Section of one or more elements, section axes.

    Attributes
    ----------
    K : (6, 6) stiffness, order extension, shear2, shear3, twist, bend2, bend3 [N, N m, N m2]
    mass : (6, 6) mass per length for the velocities along and rotations about the section axes,
        taken at the reference line [kg/m, kg, kg m]
    trapeze : (6,) strains of a section twisted by 1 rad/m, times -2 (see `trapeze_strains`)
    """

    K: Array
    mass: Array
    trapeze: Array = field(default_factory=lambda: np.zeros(6))

    def scaled(self, of: "LineSection") -> dict[str, Array]:
        """Return arrays of another section or rates, entries as shares of the diagonals here.

        Stiffnesses in tension and bending differ by the square of the size of the section in m.
        """
        d, m = (np.sqrt(np.diag(matrix)) for matrix in (self.K, self.mass))
        m[m == 0.0] = np.inf  # a flat strip has no rotary inertia about one of its axes
        return {
            "K": of.K / np.outer(d, d),
            "mass": of.mass / np.outer(m, m),
            "trapeze": of.trapeze * d,
        }

    @cached_property
    def slice_mass(self) -> SectionMass:
        """Mass, mass centre and inertia of a slice, from the 6x6 mass."""
        return SectionMass.from_matrix(self.mass)


@dataclass(frozen=True)
class Span:
    """The elements of one length and one section.

    Attributes
    ----------
    element : any of them, in element axes
    numbers : (k,) their numbers
    section : their section
    """

    element: BeamElement
    numbers: IntArray
    section: LineSection


@dataclass(frozen=True)
class BeamLine:
    """A beam divided into e straight elements.

    Attributes
    ----------
    nodes_B : (n, 3) node positions [m]
    A_BE : (e, 3, 3) section axes (columns x1 x2 x3) of each element in body axes
    sections : the sections
    section_of : (e,) section of each element
    step : element k is between the nodes step k and step k + 1; 2: no element shares a node
    """

    nodes_B: Array
    A_BE: Array
    sections: tuple[LineSection, ...]
    section_of: IntArray
    step: int = 1

    @property
    def n_node(self) -> int:
        """Number of nodes n."""
        return len(self.nodes_B)

    @cached_property
    def lengths(self) -> Array:
        """Length of each element, (e,) [m]."""
        return np.linalg.norm(np.diff(self.nodes_B, axis=0)[:: self.step], axis=1)

    @cached_property
    def along(self) -> Array:
        """Position of the ends of elements along the line, (e + 1,), rising from 0 [m]."""
        return np.concatenate([[0.0], np.cumsum(self.lengths)])

    @property
    def is_straight(self) -> bool:
        """True if all nodes are on the x axis."""
        return not self.nodes_B[:, 1:].any()

    @cached_property
    def spans(self) -> list[Span]:
        """Elements of equal length and section together."""
        # lengths from linspace positions differ in the last bits; treat them as equal
        rounded = np.round(self.lengths / self.along[-1], 12)
        keys = np.column_stack([rounded, self.section_of])
        result = []
        for value in np.unique(keys, axis=0):
            numbers = np.flatnonzero((keys == value).all(axis=1))
            section = self.sections[int(value[1])]
            element = BeamElement(float(self.lengths[numbers].mean()), section.K)
            result.append(Span(element, numbers, section))
        return result

    def stiffness(self) -> sp.csr_matrix:
        """Stiffness of the free beam in body axes, (6 n, 6 n), with six dofs per node."""
        return self._assemble([span.element.stiffness() for span in self.spans])

    def mass_matrix(self, mass_form: str) -> sp.csr_matrix:
        """Mass of the free beam in body axes, (6 n, 6 n).

        Parameters
        ----------
        mass_form : "consistent" (int N' m N) or "lumped" (half of each element
            to each of its nodes)
        """
        return self._assemble(
            [span.element.mass_matrix(span.section.mass, mass_form) for span in self.spans]
        )

    def to_element(self, columns_B: Array) -> Array:
        """Nodal columns (6 n, m) as the 12 values of each element in section axes, (e, 12, m)."""
        nodal = columns_B.reshape(self.n_node, 2, 3, -1)
        starts, stops = nodal[: -1 : self.step], nodal[1 :: self.step]
        ends = [np.einsum("eba,epbm->epam", self.A_BE, part) for part in (starts, stops)]
        return np.concatenate(ends, axis=1).reshape(len(self.A_BE), 12, -1)

    def _assemble(self, matrices: list[Array]) -> sp.csr_matrix:
        rows, columns, values = [], [], []
        for span, matrix_E in zip(self.spans, matrices, strict=True):
            turn = np.einsum("ij,eab->eiajb", np.eye(4), self.A_BE[span.numbers])
            turn = turn.reshape(-1, 12, 12)
            matrix_B = turn @ matrix_E @ turn.transpose(0, 2, 1)
            dofs = 6 * self.step * span.numbers[:, None] + np.arange(12)
            rows.append(np.repeat(dofs, 12, axis=1).ravel())
            columns.append(np.tile(dofs, (1, 12)).ravel())
            values.append(0.5 * (matrix_B + matrix_B.transpose(0, 2, 1)).ravel())
        shape = (6 * self.n_node, 6 * self.n_node)
        entries = (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns)))
        return sp.coo_matrix(entries, shape=shape).tocsr()


def on_x_axis(x_B: Array | Sequence[float]) -> Array:
    """Points (n, 3) on the x axis."""
    nodes = np.zeros((len(x_B), 3))
    nodes[:, 0] = x_B
    return nodes


def section_axes(x2_axis_B: Array | list[float]) -> Array:
    """Section axes in body axes, (3, 3): columns x1 = body x, x2 as given, x3 = x1 x x2.

    Raises
    ------
    ValueError : x2 is not a unit vector orthogonal to the body x axis.
    """
    x2 = np.asarray(x2_axis_B, dtype=float)
    if x2.shape != (3,) or abs(np.linalg.norm(x2) - 1.0) > 1e-6 or abs(x2[0]) > 1e-6:
        raise ValueError("expected a unit vector of 3 numbers orthogonal to the body x axis")
    x2 = np.array([0.0, x2[1], x2[2]]) / np.hypot(x2[1], x2[2])
    x1 = np.array([1.0, 0.0, 0.0])
    return np.column_stack([x1, x2, np.cross(x1, x2)])
