"""A beam cross-section in memory: stiffness, mass and stress recovery data.

Lengths in m, forces in N. Axes x1 along the beam, (x2, x3) in the section, origin at
the reference point. Order of strains and resultants: extension, shear 2, shear 3,
twist, bending 2, bending 3. Stress and strain at a point are columns in the order
11, 22, 33, 23, 13, 12 with engineering shear strains. `_M` are the axes of a ply (1
along the fibre, 3 along its outward normal).
"""

from dataclasses import dataclass, field
from typing import Any

from ...math.arrays import Array, IntArray

SECTION_FORMAT = "plymotion section"
SECTION_FORMAT_VERSION = (1, 1)

RESULTANTS = ("F1", "F2", "F3", "M1", "M2", "M3")
STRESSES = ("11", "22", "33", "23", "13", "12")
CORNERS = {5: 3, 22: 3, 9: 4, 23: 4, 28: 4}  # of the VTK cell types of a section


@dataclass(frozen=True)
class Ply:
    """One ply of a region, or a region of one material."""

    region: str
    index: int  # from 0, the outermost
    material: str
    angle_deg: float  # of the fibre from x1 towards the layer direction


@dataclass(frozen=True)
class SectionRecovery:
    """Data for strains and stresses of every integration point from the six resultants.

    strain_M[p] @ F6 is the strain of point p in the axes of its ply; C_M[ply[p]] times it is the
    stress. `p` counts points, `k` plies.
    """

    points: Array  # (p, 2) x2, x3                              [m]
    weights: Array  # (p,) area of each point                   [m2]
    cell: IntArray  # (p,) row of the mesh's cells
    ply: IntArray  # (p,) row of plies
    A_BM: Array  # (p, 3, 3) ply axes in section axes           [-]
    strain_M: Array  # (p, 6, 6) strain per unit resultant      [1/N, 1/(N m)]
    C_M: Array  # (k, 6, 6) stiffness of each ply               [Pa]
    plies: tuple[Ply, ...]
    materials: dict[str, dict[str, Any]]  # constants and strengths as described, by name


@dataclass(frozen=True)
class SectionMeshData:
    """The mesh of a section, in VTK's numbering of cells and nodes.

    `n` counts nodes, `c` cells. Ply and direction of a cell are those of its middle.
    """

    nodes: Array  # (n, 2) x2, x3                               [m]
    connectivity: IntArray  # flat rows of nodes
    offsets: IntArray  # (c + 1,)
    cell_types: IntArray  # (c,) VTK cell types
    region: IntArray  # (c,) row of regions
    regions: tuple[str, ...]
    ply: IntArray  # (c,) row of SectionRecovery.plies
    layer_direction: Array  # (c, 2) y2 in x2, x3, reference of ply angles      [-]
    fibre: Array  # (c, 3) fibre direction in x1, x2, x3        [-]


@dataclass(frozen=True)
class SectionFile:
    """The content of a section file."""

    name: str
    K: Array  # (6, 6) stiffness                                [N, N m, N m2]
    M: Array  # (6, 6) mass per length for [v1 v2 v3 w1 w2 w3]  [kg/m, kg, kg m]
    error_estimate: Array | None  # (6, 6) expected |error| of K, in its units; None: not requested
    shear_centre: Array  # (2,) x2, x3                          [m]
    tension_centre: Array  # (2,)                               [m]
    mass_centre: Array  # (2,)                                  [m]
    mesh: SectionMeshData
    warping: Array  # (6, n, 3) displacement of the nodes per unit resultant, no rigid motion
    recovery: SectionRecovery
    initial_curvature: Array | None = None  # (3,) k1, k2, k3; None: prismatic  [rad/m]
    end_compliance: Array | None = None  # (6, 6) lacking at a held end [m/N, 1/N, 1/(N m)]
    warnings: tuple[dict[str, str], ...] = ()  # {"code", "message"}
    provenance: dict[str, Any] = field(default_factory=dict)  # spec, dofs, seconds, versions, ...
