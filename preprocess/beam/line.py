"""A straight beam divided into elements: nodes, section axes, assembled matrices.

The body frame `_B` has its origin at the first node of the reference line and
its x axis along the beam; the section's x2 axis is given in this frame, x3 = x cross x2.
"""

from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise

import numpy as np
import scipy.sparse as sp

from ...solver.math.arrays import Array, IntArray
from .element import BeamElement
from .section_mass import SectionMass


@dataclass(frozen=True)
class BeamLine:
    """A uniform straight beam divided into elements.

    Attributes
    ----------
    x_B : (n,) node positions along the body x axis, rising [m]
    K : (6, 6) section stiffness, order extension, shear2, shear3, twist, bend2,
        bend3 [N, N m, N m2]
    mass : (6, 6) section mass per length for the velocities along and rotations
        about the section axes, taken at the reference line [kg/m, kg, kg m]
    A_BE : (3, 3) section axes (columns x1 x2 x3) in body axes
    trapeze : (6,) strains of a section twisted by 1 rad/m, times -2 (see `trapeze_strains`)
    """

    x_B: Array
    K: Array
    mass: Array
    A_BE: Array
    trapeze: Array = field(default_factory=lambda: np.zeros(6))

    @property
    def n_node(self) -> int:
        """Number of nodes n."""
        return len(self.x_B)

    @property
    def nodes_B(self) -> Array:
        """Node positions, (n, 3) [m]."""
        nodes = np.zeros((self.n_node, 3))
        nodes[:, 0] = self.x_B
        return nodes

    @cached_property
    def section_mass(self) -> SectionMass:
        """Mass, mass centre and inertia of a slice, from the 6x6 mass."""
        return SectionMass.from_matrix(self.mass)

    @cached_property
    def spans(self) -> list[tuple[BeamElement, IntArray]]:
        """One element for every distinct length, with the element numbers (k,) that have it."""
        lengths = np.diff(self.x_B)
        # lengths from linspace positions differ in the last bits; treat them as equal
        rounded = np.round(lengths / self.x_B[-1], 12)
        return [
            (
                BeamElement(float(lengths[rounded == value].mean()), self.K),
                np.nonzero(rounded == value)[0],
            )
            for value in np.unique(rounded)
        ]

    def stiffness(self) -> sp.csr_matrix:
        """Stiffness of the free beam in body axes, (6 n, 6 n), with six dofs per node."""
        return self._assemble([element.stiffness() for element, _ in self.spans])

    def mass_matrix(self, mass_form: str) -> sp.csr_matrix:
        """Mass of the free beam in body axes, (6 n, 6 n).

        Parameters
        ----------
        mass_form : "consistent" (int N' m N) or "lumped" (half of each element
            to each of its nodes)
        """
        return self._assemble([e.mass_matrix(self.mass, mass_form) for e, _ in self.spans])

    def to_element(self, columns_B: Array) -> Array:
        """Nodal columns (6 n, m) as the 12 values of each element in section axes, (e, 12, m)."""
        nodal = columns_B.reshape(self.n_node, 2, 3, -1)
        nodal_E = np.einsum("ae,kpam->kpem", self.A_BE, nodal).reshape(self.n_node, 6, -1)
        return np.concatenate([nodal_E[:-1], nodal_E[1:]], axis=1)

    def _assemble(self, matrices: list[Array]) -> sp.csr_matrix:
        turn = np.kron(np.eye(4), self.A_BE)
        rows, columns, values = [], [], []
        for (_, numbers), matrix_E in zip(self.spans, matrices, strict=True):
            matrix_B = turn @ matrix_E @ turn.T
            dofs = 6 * numbers[:, None] + np.arange(12)
            rows.append(np.repeat(dofs, 12, axis=1).ravel())
            columns.append(np.tile(dofs, (1, 12)).ravel())
            values.append(np.tile(0.5 * (matrix_B + matrix_B.T).ravel(), len(numbers)))
        shape = (6 * self.n_node, 6 * self.n_node)
        entries = (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns)))
        return sp.coo_matrix(entries, shape=shape).tocsr()


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


def node_positions(length: float, elements: int, stops: list[float]) -> Array:
    """Divide a beam into elements with a node at every stop.

    Parameters
    ----------
    length : length of the beam [m]
    elements : total number of elements
    stops : fractions of the length (0 to 1) that need a node

    Returns
    -------
    (elements + 1,) positions [m]: uniform if the stops allow it, otherwise
    uniform between stops, with the elements distributed by length.

    Raises
    ------
    ValueError : fewer elements than stretches between stops.
    """
    inner = sorted({0.0, 1.0, *stops})
    cuts = [inner[0]] + [b for a, b in pairwise(inner) if b - a > 1e-9]
    cuts[-1] = 1.0
    stretches = np.diff(cuts)
    if elements < len(stretches):
        raise ValueError(
            f"expected at least {len(stretches)}, one between any two neighbouring interfaces"
        )
    # each additional element goes to the stretch with the longest elements
    counts = np.ones(len(stretches), dtype=int)
    for _ in range(elements - len(stretches)):
        counts[np.argmax(np.round(stretches / counts, 12))] += 1
    parts = [
        np.linspace(a, b, k, endpoint=False)
        for a, b, k in zip(cuts[:-1], cuts[1:], counts, strict=True)
    ]
    return length * np.append(np.concatenate(parts), 1.0)
