"""The modal package in memory: the data of one flexible body for the solver.

All arrays are in SI units and in the body frame (`_B`). `m` is the number of
modes, `n` the number of nodes, `c` the number of cells. The file layout is in
layout.py and docs/format.md.
"""

from dataclasses import dataclass, field
from typing import Any, get_args

from ...math.arrays import Array, IntArray
from ..section.schema import SectionRecovery
from .laminate_data import CellResultants, LaminateData
from .specification import MassForm, ReferenceKind

FORMAT = "plymotion modal package"
FORMAT_VERSION = (1, 3)

MODE_KINDS = ("rigid", "fixed_normal", "constraint", "attachment", "residual", "experimental")
REFERENCE_CONDITIONS = get_args(ReferenceKind)
MASS_FORMS = get_args(MassForm)


@dataclass(frozen=True)
class Invariants:
    """Sums over mass stations k that give the inertia of a moving flexible body.

    A station has mass m_k, rest position x_k, translation shapes phi_k (3, m),
    rotation shapes psi_k (3, m) and rotary inertia J_k (3, 3) about its own
    mass centre. Modal coordinates are numbers, so phi is in m and psi in rad.
    Stations are nodes (lumped) or integration points of the
    consistent mass; the sums have the same form. Indices a, b are body axes.
    """

    mass: float  # sum m_k                                  [kg]
    S0_B: Array  # (3,)         sum m x_a                   [kg m]
    S_B: Array  # (3, m)        sum m phi_ai                [kg m]
    T00_B: Array  # (3, 3)      sum m x_a x_b               [kg m2]
    T01_B: Array  # (3, 3, m)   sum m x_a phi_bi            [kg m2]
    T11_B: Array  # (3, 3, m, m) sum m phi_ai phi_bj        [kg m2]
    J0_B: Array  # (3, 3)       sum J_k                     [kg m2]
    J_psi_B: Array  # (3, m)    sum J_k psi_ki              [kg m]
    mass_form: str  # one of MASS_FORMS


@dataclass(frozen=True)
class SecondOrder:
    """Sums over the mass stations of `Invariants` with their second-order translation h_k.

    A station moves to x + phi q + 1/2 q' h q, h (3, m, m) symmetric in the modes.
    """

    Z0_B: Array  # (3, m, m)    sum m h_a,ij                [kg m]
    Z1_B: Array  # (3, 3, m, m) sum m x_a h_b,ij            [kg m2]
    G3: Array  # (m, m, m)      sum m phi_i . h_jk          [kg m2]
    G4: Array  # (m, m, m, m)   sum m h_ij . h_kl           [kg m2]


@dataclass(frozen=True)
class Interface:
    """A named point where joints, loads and masses attach."""

    name: str
    kind: str  # "node" (one node) or "average" (weighted nodes)
    node_ids: IntArray  # (k,)
    weights: Array  # (k,), sum 1
    position_B: Array  # (3,) rest position                 [m]
    A_BI: Array  # (3, 3) interface axes to body axes       [-]
    phi_B: Array  # (3, m) translation per unit mode        [m]
    psi_B: Array  # (3, m) rotation per unit mode           [rad]
    # With second-order data only: translation phi q + 1/2 q' H q, rotation vector in the same form.
    H_B: Array | None = None  # (3, m, m)                   [m]
    H_psi_B: Array | None = None  # (3, m, m)               [rad]


@dataclass(frozen=True)
class SectionData:
    """A beam cross-section of the body.

    The equations of motion do not use it. With `recovery`, ply stresses follow from resultants,
    with `end_compliance` what the beam theory leaves out at held ends.
    """

    name: str
    K: Array  # (6, 6), order extension shear2 shear3 twist bend2 bend3
    M: Array  # (6, 6), per length, same order of velocities
    ply_table: str = ""  # TOML text of material and lay-up
    recovery: SectionRecovery | None = None
    end_compliance: Array | None = None  # (6, 6), see SectionFile


@dataclass(frozen=True)
class BodyRecovery:
    """Resultants of a beam at stations x along its reference line, `s` of them.

    F6 = resultants_E[s] @ q are [F1 F2 F3 M1 M2 M3] on the face with the normal +x, in section
    axes `_E`. Two stations at one x are the two sides of a point where the resultants jump.
    """

    station_x: Array  # (s,) rising                         [m]
    section: IntArray  # (s,) row of the package's sections
    resultants_E: Array  # (s, 6, m) per unit mode          [N, N m]
    A_BE: Array  # (3, 3) section axes in body axes         [-]


@dataclass(frozen=True)
class ModalPackage:
    """One flexible body, reduced to its modes."""

    body: str
    nodes_B: Array  # (n, 3)                                [m]
    node_ids: IntArray  # (n,)
    connectivity: IntArray  # flat node indices (0-based rows of nodes_B)
    offsets: IntArray  # (c + 1,)
    cell_types: IntArray  # (c,) VTK cell types
    shapes_B: Array  # (m, n, 6): translation then rotation [m, rad]
    mode_kinds: tuple[str, ...]  # m of MODE_KINDS
    frequencies: Array  # (m,) natural frequencies          [rad/s]
    mass: Array  # (m, m) modal mass
    stiffness: Array  # (m, m) modal stiffness
    damping: Array  # (m, m) modal damping
    node_mass: Array  # (n,)                                [kg]
    node_inertia_B: Array  # (n, 3, 3)                      [kg m2]
    invariants: Invariants
    interfaces: tuple[Interface, ...]
    reference_condition: str
    sections: tuple[SectionData, ...] = ()
    recovery: BodyRecovery | None = None
    laminates: tuple[LaminateData, ...] = ()
    cell_resultants: CellResultants | None = None
    mode_labels: tuple[str, ...] = ()  # e.g. "bending-xy 1"
    second_order: SecondOrder | None = None
    provenance: dict[str, Any] = field(default_factory=dict)

    @property
    def n_mode(self) -> int:
        """Number of modes m."""
        return int(self.shapes_B.shape[0])
