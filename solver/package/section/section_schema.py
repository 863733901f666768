"""A beam cross-section in memory and in its file: stiffness, mass and stress recovery data.

Lengths in m, forces in N. Axes x1 along the beam, (x2, x3) in the section, origin at
the reference point. Order of strains and resultants: extension, shear 2, shear 3,
twist, bending 2, bending 3. Stress and strain at a point are columns in the order
11, 22, 33, 23, 13, 12 with engineering shear strains. `_M` are the axes of a ply (1
along the fibre, 3 along its outward normal).

Sizes: `n` nodes, `c` cells, `i` connectivity entries, `r` regions, `k` plies, `p`
integration points, `w` warnings. The mapper of common/dataset.py writes and reads the fields.
"""

from dataclasses import dataclass, field
from typing import Annotated, Any

from ...math.arrays import Array, IntArray
from ..common.dataset import Data, Nested, Reported
from ..common.design import Derivative
from ..common.recovery_schema import SectionRecovery

SECTION_FORMAT = "plymotion section"
SECTION_FORMAT_VERSION = (1, 2)


@dataclass(frozen=True)
class SectionMeshData:
    """The mesh of a section, in VTK's numbering of cells and nodes.

    Ply and direction of a cell are those of its middle.
    """

    nodes: Annotated[Array, Data("n, 2", "m", "section", "x2 and x3 of the nodes")]
    connectivity: Annotated[
        IntArray, Data("i", "-", "-", "nodes of all cells, as 0-based rows of nodes")
    ]
    offsets: Annotated[
        IntArray, Data("c+1", "-", "-", "cell j owns connectivity[offsets[j]:offsets[j+1]]")
    ]
    cell_types: Annotated[IntArray, Data("c", text="VTK cell types", type="uint8")]
    region: Annotated[IntArray, Data("c", text="region of each cell, as row of regions")]
    regions: Annotated[tuple[str, ...], Data("r", text="names of the regions, unique")]
    ply: Annotated[IntArray, Data("c", text="ply in the middle of each cell, as row of plies")]
    layer_direction: Annotated[
        Array, Data("c, 2", "-", "section", "layer direction y2 of each cell, unit")
    ]
    fibre: Annotated[Array, Data("c, 3", "-", "section", "fibre direction of each cell, unit")]


@dataclass(frozen=True, kw_only=True)
class SectionProperties:
    """The numbers of a section."""

    name: str
    K: Annotated[
        Array, Data("6, 6", "N, N m, N m2", "section", "stiffness: resultants per unit strain")
    ]
    M: Annotated[
        Array, Data("6, 6", "kg/m, kg, kg m", "section", "mass per length for v1 v2 v3 w1 w2 w3")
    ]
    error_estimate: Annotated[  # None: not requested
        Array | None, Data("6, 6", "N, N m, N m2", "section", "expected size of the error of K")
    ]
    shear_centre: Annotated[
        Array, Data("2", "m", "section", "where a shear force does not twist the beam")
    ]
    tension_centre: Annotated[
        Array, Data("2", "m", "section", "where an axial force does not bend the beam")
    ]
    mass_centre: Annotated[Array, Data("2", "m", "section", "mass centre")]
    initial_curvature: Annotated[
        Array | None,
        Data(
            "3",
            "rad/m",
            "section",
            "twist k1 and curvature k2, k3 of the reference line without load, absent: prismatic",
        ),
    ] = None
    end_compliance: Annotated[
        Array | None,
        Data(
            "6, 6",
            "m/N, 1/N, 1/(N m)",
            "section",
            "what the beam lacks of compliance at an end whose section is held, by resultants; "
            "absent: not computed",
        ),
    ] = None
    warnings: Annotated[tuple[dict[str, str], ...], Nested("warnings", via=Reported)] = ()
    provenance: dict[str, Any] = field(default_factory=dict)  # spec, dofs, seconds, versions, ...
    design: tuple[Derivative, ...] = ()  # of all datasets by design parameters


@dataclass(frozen=True, kw_only=True)
class SectionFile(SectionProperties):
    """The content of a section file."""

    mesh: Annotated[SectionMeshData, Nested("mesh")]
    warping: Annotated[  # without rigid motion
        Array, Data("6, n, 3", "m/N, 1/N", "section", "displacement of nodes per unit resultant")
    ]
    recovery: Annotated[SectionRecovery, Nested()]
