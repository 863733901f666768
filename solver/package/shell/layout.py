"""Layout of a shell results file: one table for writer, reader and manual.

Sizes: `n` nodes, `c` cells, `i` connectivity entries, `r` regions, `b` laminates, `k` plies of
all laminates, `l` load cases, `s` supports, `e` links, `o` probes, `m` modes, `b2` load factors,
`w` warnings.
"""

from typing import Any

import numpy as np

from ..common.dataset import DatasetSpec, F, I, T, declared_sizes, spec
from ..common.identity import FileFormat, json_text
from ..common.reported import WARNINGS_LAYOUT, WARNINGS_SIZED_BY, warning_values
from .cells import vtk_cells
from .schema import SHELL_FORMAT, SHELL_FORMAT_VERSION, ShellFile

SHELL_GROUP = "shell"
SHELL_FILE = FileFormat(SHELL_FORMAT, SHELL_FORMAT_VERSION, SHELL_GROUP, "name")
SHELL_VIEW = f"{SHELL_GROUP}/mesh", "nodes_G"  # what ParaView shows: group and nodes

SHELL_LAYOUT: tuple[DatasetSpec, ...] = (
    spec("mesh/nodes_G", "n, 3", F, "m", "G", "rest positions of the nodes"),
    spec("mesh/node_ids", "n", I, "-", "-", "numbers of the nodes in the mesh file, unique"),
    spec("mesh/connectivity", "i", I, "-", "-", "nodes of all cells, as 0-based rows of nodes_G"),
    spec("mesh/offsets", "c+1", I, "-", "-", "cell j owns connectivity[offsets[j]:offsets[j+1]]"),
    spec("mesh/cell_types", "c", "uint8", "-", "-", "VTK cell types, triangles and quadrilaterals"),
    spec("mesh/region", "c", I, "-", "-", "region of each cell, as row of regions"),
    spec("mesh/regions", "r", T, "-", "-", "names of the regions, unique"),
    spec("mesh/laminate", "r", I, "-", "-", "laminate of each region, as row of laminates"),
    spec("mesh/A_GE", "c, 3, 3", F, "-", "E to G", "rotation, axes of cell and laminate to G"),
    spec("mesh/area", "c", F, "m2", "-", "area of each cell"),
    spec("laminates/names", "b", T, "-", "-", "names of the laminates, unique"),
    spec("laminates/ABD", "b, 6, 6", F, "N/m, N, N m", "E", "(N, M) per unit strain, curvature"),
    spec("laminates/Ds", "b, 2, 2", F, "N/m", "E", "transverse shear stiffness, corrected"),
    spec("laminates/mass", "b, 3", F, "kg/m2, kg/m, kg", "-", "density times 1, z, z^2 over z"),
    spec("laminates/reports", "b", T, "-", "-", "symmetry, balance, constants, as JSON text"),
    spec("plies/laminate", "k", I, "-", "-", "laminate of each ply, as row; bottom to top"),
    spec("plies/material", "k", T, "-", "-", "name of the ply's material"),
    spec("plies/angle_deg", "k", F, "deg", "E", "fibre angle from e1 towards e2"),
    spec("plies/bottom", "k", F, "m", "E", "height z of the lower face"),
    spec("plies/top", "k", F, "m", "E", "height z of the upper face"),
    spec(
        "plies/stress_M",
        "k, 3, 6, 8",
        F,
        "1/m, 1/m2",
        "ply",
        "stress 11 22 33 23 13 12 at bottom, middle, top per unit resultant",
    ),
    spec("materials", "", T, "-", "-", "constants and strengths by name, as JSON text"),
    spec("supports/names", "s", T, "-", "-", "names of the supports"),
    spec("supports/points_G", "s, 3", F, "m", "G", "reference points of the reaction moments"),
    spec("links/names", "e", T, "-", "-", "names of the links"),
    spec("links/points_G", "e, 3", F, "m", "G", "reference points"),
    spec("links/kinds", "e", T, "-", "-", "rigid or average"),
    spec("cases/names", "l", T, "-", "-", "names of the load cases"),
    spec("cases/displacements_G", "l, n, 6", F, "m, rad", "G", "ux uy uz rx ry rz of the nodes"),
    spec("cases/resultants_E", "l, c, 8", F, "N/m, N", "E", "N 3, M 3, T 2, mean of each cell"),
    spec("cases/link_motions_G", "l, e, 6", F, "m, rad", "G", "motion of the reference points"),
    spec("cases/loads_G", "l, 6", F, "N, N m", "G", "resultant of the load, about the origin"),
    spec("cases/reactions_G", "l, s, 6", F, "N, N m", "G", "of each support, about its point"),
    spec("cases/energy", "l", F, "J", "-", "strain energy"),
    spec("cases/residual", "l", F, "-", "-", "residual of equilibrium, relative"),
    spec("probes/names", "o", T, "-", "-", "names of the probes"),
    spec("probes/quantities", "o", T, "-", "-", "what each probe reads"),
    spec("probes/values", "l, o", F, "SI", "G or E", "what it read in each load case"),
    spec("modes/frequencies", "m", F, "rad/s", "-", "natural frequencies", optional=True),
    spec("modes/shapes_G", "m, n, 6", F, "m, rad", "G", "unit modal mass", optional=True),
    spec("modes/resultants_E", "m, c, 8", F, "N/m, N", "E", "as of cases", optional=True),
    spec("modes/n_zero", "", I, "-", "-", "modes without strain energy, the first", optional=True),
    spec(
        "modes/error", "m", F, "-", "-", "relative, by the mesh; too high: above 0", optional=True
    ),
    spec("buckling/case", "b2", I, "-", "-", "load case of each factor, as row", optional=True),
    spec("buckling/factors", "b2", F, "-", "-", "load factors of buckling", optional=True),
    spec("buckling/shapes_G", "b2, n, 6", F, "m, rad", "G", "largest motion 1 m", optional=True),
    spec("buckling/reversed", "l", F, "-", "-", "factor of the reversed load", optional=True),
    spec("buckling/error", "b2", F, "-", "-", "as of modes", optional=True),
    *WARNINGS_LAYOUT,
)

# The dataset whose first axis defines each size.
SHELL_SIZED_BY = {
    "n": "mesh/nodes_G",
    "i": "mesh/connectivity",
    "c": "mesh/cell_types",
    "r": "mesh/regions",
    "b": "laminates/names",
    "k": "plies/laminate",
    "s": "supports/names",
    "e": "links/names",
    "l": "cases/names",
    "o": "probes/names",
    "m": "modes/frequencies",
    "b2": "buckling/factors",
    **WARNINGS_SIZED_BY,
}
BUCKLING = ("case", "factors", "shapes_G", "reversed")
CASES = ("names", "displacements_G", "resultants_E", "link_motions_G", "loads_G", "reactions_G")


def shell_values(shell: ShellFile, where: str = "shell") -> dict[str, Any]:
    """Return the value of every dataset of SHELL_LAYOUT by path, those of modes if there.

    `where` names the file for PackageError, raised for materials that JSON cannot hold.
    """
    mesh, laminates = shell.mesh, shell.laminates
    plies = [(row, ply) for row, laminate in enumerate(laminates) for ply in laminate.plies]
    connectivity, offsets, types = vtk_cells(mesh.cells)
    values: dict[str, Any] = {
        "mesh/connectivity": connectivity,
        "mesh/offsets": offsets,
        "mesh/cell_types": types.astype(np.uint8),
        "laminates/names": [laminate.name for laminate in laminates],
        "laminates/reports": [
            json_text(f"{where}: laminates/reports", laminate.report) for laminate in laminates
        ],
        "plies/laminate": np.array([row for row, _ in plies], dtype=np.int64),
        "plies/material": [ply.material for _, ply in plies],
        "plies/stress_M": np.concatenate([laminate.stress_M for laminate in laminates]),
        "materials": json_text(f"{where}: materials", shell.materials),
        "supports/names": shell.supports.names,
        "supports/points_G": shell.supports.points_G,
        "links/names": shell.links.names,
        "links/points_G": shell.links.points_G,
        "links/kinds": shell.links.kinds,
        **warning_values(shell.warnings),
    }
    for name in ("nodes_G", "node_ids", "region", "regions", "laminate", "A_GE", "area"):
        values[f"mesh/{name}"] = getattr(mesh, name)
    for name in ("ABD", "Ds", "mass"):
        values[f"laminates/{name}"] = np.array([getattr(one, name) for one in laminates])
    for name in ("angle_deg", "bottom", "top"):
        values[f"plies/{name}"] = np.array([getattr(ply, name) for _, ply in plies], dtype=float)
    for name in (*CASES, "energy", "residual"):
        values[f"cases/{name}"] = getattr(shell.cases, name)
    for name in ("names", "quantities", "values"):
        values[f"probes/{name}"] = getattr(shell.probes, name)
    if shell.modes is not None:
        for name in ("frequencies", "shapes_G", "resultants_E", "n_zero"):
            values[f"modes/{name}"] = getattr(shell.modes, name)
    if shell.buckling is not None:
        for name in BUCKLING:
            values[f"buckling/{name}"] = getattr(shell.buckling, name)
    for of, found in (("modes", shell.modes), ("buckling", shell.buckling)):
        if found is not None and found.error is not None:
            values[f"{of}/error"] = found.error
    return values


def shell_sizes(values: dict[str, Any]) -> dict[str, int]:
    """Return the sizes that the arrays of a shell declare."""
    return declared_sizes(values, SHELL_SIZED_BY)
