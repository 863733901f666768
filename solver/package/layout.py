"""What lies where in a modal package: one table for writer, reader, validator and manual.

Shapes are symbols: `n` nodes, `c` cells, `i` connectivity entries, `m` modes,
`k` nodes of an interface. `<interface>` and `<section>` stand for names that
the package chooses. The modal coordinates are dimensionless, so that a mode
shape is in metres and radians, and modal mass, damping and stiffness are in
kg m2, N m s and N m: all units follow from that.
"""

from dataclasses import dataclass

import numpy as np

from .schema import ModalPackage

GROUP = "modal_package"


@dataclass(frozen=True)
class DatasetSpec:
    """One dataset of the file: where, how large, which type, what it means."""

    path: str  # below /modal_package
    shape: tuple[str | int, ...]
    type: str  # float64, int64, uint8 or text (fixed-length UTF-8)
    unit: str
    frame: str  # B body, I interface, section, or "-"
    description: str
    optional: bool = False


def _spec(
    path: str,
    shape: str,
    type: str,
    unit: str,
    frame: str,
    description: str,
    *,
    optional: bool = False,
) -> DatasetSpec:
    axes = tuple(int(s) if s.isdigit() else s for s in shape.replace(",", " ").split())
    return DatasetSpec(path, axes, type, unit, frame, description, optional)


F, I, T = "float64", "int64", "text"  # noqa: E741

BODY_LAYOUT: tuple[DatasetSpec, ...] = (
    _spec("mesh/nodes_B", "n, 3", F, "m", "B", "rest positions of the nodes"),
    _spec("mesh/node_ids", "n", I, "-", "-", "identifiers of the nodes, unique"),
    _spec("mesh/connectivity", "i", I, "-", "-", "nodes of all cells, as 0-based rows of nodes_B"),
    _spec("mesh/offsets", "c+1", I, "-", "-", "cell j owns connectivity[offsets[j]:offsets[j+1]]"),
    _spec("mesh/cell_types", "c", "uint8", "-", "-", "VTK cell types"),
    _spec(
        "modes/shapes_B", "m, n, 6", F, "m, rad", "B", "translation (first 3) and rotation (last 3)"
    ),
    _spec("modes/kinds", "m", T, "-", "-", "what each mode is (one of the mode kinds)"),
    _spec("modes/labels", "m", T, "-", "-", "a name for each mode, for people", optional=True),
    _spec("modes/frequencies", "m", F, "rad/s", "-", "natural circular frequency of each mode"),
    _spec("modes/mass", "m, m", F, "kg m2", "-", "modal mass, full and symmetric"),
    _spec("modes/stiffness", "m, m", F, "N m", "-", "modal stiffness, full and symmetric"),
    _spec("modes/damping", "m, m", F, "N m s", "-", "modal damping, full and symmetric"),
    _spec("nodal/mass", "n", F, "kg", "-", "lumped mass of each node"),
    _spec("nodal/inertia_B", "n, 3, 3", F, "kg m2", "B", "lumped rotary inertia about each node"),
    _spec("invariants/mass", "", F, "kg", "-", "sum m"),
    _spec("invariants/S0_B", "3", F, "kg m", "B", "sum m x_a"),
    _spec("invariants/S_B", "3, m", F, "kg m", "B", "sum m phi_ai"),
    _spec("invariants/T00_B", "3, 3", F, "kg m2", "B", "sum m x_a x_b"),
    _spec("invariants/T01_B", "3, 3, m", F, "kg m2", "B", "sum m x_a phi_bi"),
    _spec("invariants/T11_B", "3, 3, m, m", F, "kg m2", "B", "sum m phi_ai phi_bj"),
    _spec("invariants/J0_B", "3, 3", F, "kg m2", "B", "sum J"),
    _spec("invariants/J_psi_B", "3, m", F, "kg m2", "B", "sum J_ab psi_bi"),
)

INTERFACE_LAYOUT: tuple[DatasetSpec, ...] = (
    _spec("node_ids", "k", I, "-", "-", "identifiers of the nodes that carry the interface"),
    _spec("weights", "k", F, "-", "-", "share of each node, sum 1"),
    _spec("position_B", "3", F, "m", "B", "rest position"),
    _spec("A_BI", "3, 3", F, "-", "I to B", "rotation matrix, interface axes to body axes"),
    _spec("phi_B", "3, m", F, "m", "B", "translation of the interface per unit mode"),
    _spec("psi_B", "3, m", F, "rad", "B", "rotation of the interface per unit mode"),
)

SECTION_LAYOUT: tuple[DatasetSpec, ...] = (
    _spec(
        "K",
        "6, 6",
        F,
        "N, N m, N m2",
        "section",
        "stiffness: extension, shear 2, shear 3, twist, bending 2, bending 3",
    ),
    _spec("M", "6, 6", F, "kg/m, kg, kg m", "section", "mass per length, same order"),
    _spec("ply_table", "", T, "-", "-", "material and lay-up as TOML text"),
)


def documented_layout() -> tuple[DatasetSpec, ...]:
    """Return every dataset of the format, names of interfaces and sections as <...>."""
    groups = (
        ("", BODY_LAYOUT),
        ("interfaces/<interface>/", INTERFACE_LAYOUT),
        ("sections/<section>/", SECTION_LAYOUT),
    )
    return tuple(
        DatasetSpec(prefix + s.path, s.shape, s.type, s.unit, s.frame, s.description, s.optional)
        for prefix, specs in groups
        for s in specs
    )


def shape_text(shape: tuple[str | int, ...]) -> str:
    """Write a symbolic shape for people: (m, n, 6), or scalar."""
    return f"({', '.join(map(str, shape))})" if shape else "scalar"


def expected_shape(spec: DatasetSpec, sizes: dict[str, int]) -> tuple[int, ...]:
    """Put numbers for the symbols of a shape."""
    sizes = {**sizes, "c+1": sizes["c"] + 1} if "c" in sizes else sizes
    return tuple(axis if isinstance(axis, int) else sizes[axis] for axis in spec.shape)


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
