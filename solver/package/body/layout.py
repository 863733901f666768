"""Layout of a modal package: one table for writer, reader, validator and manual.

Shapes are symbols: `n` nodes, `c` cells, `i` connectivity entries, `m` modes, `s`
stations of the resultants; `k` nodes of an interface; in a section `k` plies and
`p` points of its recovery; in a laminate `k` plies; `e` cells of a shell with
resultants. `<interface>`, `<section>` and `<laminate>` stand for names in the package. The modal
coordinates are dimensionless, so that a mode shape is in metres and radians, and modal mass,
damping and stiffness are in kg m2, N m s and N m: all units follow from that.
"""

import numpy as np

from ..common.dataset import DatasetSpec, F, I, T, spec
from ..common.identity import FileFormat
from .schema import FORMAT, FORMAT_VERSION, ModalPackage

GROUP = "modal_package"
MODAL_PACKAGE = FileFormat(FORMAT, FORMAT_VERSION, GROUP, "body")
MODAL_VIEW = f"{GROUP}/mesh", "nodes_B"  # what ParaView shows: group and nodes


BODY_LAYOUT: tuple[DatasetSpec, ...] = (
    spec("mesh/nodes_B", "n, 3", F, "m", "B", "rest positions of the nodes"),
    spec("mesh/node_ids", "n", I, "-", "-", "identifiers of the nodes, unique"),
    spec("mesh/connectivity", "i", I, "-", "-", "nodes of all cells, as 0-based rows of nodes_B"),
    spec("mesh/offsets", "c+1", I, "-", "-", "cell j owns connectivity[offsets[j]:offsets[j+1]]"),
    spec("mesh/cell_types", "c", "uint8", "-", "-", "VTK cell types"),
    spec(
        "modes/shapes_B", "m, n, 6", F, "m, rad", "B", "translation (first 3) and rotation (last 3)"
    ),
    spec("modes/kinds", "m", T, "-", "-", "what each mode is (one of the mode kinds)"),
    spec("modes/labels", "m", T, "-", "-", "a name for each mode, for people", optional=True),
    spec("modes/frequencies", "m", F, "rad/s", "-", "natural circular frequency of each mode"),
    spec("modes/mass", "m, m", F, "kg m2", "-", "modal mass, full and symmetric"),
    spec("modes/stiffness", "m, m", F, "N m", "-", "modal stiffness, full and symmetric"),
    spec("modes/damping", "m, m", F, "N m s", "-", "modal damping, full and symmetric"),
    spec("nodal/mass", "n", F, "kg", "-", "lumped mass of each node"),
    spec("nodal/inertia_B", "n, 3, 3", F, "kg m2", "B", "lumped rotary inertia about each node"),
    spec("invariants/mass", "", F, "kg", "-", "sum m"),
    spec("invariants/S0_B", "3", F, "kg m", "B", "sum m x_a"),
    spec("invariants/S_B", "3, m", F, "kg m", "B", "sum m phi_ai"),
    spec("invariants/T00_B", "3, 3", F, "kg m2", "B", "sum m x_a x_b"),
    spec("invariants/T01_B", "3, 3, m", F, "kg m2", "B", "sum m x_a phi_bi"),
    spec("invariants/T11_B", "3, 3, m, m", F, "kg m2", "B", "sum m phi_ai phi_bj"),
    spec("invariants/J0_B", "3, 3", F, "kg m2", "B", "sum J"),
    spec("invariants/J_psi_B", "3, m", F, "kg m2", "B", "sum J_ab psi_bi"),
)

INTERFACE_LAYOUT: tuple[DatasetSpec, ...] = (
    spec("node_ids", "k", I, "-", "-", "identifiers of the nodes that carry the interface"),
    spec("weights", "k", F, "-", "-", "share of each node, sum 1"),
    spec("position_B", "3", F, "m", "B", "rest position"),
    spec("A_BI", "3, 3", F, "-", "I to B", "rotation matrix, interface axes to body axes"),
    spec("phi_B", "3, m", F, "m", "B", "translation of the interface per unit mode"),
    spec("psi_B", "3, m", F, "rad", "B", "rotation of the interface per unit mode"),
)

SECTION_LAYOUT: tuple[DatasetSpec, ...] = (
    spec(
        "K",
        "6, 6",
        F,
        "N, N m, N m2",
        "section",
        "stiffness: extension, shear 2, shear 3, twist, bending 2, bending 3",
    ),
    spec("M", "6, 6", F, "kg/m, kg, kg m", "section", "mass per length, same order"),
    spec("ply_table", "", T, "-", "-", "material and lay-up as TOML text"),
    spec(
        "end_compliance",
        "6, 6",
        F,
        "m/N, 1/N, 1/(N m)",
        "section",
        "what the beam lacks of compliance at an end whose section is held, by resultants",
        optional=True,
    ),
)


# All datasets of the group `recovery`, or none.
BODY_RECOVERY_LAYOUT: tuple[DatasetSpec, ...] = (
    spec("recovery/station_x", "s", F, "m", "B", "places along the reference line, rising"),
    spec("recovery/section", "s", I, "-", "-", "section of each station, by its index"),
    spec(
        "recovery/resultants_E",
        "s, 6, m",
        F,
        "N, N m",
        "section",
        "F1 F2 F3 M1 M2 M3 on the face +x, per unit mode",
    ),
    spec("recovery/A_BE", "3, 3", F, "-", "section to B", "rotation, section axes to body axes"),
)


def body_sizes(package: ModalPackage) -> dict[str, int]:
    """Return the sizes n, c, i, m that the arrays of a package declare."""
    return {
        "n": len(package.nodes_B),
        "c": len(package.cell_types),
        "i": len(package.connectivity),
        "m": int(np.shape(package.shapes_B)[0]),
    }


def body_values(package: ModalPackage) -> dict[str, object]:
    """Return the value of every dataset of BODY_LAYOUT by path."""
    p, inv = package, package.invariants
    values: dict[str, object] = {
        "mesh/nodes_B": p.nodes_B,
        "mesh/node_ids": p.node_ids,
        "mesh/connectivity": p.connectivity,
        "mesh/offsets": p.offsets,
        "mesh/cell_types": p.cell_types,
        "modes/shapes_B": p.shapes_B,
        "modes/kinds": p.mode_kinds,
        "modes/frequencies": p.frequencies,
        "modes/mass": p.mass,
        "modes/stiffness": p.stiffness,
        "modes/damping": p.damping,
        "nodal/mass": p.node_mass,
        "nodal/inertia_B": p.node_inertia_B,
    }
    if p.mode_labels:
        values["modes/labels"] = p.mode_labels
    for name in ("mass", "S0_B", "S_B", "T00_B", "T01_B", "T11_B", "J0_B", "J_psi_B"):
        values[f"invariants/{name}"] = getattr(inv, name)
    return values
