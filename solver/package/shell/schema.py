"""A laminated shell and its results in memory: mesh, laminates, load cases, natural modes.

Lengths in m, forces in N. `_G` are the axes of the model, `_E` those of a cell and of its
laminate: e3 the normal, e1 the reference direction projected on the cell. Plies are listed from
bottom to top along e3. Resultants of a cell come in the order N 3 [N/m], M 3 [N], T 2 [N/m], for
unit width: N11 N22 N12, M11 M22 M12, T1 T2. Displacements of a node are ux uy uz rx ry rz.
"""

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ...math.arrays import Array, IntArray

SHELL_FORMAT = "plymotion shell"
SHELL_FORMAT_VERSION = (1, 2)

SHELL_RESULTANTS = ("N11", "N22", "N12", "M11", "M22", "M12", "T1", "T2")
SHELL_MOTIONS = ("ux", "uy", "uz", "rx", "ry", "rz")
SHELL_STRESSES = ("11", "22", "33", "23", "13", "12")
LEVELS = ("bottom", "middle", "top")  # of a ply


@dataclass(frozen=True)
class ShellMeshData:
    """The mesh of a shell in the order of its mesh file; `n` counts nodes, `c` cells."""

    nodes_G: Array  # (n, 3)                                [m]
    node_ids: IntArray  # (n,) number in the mesh file
    cells: IntArray  # (c, 3) rows of nodes_G, or (c, 4) with quadrilaterals: see cells.py
    region: IntArray  # (c,) row of regions
    regions: tuple[str, ...]
    laminate: IntArray  # (r,) row of the file's laminates, of each region
    A_GE: Array  # (c, 3, 3) rotation, v_G = A_GE v_E       [-]
    area: Array  # (c,)                                     [m2]


@dataclass(frozen=True)
class ShellPly:
    """One ply of a laminate."""

    material: str
    angle_deg: float  # of the fibre from e1 towards e2
    bottom: float  # z of its lower face                    [m]
    top: float  # z of its upper face                       [m]


@dataclass(frozen=True)
class ShellLaminate:
    """A laminate of the shell; `k` counts its plies."""

    name: str
    plies: tuple[ShellPly, ...]  # bottom to top
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
class ShellPlaces:
    """Named points: of supports (reference points of reaction moments) or of links."""

    names: tuple[str, ...]
    points_G: Array  # (p, 3)                               [m]
    kinds: tuple[str, ...] = ()  # of links: "rigid" or "average"


@dataclass(frozen=True)
class ShellCases:
    """Results of `l` load cases."""

    names: tuple[str, ...]
    displacements_G: Array  # (l, n, 6)                     [m, rad]
    resultants_E: Array  # (l, c, 8) mean of each cell      [N/m, N]
    link_motions_G: Array  # (l, e, 6) of reference points  [m, rad]
    loads_G: Array  # (l, 6) resultant, about the origin    [N, N m]
    reactions_G: Array  # (l, s, 6) of each support, about its point [N, N m]
    energy: Array  # (l,) strain energy                     [J]
    residual: Array  # (l,) of equilibrium, relative        [-]


@dataclass(frozen=True)
class ShellProbes:
    """Values requested by the description."""

    names: tuple[str, ...]
    quantities: tuple[str, ...]  # of SHELL_MOTIONS or SHELL_RESULTANTS
    values: Array  # (l, o) by load case                    [SI]


@dataclass(frozen=True)
class ShellModes:
    """Natural modes, unit modal mass."""

    frequencies: Array  # (m,)                              [rad/s]
    shapes_G: Array  # (m, n, 6)                            [m, rad]
    resultants_E: Array  # (m, c, 8)                        [N/m, N]
    n_zero: int  # the first ones have no strain energy
    error: Array | None = None  # (m,) relative, by the mesh, above 0: too high; None: not estimated

    @property
    def frequencies_hz(self) -> Array:
        """Natural frequencies [Hz]."""
        return np.asarray(self.frequencies / (2.0 * np.pi))


@dataclass(frozen=True)
class ShellBuckling:
    """Load factors of linear buckling, `b` of all load cases."""

    case: IntArray  # (b,) row of the load cases
    factors: Array  # (b,) above 0, ascending in each case  [-]
    shapes_G: Array  # (b, n, 6), largest displacement 1     [m, rad]
    reversed: Array  # (l,) smallest factor below 0 of each case; 0: none, or not asked for [-]
    error: Array | None = None  # (b,) relative, by the mesh, above 0: too high; None: not estimated


@dataclass(frozen=True)
class ShellFile:
    """The content of a shell results file."""

    name: str
    mesh: ShellMeshData
    laminates: tuple[ShellLaminate, ...]
    materials: dict[str, dict[str, Any]]  # constants and strengths as described, by name
    supports: ShellPlaces
    links: ShellPlaces
    cases: ShellCases
    probes: ShellProbes
    modes: ShellModes | None = None
    buckling: ShellBuckling | None = None
    warnings: tuple[dict[str, str], ...] = ()  # {"code", "message"}
    provenance: dict[str, Any] = field(default_factory=dict)  # spec, dofs, seconds, versions, ...
