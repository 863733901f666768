"""Layout of a section file: one table for writer, reader, validator and manual.

Sizes: `n` nodes, `c` cells, `i` connectivity entries, `r` regions, `k` plies, `p`
integration points, `w` warnings.
"""

from typing import Any

from ..common.dataset import DatasetSpec, F, I, T, declared_sizes, spec
from ..common.identity import FileFormat
from ..common.reported import WARNINGS_LAYOUT, WARNINGS_SIZED_BY, warning_values
from .recovery_data import RECOVERY_LAYOUT, RECOVERY_SIZED_BY, recovery_values
from .schema import SECTION_FORMAT, SECTION_FORMAT_VERSION, SectionFile

SECTION_GROUP = "section"
SECTION_FILE = FileFormat(SECTION_FORMAT, SECTION_FORMAT_VERSION, SECTION_GROUP, "name")
SECTION_VIEW = f"{SECTION_GROUP}/mesh", "nodes"  # what ParaView shows: group and nodes

SECTION_FILE_LAYOUT: tuple[DatasetSpec, ...] = (
    spec("K", "6, 6", F, "N, N m, N m2", "section", "stiffness: resultants per unit strain"),
    spec("M", "6, 6", F, "kg/m, kg, kg m", "section", "mass per length for v1 v2 v3 w1 w2 w3"),
    spec(
        "error_estimate",
        "6, 6",
        F,
        "N, N m, N m2",
        "section",
        "expected size of the error of K",
        optional=True,
    ),
    spec(
        "initial_curvature",
        "3",
        F,
        "rad/m",
        "section",
        "twist k1 and curvature k2, k3 of the reference line without load, absent: prismatic",
        optional=True,
    ),
    spec(
        "end_compliance",
        "6, 6",
        F,
        "m/N, 1/N, 1/(N m)",
        "section",
        "what the beam lacks of compliance at an end whose section is held, by resultants; "
        "absent: not computed",
        optional=True,
    ),
    spec("shear_centre", "2", F, "m", "section", "where a shear force does not twist the beam"),
    spec("tension_centre", "2", F, "m", "section", "where an axial force does not bend the beam"),
    spec("mass_centre", "2", F, "m", "section", "mass centre"),
    spec("mesh/nodes", "n, 2", F, "m", "section", "x2 and x3 of the nodes"),
    spec("mesh/connectivity", "i", I, "-", "-", "nodes of all cells, as 0-based rows of nodes"),
    spec("mesh/offsets", "c+1", I, "-", "-", "cell j owns connectivity[offsets[j]:offsets[j+1]]"),
    spec("mesh/cell_types", "c", "uint8", "-", "-", "VTK cell types"),
    spec("mesh/region", "c", I, "-", "-", "region of each cell, as row of regions"),
    spec("mesh/regions", "r", T, "-", "-", "names of the regions, unique"),
    spec("mesh/ply", "c", I, "-", "-", "ply in the middle of each cell, as row of plies"),
    spec(
        "mesh/layer_direction", "c, 2", F, "-", "section", "layer direction y2 of each cell, unit"
    ),
    spec("mesh/fibre", "c, 3", F, "-", "section", "fibre direction of each cell, unit"),
    spec(
        "warping", "6, n, 3", F, "m/N, 1/N", "section", "displacement of nodes per unit resultant"
    ),
    *RECOVERY_LAYOUT,
    *WARNINGS_LAYOUT,
)

# The dataset whose first axis defines each size.
SECTION_SIZED_BY = {
    "n": "mesh/nodes",
    "i": "mesh/connectivity",
    "c": "mesh/cell_types",
    "r": "mesh/regions",
    **RECOVERY_SIZED_BY,
    **WARNINGS_SIZED_BY,
}


def section_values(section: SectionFile, where: str = "section") -> dict[str, Any]:
    """Return the value of every dataset of SECTION_FILE_LAYOUT by path, optional ones if there.

    `where` names file or section for PackageError, raised for materials that JSON cannot hold.
    """
    mesh = section.mesh
    values: dict[str, Any] = {
        "K": section.K,
        "M": section.M,
        "shear_centre": section.shear_centre,
        "tension_centre": section.tension_centre,
        "mass_centre": section.mass_centre,
        "warping": section.warping,
        **warning_values(section.warnings),
    }
    for name in ("error_estimate", "initial_curvature", "end_compliance"):
        if getattr(section, name) is not None:
            values[name] = getattr(section, name)
    for name in ("nodes", "connectivity", "offsets", "cell_types", "region", "regions", "ply"):
        values[f"mesh/{name}"] = getattr(mesh, name)
    for name in ("layer_direction", "fibre"):
        values[f"mesh/{name}"] = getattr(mesh, name)
    return values | recovery_values(section.recovery, f"{where}: /{SECTION_GROUP}")


def section_sizes(values: dict[str, Any]) -> dict[str, int]:
    """Return the sizes that the arrays of a section declare."""
    return declared_sizes(values, SECTION_SIZED_BY)
