"""A modal package from measured modes: lumped inertia of the nodes, measured frequencies."""

import sys
from datetime import UTC, datetime
from itertools import pairwise
from pathlib import Path

import numpy as np

from plymotion import __version__

from ...math.arrays import Array, IntArray
from ...package import Interface, ModalPackage, from_stations
from ...package.validation import write_valid
from .measurement import Measurement
from .shapes import Corrected, corrected_shapes

VTK_VERTEX, VTK_LINE = 1, 3


def experimental_package(measured: Measurement) -> ModalPackage:
    """Package of a measured body; warnings are in its provenance.

    Raises
    ------
    InputError : shapes that contradict the support of the test or each other.
    """
    out = corrected_shapes(measured)
    shapes_B = np.ascontiguousarray(out.shapes_B)
    phi_B, psi_B = (np.moveaxis(shapes_B[..., part], 0, 2) for part in (slice(0, 3), slice(3, 6)))
    w = measured.frequencies
    connectivity, offsets, types = _cells(measured)
    interfaces = tuple(_interface(measured, name, out) for name in measured.table.interfaces)
    return ModalPackage(
        body=measured.table.body,
        nodes_B=measured.nodes_B,
        node_ids=measured.node_ids,
        connectivity=connectivity,
        offsets=offsets,
        cell_types=types,
        shapes_B=shapes_B,
        mode_kinds=("experimental",) * len(w),
        frequencies=w,
        mass=np.eye(len(w)),
        stiffness=np.diag(w**2),
        damping=np.diag(2.0 * measured.damping_ratios * w),
        node_mass=measured.node_mass,
        node_inertia_B=measured.node_inertia_B,
        invariants=from_stations(
            measured.node_mass,
            measured.nodes_B,
            phi_B,
            psi_B,
            measured.node_inertia_B,
            "lumped",
        ),
        interfaces=interfaces,
        reference_condition=measured.table.reference.kind,
        mode_labels=measured.labels,
        provenance={
            "plymotion": __version__,
            "command": "plymotion experimental",
            "title": measured.table.title,
            "files_sha256": measured.sha256,
            "warnings": out.warnings,
            "created": datetime.now(UTC).isoformat(timespec="seconds"),
        },
    )


def _cells(measured: Measurement) -> tuple[IntArray, IntArray, IntArray]:
    """Connectivity, offsets and types: the lines of the file, or the nodes as points."""
    ids = measured.node_ids.tolist()
    pairs = [
        [ids.index(a), ids.index(b)] for nodes in measured.table.lines for a, b in pairwise(nodes)
    ]
    cells = np.array(pairs or [[i] for i in range(len(ids))], dtype=np.int64)
    count, size = cells.shape
    kind = VTK_LINE if pairs else VTK_VERTEX
    offsets = size * np.arange(count + 1, dtype=np.int64)
    return cells.ravel(), offsets, np.full(count, kind, dtype=np.int64)


def _interface(measured: Measurement, name: str, out: Corrected) -> Interface:
    """Mean motion of its nodes; the measured rotation, or that of the best-fitting rigid motion."""
    rows = measured.rows(name)
    mean = out.shapes_B[:, rows].mean(axis=1)
    position = measured.nodes_B[rows].mean(axis=0)
    psi = mean[:, 3:].T
    if not measured.has_rotations and name != measured.table.reference.at:
        arms = measured.nodes_B[rows] - position
        psi, rank = _fitted_rotation(arms, out.shapes_B[:, rows, :3])
        if rank < 3:
            out.add_warning(
                "interface-without-rotation",
                f"interface {name}: its {len(rows)} node(s) determine {rank} of 3 rotations "
                "and none was measured; a joint that constrains rotations there would be wrong. "
                "Give at least three nodes that are not on one line, or columns rx, ry, rz",
            )
    return Interface(
        name=name,
        kind="node" if len(rows) == 1 else "average",
        node_ids=measured.node_ids[rows],
        weights=np.full(len(rows), 1.0 / len(rows)),
        position_B=position,
        A_BI=np.eye(3),
        phi_B=mean[:, :3].T,
        psi_B=psi,
    )


def _fitted_rotation(arms: Array, shapes: Array) -> tuple[Array, int]:
    """Best-fitting rotation (3, m) of `arms` (k, 3) for shapes (m, k, 3), and its rank."""
    spread = np.einsum("ka,ka->", arms, arms) * np.eye(3) - arms.T @ arms
    moment = np.cross(arms, shapes).sum(axis=1)
    values = np.linalg.eigvalsh(spread)
    rank = int(np.count_nonzero(values > 1e-6 * max(values[-1], 1e-300)))
    psi = np.linalg.pinv(spread, rcond=1e-6, hermitian=True) @ moment.T
    return psi, rank


def write_measured(path: Path, package: ModalPackage, source: Path) -> int:
    """Write a package of measured modes and say what is doubtful; returns the exit code 0."""
    write_valid(path, package, str(source))
    for warning in package.provenance["warnings"]:
        print(f"warning [{warning['code']}] {warning['message']}", file=sys.stderr)
    print(f"{path}: {package.body}, {package.n_mode} measured modes")
    return 0
