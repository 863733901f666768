"""Contract of a section shape: what its file supplies.

A shape is one file of this folder with an object of class `Shape`; library.py finds it. It defines
the keys of `[mesh]` with their bounds and messages, the regions that a description may name,
`[sections.NAME]` of a case and docs/section-description.md. CONTRIBUTING.md has the recipe.

The mesh is drawn by a script of meshes/, `script`.geo for gmsh or `script`.py; several shapes may
use one script. A shape that no script draws needs its own script as a second file:

- lengths in m, x = x2, y = x3, the reference point of stiffness and mass at (0, 0)
- each number or list that `mesh` returns is read under its key, in gmsh as
  DefineConstant[ KEY = {default, Name "Parameters/KEY"} ]
- one physical surface for each wall, with the name of its region, and one physical curve for each
that a direction {"curve": name} names; Mesh.ElementOrder = 2 where walls are curved - lines of the
mesh along the faces of plies, where `stacked`

Layer direction y2 of a wall: y3 = x1 x y2 is its outward normal, and plies are listed outermost
first.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from ....package.specification import LayerDirection, SectionMeshTable

Values = dict[str, Any]  # size -> number, list, text; None: optional and not given
Plies = dict[str, list[float]]  # region -> thickness of each ply, outermost first, in any unit


@dataclass(frozen=True)
class Parameter:
    """A size of a shape: a key of `[mesh]`."""

    key: str
    unit: str  # "m", "deg" or "-"
    meaning: str  # one line
    default: Any = None  # of an optional one; None: from other sizes, see the meaning
    required: bool = False
    above: float | None = None  # bounds: above, or from `least` on; up to `most`
    least: float | None = None
    most: float | None = None
    many: bool = False  # a list of numbers (or one number)
    text: bool = False  # not a number but a file, relative to the description


@dataclass(frozen=True)
class Wall:
    """A region of a shape."""

    region: str
    direction: LayerDirection  # {"vector": y2}, {"circle": centre} or {"curve": name}
    thickness: str  # key of its thickness
    stacked: bool = True  # plies fill this thickness one below the other


@dataclass(frozen=True)
class Shape:
    """A parametric section.

    Attributes
    ----------
    name : value of `shape`
    script : name of the script in meshes/, without suffix
    meaning : one line
    parameters : its sizes
    walls : its regions
    mesh : f(values, plies) -> {"parameters": {key: number or list of numbers}} for the script, with
        "coordinates" for one that takes points; numbers of elements and rows included, for an error
        of about 1e-3 at density 1. `values` has every parameter, within bounds. An InputError
        for sizes that do not fit together begins with the key: "KEY = VALUE: expected ..."
    walls_of : f(values) -> regions, of a shape with regions that depend on its sizes; `walls` is
        empty then
    example : sizes for the regions in the manual, if `walls_of` needs sizes
    order : position in the manual and in lists; shapes of equal order are sorted by name
    """

    name: str
    script: str
    meaning: str
    parameters: tuple[Parameter, ...]
    walls: tuple[Wall, ...]
    mesh: Callable[[Values, Plies], SectionMeshTable]
    walls_of: Callable[[Mapping[str, Any]], tuple[Wall, ...]] | None = None
    example: Mapping[str, Any] = field(default_factory=dict)
    order: int = 100


def size(key: str, meaning: str, **more: Any) -> Parameter:
    """Return a length above 0.

    Parameters
    ----------
    key : name of the key
    meaning : what it means
    more : other properties of the parameter
    """
    return Parameter(key, "m", meaning, above=0.0, **more)


# Cells grow with the square of the density: 20 makes a million, which takes hours.
DENSITY = Parameter(
    "density", "-", "elements along each line over the default", 1.0, above=0.0, most=20.0
)
