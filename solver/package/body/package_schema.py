"""The modal package in memory and in its file: the data of one flexible body for the solver.

All arrays are in SI units and in the body frame (`_B`), those with `_E` in section axes or in the
axes of a cell and of its laminate: e3 the normal, e1 the reference direction of the plies projected
on the cell. Resultants of a cell, for unit width: N11 N22 N12 [N/m], M11 M22 M12 [N], T1 T2 [N/m].

Shapes are symbols: `n` nodes, `c` cells, `i` connectivity entries, `m` modes, `s` stations of the
resultants; `k` nodes of an interface; in a section `k` plies and `p` points of its recovery; in a
laminate `k` plies; `e` cells of a shell with resultants; `l` unit loads; `f` faces of a solid,
`g` load cases. Modal coordinates are dimensionless, so that a mode shape is in metres and radians,
and modal mass, damping and stiffness are in kg m2, N m s and N m. The mapper of common/dataset.py
writes, reads, checks and documents the fields.
"""

from dataclasses import field
from typing import Annotated, Any, get_args

from ...math.arrays import Array, IntArray
from ...math.records import record
from ..common.dataset import Attribute, Data, Named, Nested, Rows
from ..common.design import Derivative
from ..common.recovery_schema import SectionRecovery, ShellPly
from ..specification import FORMAT_VERSION as FORMAT_VERSION
from ..specification import MassForm, ReferenceKind

FORMAT = "plymotion modal package"

MODE_KINDS = ("rigid", "fixed_normal", "constraint", "attachment", "residual", "experimental")
REFERENCE_CONDITIONS = get_args(ReferenceKind)
MASS_FORMS = get_args(MassForm)

M6 = "N, N m, N m2"  # units of a 6x6 stiffness


@record
class Invariants:
    """Sums over mass stations k that give the inertia of a moving flexible body.

    A station has mass m_k, rest position x_k, translation shapes phi_k (3, m),
    rotation shapes psi_k (3, m) and rotary inertia J_k (3, 3) about its own
    mass centre. Modal coordinates are numbers, so phi is in m and psi in rad.
    Stations are nodes (lumped) or integration points of the
    consistent mass; the sums have the same form. Indices a, b are body axes.
    """

    mass: Annotated[float, Data("", "kg", "-", "sum m")]
    S0_B: Annotated[Array, Data("3", "kg m", "B", "sum m x_a")]
    S_B: Annotated[Array, Data("3, m", "kg m", "B", "sum m phi_ai")]
    T00_B: Annotated[Array, Data("3, 3", "kg m2", "B", "sum m x_a x_b")]
    T01_B: Annotated[Array, Data("3, 3, m", "kg m2", "B", "sum m x_a phi_bi")]
    T11_B: Annotated[Array, Data("3, 3, m, m", "kg m2", "B", "sum m phi_ai phi_bj")]
    J0_B: Annotated[Array, Data("3, 3", "kg m2", "B", "sum J")]
    J_psi_B: Annotated[Array, Data("3, m", "kg m2", "B", "sum J_ab psi_bi")]
    mass_form: Annotated[str, Attribute("consistent")]  # one of MASS_FORMS


@record
class Pieces:
    """Pieces of a body, for the products of phi q and q' h q in moments about the frame."""

    mass: Annotated[Array, Data("p", "kg", "-", "mass of a piece of the body")]
    phi_B: Annotated[
        Array, Data("p, 3, m", "m", "B", "mean translation of the piece per unit mode")
    ]
    h_B: Annotated[
        Array, Data("p, 3, m, m", "m", "B", "mean second-order translation of the piece")
    ]


@record
class SecondOrder:
    """Sums over the mass stations of `Invariants` with their second-order translation h_k.

    A station moves to x + phi q + 1/2 q' h q, h (3, m, m) symmetric in the modes.
    """

    Z0_B: Annotated[Array, Data("3, m, m", "kg m", "B", "sum m h_a,ij")]
    Z1_B: Annotated[Array, Data("3, 3, m, m", "kg m2", "B", "sum m x_a h_b,ij")]
    G3: Annotated[Array, Data("m, m, m", "kg m2", "-", "sum m phi_i . h_jk")]
    G4: Annotated[Array, Data("m, m, m, m", "kg m2", "-", "sum m h_ij . h_kl")]
    pieces: Annotated[Pieces | None, Nested("pieces", packed=True)] = None


@record
class Interface:
    """A named point where joints, loads and masses attach.

    With second-order data it moves by phi q + 1/2 q' H q and turns by a vector of the same form.
    """

    name: str
    kind: Annotated[str, Attribute("node")]  # "node" (one node) or "average" (weighted nodes)
    node_ids: Annotated[
        IntArray, Data("k", text="identifiers of the nodes that carry the interface")
    ]
    weights: Annotated[Array, Data("k", text="share of each node, sum 1")]
    position_B: Annotated[Array, Data("3", "m", "B", "rest position")]
    A_BI: Annotated[
        Array, Data("3, 3", "-", "I to B", "rotation matrix, interface axes to body axes")
    ]
    phi_B: Annotated[Array, Data("3, m", "m", "B", "translation of the interface per unit mode")]
    psi_B: Annotated[Array, Data("3, m", "rad", "B", "rotation of the interface per unit mode")]
    H_B: Annotated[
        Array | None, Data("3, m, m", "m", "B", "second-order translation of the interface")
    ] = None
    H_psi_B: Annotated[
        Array | None, Data("3, m, m", "rad", "B", "second-order rotation vector of the interface")
    ] = None


@record
class SectionData:
    """A beam cross-section of the body.

    The equations of motion do not use it. With `recovery`, ply stresses follow from resultants,
    with `end_compliance` the effect of held ends, which the beam theory neglects.
    """

    name: str
    K: Annotated[
        Array,
        Data(
            "6, 6",
            M6,
            "section",
            "stiffness: extension, shear 2, shear 3, twist, bending 2, bending 3",
        ),
    ]
    M: Annotated[Array, Data("6, 6", "kg/m, kg, kg m", "section", "mass per length, same order")]
    ply_table: Annotated[str, Data(text="material and lay-up as TOML text")] = ""
    recovery: Annotated[SectionRecovery | None, Nested(packed=True)] = None
    end_compliance: Annotated[
        Array | None,
        Data(
            "6, 6",
            "m/N, 1/N, 1/(N m)",
            "section",
            "what the beam lacks of compliance at an end whose section is held, by resultants",
        ),
    ] = None


@record
class BodyRecovery:
    """Resultants of a beam at stations x along its reference line.

    F6 = resultants_E[s] @ q are [F1 F2 F3 M1 M2 M3] on the face with the normal +x, in section
    axes `_E`. Two stations at one x are the two sides of a point where the resultants jump.
    """

    station_x: Annotated[Array, Data("s", "m", "B", "places along the reference line, rising")]
    section: Annotated[IntArray, Data("s", text="section of each station, by its index")]
    resultants_E: Annotated[
        Array,
        Data("s, 6, m", "N, N m", "section", "F1 F2 F3 M1 M2 M3 on the face +x, per unit mode"),
    ]
    A_BE: Annotated[Array, Data("3, 3", "-", "section to B", "rotation, section axes to body axes")]


@record
class LaminateData:
    """A laminate of the body; plies are listed from bottom to top along e3."""

    name: str
    plies: Annotated[tuple[ShellPly, ...], Rows("plies", "k")]
    ABD: Annotated[Array, Data("6, 6", "N/m, N, N m", "E", "N and M per unit strain and curvature")]
    Ds: Annotated[Array, Data("2, 2", "N/m", "E", "transverse shear stiffness, corrected")]
    stress_M: Annotated[  # 11 22 33 23 13 12 in ply axes
        Array,
        Data(
            "k, 3, 6, 8",
            "1/m, 1/m2",
            "ply",
            "stress at bottom, middle, top per unit resultant",
            "plies/stress_M",
        ),
    ]
    materials: Annotated[
        dict[str, dict[str, object]], Data(text="constants and strengths by name, as JSON text")
    ]
    stiffness_rates: Annotated[
        Array | None,
        Data(
            "18, m, m",
            "m2, m, -",
            "-",
            "derivative of the modal stiffness by the entries 11 22 66 12 16 26 of A, of B, of D",
        ),
    ] = None


@record
class CellResultants:
    """Mean resultants of cells: resultants_E[j] @ q are those of cell `cell[j]`."""

    cell: Annotated[IntArray, Data("e", text="cells, as rows of cell_types")]
    laminate: Annotated[IntArray, Data("e", text="laminate of each cell, by its index")]
    A_BE: Annotated[Array, Data("e, 3, 3", "-", "E to B", "rotation, axes of the cell to B")]
    resultants_E: Annotated[
        Array, Data("e, 8, m", "N/m, N", "E", "N 3, M 3, T 2, mean of the cell, per unit mode")
    ]


@record
class FaceStresses:
    """Stresses at the middle of outer faces of a solid: stress_M[j] @ q are those of `cell[j]`.

    Components 11, 22, 33, 23, 13, 12 in the axes of the material, which are those of the body if it
    is isotropic. `case_stress_M` has the stresses of load cases of the held solid.
    """

    cell: Annotated[IntArray, Data("f", text="faces, as rows of cell_types")]
    material: Annotated[IntArray, Data("f", text="material, by its index in the sorted names")]
    A_BM: Annotated[Array, Data("f, 3, 3", "-", "M to B", "rotation, axes of the material to B")]
    stress_M: Annotated[Array, Data("f, 6, m", "Pa", "M", "11 22 33 23 13 12, per unit mode")]
    materials: Annotated[
        dict[str, dict[str, object]], Data(text="constants and strengths by name, as JSON text")
    ]
    cases: Annotated[tuple[str, ...], Data("g", text="names of load cases", optional=True)] = ()
    case_stress_M: Annotated[
        Array | None, Data("g, f, 6", "Pa", "M", "11 22 33 23 13 12 in each load case")
    ] = None


@record
class ModalPackage:
    """One flexible body, reduced to its modes."""

    body: str
    nodes_B: Annotated[Array, Data("n, 3", "m", "B", "rest positions of the nodes", "mesh/nodes_B")]
    node_ids: Annotated[
        IntArray, Data("n", "-", "-", "identifiers of the nodes, unique", "mesh/node_ids")
    ]
    connectivity: Annotated[
        IntArray,
        Data("i", text="nodes of all cells, as 0-based rows of nodes_B", path="mesh/connectivity"),
    ]
    offsets: Annotated[
        IntArray,
        Data("c+1", text="cell j owns connectivity[offsets[j]:offsets[j+1]]", path="mesh/offsets"),
    ]
    cell_types: Annotated[
        IntArray, Data("c", "-", "-", "VTK cell types", "mesh/cell_types", "uint8")
    ]
    shapes_B: Annotated[
        Array,
        Data(
            "m, n, 6",
            "m, rad",
            "B",
            "translation (first 3) and rotation (last 3)",
            "modes/shapes_B",
        ),
    ]
    mode_kinds: Annotated[
        tuple[str, ...],
        Data("m", text="what each mode is (one of the mode kinds)", path="modes/kinds"),
    ]
    frequencies: Annotated[
        Array,
        Data("m", "rad/s", "-", "natural circular frequency of each mode", "modes/frequencies"),
    ]
    mass: Annotated[
        Array, Data("m, m", "kg m2", "-", "modal mass, full and symmetric", "modes/mass")
    ]
    stiffness: Annotated[
        Array, Data("m, m", "N m", "-", "modal stiffness, full and symmetric", "modes/stiffness")
    ]
    damping: Annotated[
        Array, Data("m, m", "N m s", "-", "modal damping, full and symmetric", "modes/damping")
    ]
    node_mass: Annotated[Array, Data("n", "kg", "-", "lumped mass of each node", "nodal/mass")]
    node_inertia_B: Annotated[
        Array,
        Data("n, 3, 3", "kg m2", "B", "lumped rotary inertia about each node", "nodal/inertia_B"),
    ]
    invariants: Annotated[Invariants, Nested("invariants")]
    interfaces: Annotated[tuple[Interface, ...], Named("interfaces")]
    reference_condition: Annotated[str, Attribute()]
    sections: Annotated[tuple[SectionData, ...], Named("sections")] = ()
    recovery: Annotated[BodyRecovery | None, Nested("recovery", packed=True)] = None
    laminates: Annotated[tuple[LaminateData, ...], Named("laminates", packed=True)] = ()
    cell_resultants: Annotated[CellResultants | None, Nested("cell_resultants", packed=True)] = None
    face_stresses: Annotated[FaceStresses | None, Nested("face_stresses", packed=True)] = None
    mode_labels: Annotated[
        tuple[str, ...],
        Data("m", text="a name for each mode, for people", path="modes/labels", optional=True),
    ] = ()
    second_order: Annotated[SecondOrder | None, Nested("second_order", packed=True)] = None
    compliance: Annotated[
        Array | None,
        Data(
            "l, l",
            "m/N, ...",
            "B",
            "C of the whole body, with all its modes: p' C p is twice its strain energy under the "
            "loads p = forces and moments x y z rx ry rz of each interface, then A (3, 4) by rows "
            "of the inertia load A [x; 1] dm, in the reference condition",
            "modes/compliance",
        ),
    ] = None
    stiffness_error: Annotated[
        Array | None,
        Data(
            "m, m",
            "N m",
            "-",
            "expected error of the modal stiffness by mesh and section, which are too stiff",
            "modes/stiffness_error",
        ),
    ] = None
    provenance: dict[str, Any] = field(default_factory=dict)
    design: tuple[Derivative, ...] = ()  # of the datasets above by design parameters

    @property
    def n_mode(self) -> int:
        """Number of modes m."""
        return int(self.shapes_B.shape[0])
