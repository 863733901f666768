"""The manual of shell descriptions, generated from the models.

python -m plymotion.solver.inputs.shell.reference > docs/shell-description.md
"""

from ..common.material import MATERIAL_TABLES
from ..common.page import EXAMPLE_MATERIAL, chapters
from .description import (
    AxisAbout,
    Elements,
    Laminate,
    Mesh,
    Ply,
    Region,
    ShellDescription,
    Stiffener,
)
from .loading import Buckling, Frequencies, Link, Load, Probe, Support

HEAD = (
    """\
# The shell description

A laminated plate or shell is one TOML file. It is checked before the analysis. Unknown keys, names
that do not exist and values out of bounds are errors. A message names file, key, value and
expectation. Examples are in `cases/shells/`. `make docs` generates this page from
solver/inputs/shell/. [shells.md](shells.md) explains axes, signs and results.

    plymotion shell cases/shells/plate.toml

Units are SI; only keys that end in `_deg` are in degrees.

```toml
format = 1
title = "A plate of eight plies, clamped on one side"

[mesh]
file = "plate.geo"             # physical groups: surface "plate", curves "root" and "tip"
parameters = { n = 16 }

"""
    + EXAMPLE_MATERIAL
    + """\

[laminates.skin]               # [0/45/-45/90]s, bottom ply first
material = "cfrp"
angles_deg = [0, 45, -45, 90]
ply_thickness = 0.125e-3
symmetric = true

[regions.plate]
laminate = "skin"
axis = [1, 0, 0]               # 0 deg lies along x

[supports.root]
at = "root"
fixed = "all"

[loads.bending.tip]
at = "tip"
force = [0, 0, 10.0]

[loads.weight.all]
gravity = [0, 0, -9.81]

[probes.tip]
at = "tip"
what = ["uz", "ry"]

[frequencies]
count = 4
```

## Meshes

Meshes consist of three-node triangles and four-node quadrilaterals in space, also mixed, from
gmsh: a `.msh` of any version, a `.geo` script, or a Python file. A Python file has a function
`build(gmsh, parameters)`, which fills the current model. If it does not generate the mesh,
Plymotion does. Quadrilaterals come from gmsh (`Recombine Surface`), or from pairs of the mesh's
triangles with `element = "quadrilateral"`. meshio reads meshes of other programs (.inp, .med,
.vtu, ...): their sets of cells are regions, sets of lines curves, sets of nodes points. Every
surface belongs to exactly one physical surface, which gives the region its name. Supports, loads
and probes refer to physical points, curves and surfaces. Surfaces that meet must have common
nodes there (`BooleanFragments`, or common points and curves). Any number of surfaces may meet at
a node, for example at a stiffener.
"""
)


def shell_page() -> str:
    """Return docs/shell-description.md."""
    shell = (ShellDescription, Mesh, Laminate, Ply, Region, AxisAbout, Elements, Stiffener)
    loading = (Link, Support, Load, Probe, Frequencies, Buckling)
    page = "\n".join([HEAD, *chapters((*shell, *loading, *MATERIAL_TABLES))])
    return page.rstrip("\n") + "\n"


if __name__ == "__main__":
    print(shell_page(), end="")
