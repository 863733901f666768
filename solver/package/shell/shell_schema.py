"""A laminated shell and its results in memory and in its file: mesh, laminates, cases, modes.

Lengths in m, forces in N. `_G` are the axes of the model, `_E` those of a cell and of its
laminate: e3 the normal, e1 the reference direction projected on the cell. Plies are listed from
bottom to top along e3. Resultants of a cell come in the order N 3 [N/m], M 3 [N], T 2 [N/m], for
unit width: N11 N22 N12, M11 M22 M12, T1 T2. Displacements of a node are ux uy uz rx ry rz.

Sizes: `n` nodes, `c` cells, `i` connectivity entries, `r` regions, `b` laminates, `k` plies of
all laminates, `l` load cases, `s` supports, `e` links, `o` probes, `m` modes, `b2` load factors,
`w` warnings. The mapper of common/dataset.py writes and reads the fields.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Annotated, Any

import numpy as np

from ...errors import PackageError
from ...math.arrays import Array, IntArray
from ..common.cells import QUADRILATERAL, TRIANGLE, cell_table, vtk_cells
from ..common.dataset import Data, Nested, Reported, Rows
from ..common.recovery_schema import ShellPly

SHELL_FORMAT = "plymotion shell"
SHELL_FORMAT_VERSION = (1, 2)

SHELL_RESULTANTS = ("N11", "N22", "N12", "M11", "M22", "M12", "T1", "T2")
SHELL_MOTIONS = ("ux", "uy", "uz", "rx", "ry", "rz")
SHELL_STRESSES = ("11", "22", "33", "23", "13", "12")


@dataclass(frozen=True)
class CellRows:
    """Cells of 3 or 4 nodes as VTK has them."""

    connectivity: Annotated[
        IntArray, Data("i", text="nodes of all cells, as 0-based rows of nodes_G")
    ]
    offsets: Annotated[
        IntArray, Data("c+1", text="cell j owns connectivity[offsets[j]:offsets[j+1]]")
    ]
    cell_types: Annotated[
        IntArray, Data("c", text="VTK cell types, triangles and quadrilaterals", type="uint8")
    ]

    @classmethod
    def of(cls, cells: IntArray) -> "CellRows":
        """Return the stored form of a table of cells."""
        return cls(*vtk_cells(cells))

    def value(self) -> IntArray:
        """Return the table of cells. Raises PackageError for others."""
        if not np.isin(self.cell_types, (TRIANGLE, QUADRILATERAL)).all():
            text = f"expected triangles and quadrilaterals, types {TRIANGLE} and {QUADRILATERAL}"
            raise PackageError(f"/shell/mesh/cell_types: {text}")
        return cell_table(self.connectivity, self.offsets)


@dataclass(frozen=True)
class ShellMeshData:
    """The mesh of a shell in the order of its mesh file."""

    nodes_G: Annotated[Array, Data("n, 3", "m", "G", "rest positions of the nodes")]
    node_ids: Annotated[IntArray, Data("n", text="numbers of the nodes in the mesh file, unique")]
    cells: Annotated[IntArray, Nested(via=CellRows)]  # (c, 3), (c, 4): see cells.py
    region: Annotated[IntArray, Data("c", text="region of each cell, as row of regions")]
    regions: Annotated[tuple[str, ...], Data("r", text="names of the regions, unique")]
    laminate: Annotated[IntArray, Data("r", text="laminate of each region, as row of laminates")]
    A_GE: Annotated[
        Array, Data("c, 3, 3", "-", "E to G", "rotation, axes of cell and laminate to G")
    ]
    area: Annotated[Array, Data("c", "m2", "-", "area of each cell")]


@dataclass(frozen=True)
class ShellLaminate:
    """A laminate of the shell; `k` counts its plies, bottom to top."""

    name: str
    plies: tuple[ShellPly, ...]
    ABD: Array  # (6, 6) of (N, M) to (e, kappa)            [N/m, N, N m]
    Ds: Array  # (2, 2) transverse shear, corrected         [N/m]
    mass: Array  # (3,) moments of density about z = 0      [kg/m2, kg/m, kg]
    stress_M: Array  # (k, 3, 6, 8) stress in ply axes per unit resultant, at LEVELS
    report: dict[str, Any] = field(default_factory=dict)  # symmetric, balanced, constants, ...

    @property
    def thickness(self) -> float:
        """Sum of all plies [m]."""
        return self.plies[-1].top - self.plies[0].bottom


@dataclass(frozen=True)
class LaminateRows:
    """Laminates as they are stored: their plies in one table."""

    names: Annotated[
        tuple[str, ...], Data("b", text="names of the laminates, unique", path="laminates/names")
    ]
    ABD: Annotated[
        Array,
        Data("b, 6, 6", "N/m, N, N m", "E", "(N, M) per unit strain, curvature", "laminates/ABD"),
    ]
    Ds: Annotated[
        Array, Data("b, 2, 2", "N/m", "E", "transverse shear stiffness, corrected", "laminates/Ds")
    ]
    mass: Annotated[
        Array,
        Data("b, 3", "kg/m2, kg/m, kg", "-", "density times 1, z, z^2 over z", "laminates/mass"),
    ]
    report: Annotated[
        tuple[dict[str, Any], ...],
        Data("b", "-", "-", "symmetry, balance, constants, as JSON text", "laminates/reports"),
    ]
    owner: Annotated[
        IntArray,
        Data("k", "-", "-", "laminate of each ply, as row; bottom to top", "plies/laminate"),
    ]
    plies: Annotated[tuple[ShellPly, ...], Rows("plies", "k")]
    stress_M: Annotated[
        Array,
        Data(
            "k, 3, 6, 8",
            "1/m, 1/m2",
            "ply",
            "stress 11 22 33 23 13 12 at bottom, middle, top per unit resultant",
            "plies/stress_M",
        ),
    ]

    @classmethod
    def of(cls, laminates: Sequence[ShellLaminate]) -> "LaminateRows":
        """Return the columns of laminates."""
        return cls(
            tuple(one.name for one in laminates),
            np.array([one.ABD for one in laminates]),
            np.array([one.Ds for one in laminates]),
            np.array([one.mass for one in laminates]),
            tuple(one.report for one in laminates),
            np.repeat(np.arange(len(laminates)), [len(one.plies) for one in laminates]),
            tuple(ply for one in laminates for ply in one.plies),
            np.concatenate([one.stress_M for one in laminates]),
        )

    def value(self) -> tuple[ShellLaminate, ...]:
        """Return the laminates."""
        columns = zip(self.names, self.ABD, self.Ds, self.mass, self.report, strict=True)
        laminates = []
        for row, (name, ABD, Ds, mass, report) in enumerate(columns):
            own = np.flatnonzero(self.owner == row)
            plies = tuple(self.plies[k] for k in own)
            laminates.append(ShellLaminate(name, plies, ABD, Ds, mass, self.stress_M[own], report))
        return tuple(laminates)


@dataclass(frozen=True)
class ShellPlaces:
    """Named points of supports: reference points of their reaction moments."""

    names: Annotated[tuple[str, ...], Data("s", text="names of the supports")]
    points_G: Annotated[Array, Data("s, 3", "m", "G", "reference points of the reaction moments")]


@dataclass(frozen=True)
class ShellLinks:
    """Named points of links."""

    names: Annotated[tuple[str, ...], Data("e", text="names of the links")]
    points_G: Annotated[Array, Data("e, 3", "m", "G", "reference points")]
    kinds: Annotated[tuple[str, ...], Data("e", text="rigid or average")] = ()


@dataclass(frozen=True)
class ShellCases:
    """Results of load cases."""

    names: Annotated[tuple[str, ...], Data("l", text="names of the load cases")]
    displacements_G: Annotated[
        Array, Data("l, n, 6", "m, rad", "G", "ux uy uz rx ry rz of the nodes")
    ]
    resultants_E: Annotated[
        Array, Data("l, c, 8", "N/m, N", "E", "N 3, M 3, T 2, mean of each cell")
    ]
    link_motions_G: Annotated[
        Array, Data("l, e, 6", "m, rad", "G", "motion of the reference points")
    ]
    loads_G: Annotated[
        Array, Data("l, 6", "N, N m", "G", "resultant of the load, about the origin")
    ]
    reactions_G: Annotated[
        Array, Data("l, s, 6", "N, N m", "G", "of each support, about its point")
    ]
    energy: Annotated[Array, Data("l", "J", "-", "strain energy")]
    residual: Annotated[Array, Data("l", "-", "-", "residual of equilibrium, relative")]
    error: Annotated[  # None: not estimated
        Array | None, Data("l", "-", "-", "relative, of energy by the mesh; too high: above 0")
    ] = None


@dataclass(frozen=True)
class ShellProbes:
    """Values requested by the description."""

    names: Annotated[tuple[str, ...], Data("o", text="names of the probes")]
    quantities: Annotated[  # of SHELL_MOTIONS or SHELL_RESULTANTS
        tuple[str, ...], Data("o", text="what each probe reads")
    ]
    values: Annotated[Array, Data("l, o", "SI", "G or E", "what it read in each load case")]


@dataclass(frozen=True)
class ShellModes:
    """Natural modes, unit modal mass."""

    frequencies: Annotated[Array, Data("m", "rad/s", "-", "natural frequencies")]
    shapes_G: Annotated[Array, Data("m, n, 6", "m, rad", "G", "unit modal mass")]
    resultants_E: Annotated[Array, Data("m, c, 8", "N/m, N", "E", "as of cases")]
    n_zero: Annotated[int, Data(text="modes without strain energy, the first")]
    error: Annotated[  # None: not estimated
        Array | None, Data("m", "-", "-", "relative, by the mesh; too high: above 0")
    ] = None

    @property
    def frequencies_hz(self) -> Array:
        """Natural frequencies [Hz]."""
        return np.asarray(self.frequencies / (2.0 * np.pi))


@dataclass(frozen=True)
class ShellBuckling:
    """Load factors of linear buckling of all load cases, ascending in each case."""

    case: Annotated[IntArray, Data("b2", text="load case of each factor, as row")]
    factors: Annotated[Array, Data("b2", "-", "-", "load factors of buckling")]  # above 0
    shapes_G: Annotated[Array, Data("b2, n, 6", "m, rad", "G", "largest motion 1 m")]
    reversed: Annotated[  # smallest below 0; 0: none, or not asked for
        Array, Data("l", "-", "-", "factor of the reversed load")
    ]
    error: Annotated[Array | None, Data("b2", "-", "-", "as of modes")] = None


@dataclass(frozen=True)
class ShellFile:
    """The content of a shell results file."""

    name: str
    mesh: Annotated[ShellMeshData, Nested("mesh")]
    laminates: Annotated[tuple[ShellLaminate, ...], Nested(via=LaminateRows)]
    materials: Annotated[
        dict[str, dict[str, Any]], Data(text="constants and strengths by name, as JSON text")
    ]
    supports: Annotated[ShellPlaces, Nested("supports")]
    links: Annotated[ShellLinks, Nested("links")]
    cases: Annotated[ShellCases, Nested("cases")]
    probes: Annotated[ShellProbes, Nested("probes")]
    modes: Annotated[ShellModes | None, Nested("modes")] = None
    buckling: Annotated[ShellBuckling | None, Nested("buckling")] = None
    warnings: Annotated[tuple[dict[str, str], ...], Nested("warnings", via=Reported)] = ()
    provenance: dict[str, Any] = field(default_factory=dict)  # spec, dofs, seconds, versions, ...
