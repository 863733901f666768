"""What moves in pictures of a run: surfaces, modes and resultants of bodies, and their joints.

A point of a surface belongs to a node and has an offset from it. With the modal coordinates q it is
at

    r + A (x + o + U q + (Theta q) x o)                     global,

where x is the rest position of the node, o the offset, U and Theta the translation and rotation of
the node per unit mode, r and A position and rotation of the body. Pictures are therefore made from
modal coordinates alone; no field is stored for each time.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property, partial
from typing import Annotated, Any

from ..math.arrays import Array, IntArray
from ..package.common.dataset import Data, Part


@dataclass(frozen=True)
class Surface:
    """Triangles of a body; `p` counts points, `f` triangles."""

    node: Annotated[IntArray, Data("p")]  # row of the body's nodes
    offset_B: Annotated[Array, Data("p, 3", "m", "B")]  # from the node
    triangles: Annotated[IntArray, Data("f, 3")]  # rows of points
    edges: Annotated[IntArray, Data("f")]  # sum of 1, 2, 4: edges 0-1, 1-2, 2-0 are drawn
    site: Annotated[IntArray, Data("f, 3")]  # row of the sites at each corner, -1: none


@dataclass(frozen=True)
class Sites:
    """Stations of a beam (j = 6 resultants), cells of a shell (j = 8), faces of a solid (j = 6).

    There are `s` of them. F = resultants_E[s] @ q are resultants, of a solid the stresses [Pa] in
    the axes of the material. The strain energy for unit length, area or volume is 1/2 F' C F with
    C = compliance[kind[s]]. `c` counts sections or laminates. The stress of a point in the axes of
    its ply is stress_M[i] @ F; there are only points that govern at a site and time of this run.
    """

    place_B: Annotated[Array, Data("s, 3", "m", "B")]  # rest position
    resultants_E: Annotated[  # per unit mode
        Array, Data("s, j, m", "N, N m; N/m, N", "section or cell")
    ]
    kind: Annotated[IntArray, Data("s")]  # row of compliance
    compliance: Annotated[Array, Data("c, j, j", "1/N, 1/(N m); m/N, 1/N", "section or cell")]
    stress_M: Annotated[Array, Data("i, 6, j", "Pa per unit", "ply")]  # per unit resultant
    point_kind: Annotated[IntArray, Data("i")]  # row of compliance to which the point belongs
    point_ply: Annotated[IntArray, Data("i")]  # row of plies
    plies: tuple[dict[str, Any], ...] = ()  # region, index, material, angle_deg, strength
    dimension: int = 1  # 1, 2, 3: strain energy for unit length, area or volume


@dataclass(frozen=True)
class BodyView:
    """How a body moves and what is known of it; `m` modes, `n` nodes as in BodyGeometry."""

    first_position: int  # column of RunResult.q: r (3), Euler parameters (4), then q (m)
    shapes_B: Annotated[Array, Data("m, n, 6", "m, rad", "B")]  # translation, rotation
    stiffness: Annotated[Array, Data("m, m", "N m")]  # modal stiffness
    frequencies: Annotated[Array, Data("m", "rad/s")]
    labels: tuple[str, ...]  # (m,) names of the modes
    mass: float  # [kg]
    centre_B: Annotated[Array, Data("3", "m", "B")]  # mass centre
    draw: Callable[[], Surface]  # makes the surface: a run that shows none has no cost of it
    sites: Annotated[Sites | None, Part("sites")] = None
    provenance: dict[str, Any] = field(default_factory=dict)  # of the package

    @cached_property
    def surface(self) -> Surface:
        """Surface of the body."""
        return self.draw()

    def __getstate__(self) -> dict[str, Any]:
        """Return what another process gets: the surface, not how to make it."""
        return vars(self) | {"draw": partial(_made, self.surface)}


def _made(surface: Surface) -> Surface:
    return surface


@dataclass(frozen=True)
class Side:
    """One side of a joint or force element: a marker on a body, or on the ground (-1)."""

    body: int
    position_B: Array  # (3,) rest position, of the ground global [m]
    A_BM: Array  # (3, 3) axes of the joint in body axes
    phi_B: Array  # (3, m) translation per unit mode             [m]
    psi_B: Array  # (3, m) rotation per unit mode                [rad]


@dataclass(frozen=True)
class Link:
    """A joint of the case, or a force element between two places."""

    name: str
    kind: str
    sides: tuple[Side, Side]
    free: tuple[str, ...] = ()  # of x, y, z, about x, about y, about z: what the joint leaves
