"""The manual of section descriptions, generated from the models and the library of shapes.

python -m plymotion.solver.inputs.section.reference > docs/section-description.md
"""

from typing import Any

from ..common.material import MATERIAL_TABLES
from ..common.page import EXAMPLE_MATERIAL, chapters, keys
from .description import Direction, Laminate, Ply, Region, SectionDescription
from .mesh_table import SHAPE_MESHES, FileMesh, MeshTable
from .shapes.library import SHAPES, walls

HEAD = (
    """\
# The section description

A beam cross-section is one TOML file. It is checked before the analysis. Unknown keys, names that
do not exist, values out of bounds and plies that do not fill their wall are errors. A message names
file, key, value and expectation. Examples are in `cases/sections/`. `make docs` generates this page
from solver/inputs/section/.

    plymotion section cases/sections/box-layup-2.toml

A case uses a description with `[sections.NAME]` and `file = "../sections/box-layup-2.toml"`, see
[case-reference.md](case-reference.md). Units are SI; only keys that end in `_deg` are in degrees.

```toml
format = 1
title = "Box of six plies"
convention = "contour"

[mesh]
shape = "box"
width = 0.0242
height = 0.0136

"""
    + EXAMPLE_MATERIAL
    + """\

[laminates.wall]               # [0/30]3, 0 deg outermost
material = "cfrp"
angles_deg = [0, 30]
ply_thickness = 0.127e-3
repeat = 3

[regions.all]                  # the four walls; their thickness follows from the plies
laminate = "wall"
```

## Axes, directions, angles

x1 points along the beam, towards the reader. x2 and x3 are x and y of the mesh. The origin of the
mesh is the reference point of stiffness and mass. Every wall has a layer direction y2, a unit
vector in the section. Its outward normal is y3 = x1 x y2 (y2 rotated by +90 deg). Around a closed
section y2 runs clockwise.

              y3 = (0, 1)                        x3
                  |    y2 = (1, 0)               |
           +------+---->--------+                |
           |         top        |                +----- x2
           |                    |               x1 towards the reader
        ^  |                    |  |
     y2 |  | left         right |  | y2 = (0, -1)       fibre = cos(angle) x1 + sin(angle) y2
        |  |                    |  v                    plies: the outermost first,
           |                    |                       from the side of y3 inwards
           |       bottom       |
           +--------<-----------+
              y2 = (-1, 0)

The fibre of a ply lies at `angle_deg` from x1 towards y2, right-handed about y3. The direction of
y2 differs between walls, so that the same printed lay-up can mean two different beams. `convention`
selects one; it has no default:

- `"contour"`: y2 as above. One angle on all walls winds around the beam (extension-twist coupling).
- `"cartesian"`: angles are positive towards +x2, or towards +x3 on walls with y2 normal to x2.
  Where this component of y2 is negative, y2 is reversed. One angle on top and bottom then points to
  the same side (on the bottom and the right wall of the box, the sign changes). Plies are still
  listed outermost first.

`convention` may be omitted only if every angle is 0.
"""
)

OWN = """\
## Your own mesh

Draw the section in the x-y plane, in m (or in another unit with `scale`). Every surface belongs to
exactly one physical surface, which gives the region its name. A wall with a laminate needs its
layer direction: `vector` for a straight wall, `circle` for a round wall, and `curve` for any other
wall. For `curve`, define the OUTER edge as a physical curve; the depth of a ply is the distance
from it. Mesh lines should follow the plies, with one element or more per ply. Otherwise the
stiffness is integrated across ply interfaces, with a warning. Use degree-2 elements for curved
walls (`Mesh.ElementOrder = 2`). The warping within an element has degree 2 for every mesh.

```
// half-round.geo: a half tube on a plate, gmsh script
DefineConstant[ radius = {0.02, Name "Parameters/radius"} ];
wall = 0.002;
Mesh.ElementOrder = 2;
Mesh.MeshSizeMax = 0.001;
Point(1) = {0, 0, 0};
Point(2) = {radius, 0, 0};
Point(3) = {0, radius, 0};
Point(4) = {-radius, 0, 0};
Point(5) = {radius - wall, 0, 0};
Point(6) = {0, radius - wall, 0};
Point(7) = {wall - radius, 0, 0};
Point(8) = {radius, -wall, 0};
Point(9) = {-radius, -wall, 0};
Circle(1) = {2, 1, 3};  Circle(2) = {3, 1, 4};      // outer face
Circle(3) = {5, 1, 6};  Circle(4) = {6, 1, 7};      // inner face
Line(5) = {2, 5};  Line(6) = {7, 4};  Line(7) = {5, 7};
Line(8) = {2, 8};  Line(9) = {8, 9};  Line(10) = {9, 4};
Curve Loop(1) = {1, 2, -6, -4, -3, -5};   Plane Surface(1) = {1};
Curve Loop(2) = {5, 7, 6, -10, -9, -8};   Plane Surface(2) = {2};
Transfinite Curve {1:4} = 21;  Transfinite Curve {5, 6} = 5;   // four rows: one for each ply
Transfinite Surface {1} = {2, 4, 7, 5};
Physical Curve("outer") = {1, 2};
Physical Surface("arch") = {1};
Physical Surface("plate") = {2};
```

```toml
[mesh]
file = "half-round.geo"            # or the .msh that gmsh wrote from it
parameters = { radius = 0.025 }    # .geo only

[regions.arch]
laminate = "shell"
direction = { curve = "outer" }    # circle = [0, 0] is equivalent here

[regions.plate]
material = "aluminium"             # a laminate would need vector = [-1, 0]: normal down
```

meshio reads other meshes. Regions are element sets in Abaqus and CalculiX `.inp`, and groups in
MED. In Nastran `.bdf`, VTK `.vtu`, XDMF and others they are values of integer cell data, named
`NAME-VALUE`, such as `MaterialIds-2`. Sets without a table are ignored, for example a set of all
elements. Every element must be in exactly one described region, or in `regions.all`. Cells are
triangles or quadrilaterals of one kind, of degree 1 or 2. A mesh without sets is one region,
`section`.
"""


def section_page() -> str:
    """Return docs/section-description.md."""
    return "\n".join(
        [
            HEAD,
            *chapters((SectionDescription, Laminate, Ply, Region, Direction, *MATERIAL_TABLES)),
            "## `[mesh]`",
            "",
            "Either `shape` with the sizes below, or `file`. Keys for both:",
            "",
            *keys(MeshTable),
            "",
            *_shapes(),
            *_own(chapters((FileMesh,))),
            OWN,
        ]
    )


def _own(lines: list[str]) -> list[str]:
    return [line for line in lines if not line.startswith("| `degree`")]


def _shapes() -> list[str]:
    """Return a section of the page for each shape: its sizes and its walls."""
    out = []
    for name, model in SHAPE_MESHES.items():
        head, _, meaning = str(model.__doc__).partition("\n\n")
        out += [f"### `{head}`", "", meaning, ""]
        out += [line for line in keys(model) if not line.startswith(("| `degree`", "| `shape`"))]
        out += ["", "| region | y2 | thickness |", "|---|---|---|"]
        for wall in walls(name, SHAPES[name].example):
            thickness = f"`{wall.thickness}`" if wall.stacked else "its own; no rows for plies"
            out.append(f"| `{wall.region}` | {_direction(wall.direction)} | {thickness} |")
        out.append("")
    return out


def _direction(direction: Any) -> str:
    ((kind, value),) = direction.items()
    if kind == "vector":
        return f"({value[0]:g}, {value[1]:g})"
    return "around the centre" if kind == "circle" else f"along the {value} contour"


if __name__ == "__main__":
    print(section_page(), end="")
