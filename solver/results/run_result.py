"""The result of a run in memory: k output times, all arrays in SI units; bodies for pictures.

A point of a surface belongs to a node and has an offset from it. With the modal coordinates q it is
at

    r + A (x + o + U q + (Theta q) x o)                     global,

where x is the rest position of the node, o the offset, U and Theta the translation and rotation of
the node per unit mode, r and A position and rotation of the body. Pictures are therefore made from
modal coordinates alone; no field is stored for each time.
"""

from collections.abc import Callable
from dataclasses import field
from functools import cached_property, partial
from typing import Annotated, Any

import numpy as np

from ..errors import InputError
from ..math.arrays import Array, IntArray
from ..math.records import record
from ..package.common.dataset import Data, Nested


@record
class Surface:
    """Triangles of a body; `p` counts points, `f` triangles."""

    node: Annotated[IntArray, Data("p")]  # row of the body's nodes
    offset_B: Annotated[Array, Data("p, 3", "m", "B")]  # from the node
    triangles: Annotated[IntArray, Data("f, 3")]  # rows of points
    edges: Annotated[IntArray, Data("f")]  # sum of 1, 2, 4: edges 0-1, 1-2, 2-0 are drawn
    site: Annotated[IntArray, Data("f, 3")]  # row of the sites at each corner, -1: none


@record
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


@record
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
    sites: Annotated[Sites | None, Nested("sites")] = None
    provenance: dict[str, Any] = field(default_factory=dict)  # of the package

    @cached_property
    def surface(self) -> Surface:
        """Surface of the body."""
        return self.draw()

    def __getstate__(self) -> dict[str, object]:
        """Return what another process gets: the surface, not how to make it."""
        return vars(self) | {"draw": partial(_made, self.surface)}


def _made(surface: Surface) -> Surface:
    return surface


@record
class Side:
    """One side of a joint or force element: a marker on a body, or on the ground (-1)."""

    body: int
    position_B: Array  # (3,) rest position, of the ground global [m]
    A_BM: Array  # (3, 3) axes of the joint in body axes
    phi_B: Array  # (3, m) translation per unit mode             [m]
    psi_B: Array  # (3, m) rotation per unit mode                [rad]


@record
class Link:
    """A joint of the case, or a force element between two places."""

    name: str
    kind: str
    sides: tuple[Side, Side]
    free: tuple[str, ...] = ()  # free directions: x, y, z, about x, about y, about z


@record
class Loads:
    """Loads for pictures: of joints and their drives, of force elements, on their second side."""

    names: tuple[str, ...]  # (n,)
    t: Annotated[Array, Data("r", "s", text="some of the output times")]
    place_G: Annotated[Array, Data("r, n, 3", "m", "G", "origin of the second place")]
    load_G: Annotated[Array, Data("r, n, 6", "N, N m", "G", "force, and moment about the origin")]


FORMAT = "plymotion result"
FORMAT_VERSION = (1, 5)
TABLES_VERSION = (2, 2)  # of a file with tables: older readers would miss what is in them

ENERGIES = ("kinetic", "strain", "potential", "drive_work")
ROUNDING = 1e3 * float(np.finfo(float).eps)  # of sums of energies, relative


class ResultError(InputError):
    """A result cannot be written or read; the message names file and dataset."""


@record
class Signal:
    """A named quantity over time."""

    name: str
    unit: str
    description: str
    values: Array  # (k,)


def energy_balance(energies: dict[str, Array]) -> Array:
    """Change of kinetic + strain + potential energy minus drive work, (k,) [J]."""
    e = energies
    balance = e["kinetic"] + e["strain"] + e["potential"] - e["drive_work"]
    return np.asarray(balance - balance[0])


def energy_in_play(energies: dict[str, Array]) -> float:
    """Largest of the kinetic energy, the work and the change of potential [J]; 1 if all are 0."""
    e = energies
    scale = max(
        float(np.max(np.abs(e["kinetic"]))),
        float(np.max(np.abs(e["drive_work"]))),
        float(np.ptp(e["potential"])),
    )
    return scale or 1.0


def relative_balance(energies: dict[str, Array]) -> Array:
    """Error of the energy balance over the energy in play, (k,) [-].

    Of the error, what rounding of the terms explains does not count: at rest there is nothing else.
    """
    terms = (float(np.max(np.abs(energies[name]), initial=0.0)) for name in ENERGIES)
    error = energy_balance(energies)
    error = np.where(np.abs(error) > ROUNDING * sum(terms), error, 0.0)
    return np.asarray(error / energy_in_play(energies))


@record
class BodyGeometry:
    """Geometry of a body for drawing, in its own frame."""

    name: str
    nodes_B: Annotated[Array, Data("n, 3", "m", "B", "rest positions of the drawn points")]
    connectivity: Annotated[IntArray, Data("i", text="rows of nodes_B, cell by cell")]
    offsets: Annotated[IntArray, Data("c+1", text="start of each cell in connectivity")]
    cell_types: Annotated[IntArray, Data("c", text="VTK cell types")]
    view: BodyView | None = None  # what is needed to show it in motion


@record
class Derivative:
    """The derivative of a signal by a parameter of the case, at the output times."""

    signal: str
    parameter: str
    unit: str
    value: float  # of the parameter
    values: Array  # (k,)


@record
class RunResult:
    """All results of a run, at its k output times."""

    case: str
    run: str
    t: Array  # (k,)                                        [s]
    signals: tuple[Signal, ...]
    q: Array  # (k, n_pos) positions, Euler parameters, modal coordinates
    v: Array  # (k, n_vel) velocities
    multipliers: Array  # (k, n_c) reactions of the joints
    energies: dict[str, Array]  # ENERGIES, (k,) each       [J]
    bodies: tuple[BodyGeometry, ...]
    node_positions_G: Array  # (k, n, 3), bodies end to end [m]
    # largest constraint violation, (k,) each: position [m], rotation [rad], velocity [m/s]
    violations: dict[str, Array] = field(default_factory=dict)
    node_deflection: Array | None = None  # (k, n) magnitude of the elastic displacement [m]
    links: tuple[Link, ...] = ()  # joints, for pictures
    loads: Loads | None = None
    sensitivities: tuple[Derivative, ...] = ()
    provenance: dict[str, Any] = field(default_factory=dict)  # versions, command, digest of inputs

    @property
    def energy_balance(self) -> Array:
        """Change of kinetic + strain + potential energy minus drive work, (k,) [J]."""
        return energy_balance(self.energies)

    @property
    def relative_balance(self) -> Array:
        """Error of the energy balance over the largest energy in play, (k,) [-]."""
        return relative_balance(self.energies)


def check_result(result: RunResult) -> None:
    """Raise ResultError with the name of the array if sizes of a result do not agree."""
    k = len(result.t)
    n = sum(len(body.nodes_B) for body in result.bodies)
    shapes: dict[str, tuple[Array, tuple[int, ...]]] = {
        "node_positions_G": (result.node_positions_G, (k, n, 3))
    }
    for name in ("q", "v", "multipliers"):
        array = getattr(result, name)
        shapes[name] = (array, (k, array.shape[1] if array.ndim == 2 else -1))
    if result.node_deflection is not None:
        shapes["node_deflection"] = (result.node_deflection, (k, n))
    for signal in result.signals:
        shapes[f"signals/{signal.name}"] = (signal.values, (k,))
    for one in result.sensitivities:
        shapes[f"sensitivities/{one.signal}/{one.parameter}"] = (one.values, (k,))
    for group in ("energies", "violations"):
        for name, values in getattr(result, group).items():
            shapes[f"{group}/{name}"] = (values, (k,))
    missing = [name for name in ENERGIES if name not in result.energies]
    if missing:
        raise ResultError(f"energies/{missing[0]}: missing; expected {', '.join(ENERGIES)}")
    if not k or np.any(np.diff(result.t) <= 0):
        raise ResultError("t: expected at least one time, in ascending order")
    for name, (array, expected) in shapes.items():
        if np.shape(array) != expected:
            raise ResultError(f"{name}: expected shape {expected}, got {np.shape(array)}")
