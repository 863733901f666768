"""A modal package from measured modes: lumped inertia, measured frequencies, corrected shapes."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

import numpy as np

from ...errors import InputError
from ...math.arrays import Array, IntArray
from .invariants import from_stations, rigid_motions
from .package_schema import Interface, ModalPackage


@dataclass(frozen=True)
class Measurement:
    """Modes of a body at its nodes, in ascending frequency; n nodes, m modes. SI units.

    Attributes
    ----------
    body : name
    held : interface that was fixed to a rig; None: the body was free
    interfaces : rows of the nodes of each interface
    lines : rows of nodes that are connected in pictures, for each line
    node_ids : (n,)
    nodes_B : (n, 3) positions [m]
    node_mass : (n,) [kg]
    node_inertia_B : (n, 3, 3) about the node [kg m2]
    shapes_B : (m, n, 6) displacements and rotations, any scale; zero where not measured
    has_rotations : whether rotations were measured, in every mode
    frequencies : (m,) [rad/s]
    damping_ratios : (m,)
    labels : m names
    mass_normalised : whether the shapes are said to have unit modal mass
    """

    body: str
    held: str | None
    interfaces: dict[str, IntArray]
    lines: list[list[int]]
    node_ids: IntArray
    nodes_B: Array
    node_mass: Array
    node_inertia_B: Array
    shapes_B: Array
    has_rotations: bool
    frequencies: Array
    damping_ratios: Array
    labels: tuple[str, ...]
    mass_normalised: bool = False


# Correction of measured shapes: reference condition, orthonormality in the nodal masses.
#
# A measured shape has an arbitrary scale, is only nearly orthogonal to the others in the nodal
# masses, and contains a small motion of the support. There are three corrections, each with a
# warning if it is large:
#
# - the frame: the motion of held nodes is set to zero; from the shapes of a free body the rigid
#   motions are removed, so that they have no momentum (mean axis);
# - scale: unit modal mass;
# - orthogonality: each shape is made orthogonal to those of lower frequency (Gram-Schmidt).
#   The lowest shapes are most important and most accurate; they change least. An equal correction
#   of all shapes makes the lowest frequencies of a modified body several times less accurate.
#
# The measured frequencies are kept.

HELD = 0.01  # limit of the motion of held nodes, relative to the largest motion
RIGID = 0.1  # limit of the rigid motion in a shape, relative to its mass norm
COUPLED = 0.1  # limit of the cosine of two shapes in the nodal masses
SCALED = 0.1  # limit of the deviation of the modal mass of mass-normalised shapes from 1


@dataclass
class Corrected:
    """Shapes (m, n, 6) of unit modal mass, and warnings about the measurement."""

    shapes_B: Array
    warnings: list[dict[str, str]] = field(default_factory=list)

    def add_warning(self, code: str, message: str) -> None:
        """Add a warning."""
        self.warnings.append({"code": code, "message": message})


def corrected_shapes(measured: Measurement) -> Corrected:
    """Apply the reference condition to measured shapes, scale and orthogonalise them.

    Raises
    ------
    InputError : a held interface moves; shapes are not independent.
    """
    out = Corrected(measured.shapes_B.copy())
    if measured.held is not None:
        _apply_clamped(measured, out)
    else:
        _apply_mean_axis(measured, out)
    _orthonormalise(measured, out)
    return out


def mass_times(measured: Measurement, shapes_B: Array) -> Array:
    """Momentum and angular momentum of each node per unit rate of shapes (m, n, 6)."""
    momentum = measured.node_mass[:, None] * shapes_B[..., :3]
    spin = np.einsum("nab,mnb->mna", measured.node_inertia_B, shapes_B[..., 3:])
    return np.concatenate([momentum, spin], axis=-1)


def _apply_clamped(measured: Measurement, out: Corrected) -> None:
    at = str(measured.held)
    rows = measured.interfaces[at]
    for part, unit in ((slice(0, 3), "displacement"), (slice(3, 6), "rotation")):
        largest = np.abs(out.shapes_B[..., part]).max(axis=(1, 2))
        moved = np.abs(out.shapes_B[:, rows, part]).max(axis=(1, 2))
        bad = np.flatnonzero(moved > HELD * largest)
        if bad.size:
            i = int(bad[0])
            raise InputError(
                f"mode {measured.labels[i]!r}: the {unit} of the held interface {at} is "
                f"{moved[i] / largest[i]:.1%} of the largest, expected below {HELD:.0%}: "
                'for a body that was not held, use reference.kind = "mean-axis"'
            )
    out.shapes_B[:, rows] = 0.0


def _apply_mean_axis(measured: Measurement, out: Corrected) -> None:
    R = np.moveaxis(rigid_motions(measured.nodes_B), 2, 0)  # (6, n, 6)
    MR, X = mass_times(measured, R), out.shapes_B
    inertia = np.einsum("ink,jnk->ij", R, MR)
    # nodes on a line without rotary inertia have no inertia about the line, so nothing is removed
    share = np.linalg.pinv(inertia, rcond=1e-10, hermitian=True) @ np.einsum("ink,mnk->im", MR, X)
    rigid = np.einsum("im,ink->mnk", share, R)
    before = np.einsum("mnk,mnk->m", X, mass_times(measured, X))
    ratio = np.sqrt(np.einsum("mnk,mnk->m", rigid, mass_times(measured, rigid)) / before)
    out.shapes_B = X - rigid
    for i in np.flatnonzero(ratio > RIGID):
        out.add_warning(
            "measured-shape-rigid",
            f"mode {measured.labels[i]!r}: {ratio[i]:.0%} of the shape is rigid-body motion "
            f"(expected for a free body: below {RIGID:.0%}); it was removed. Check the nodal "
            "masses and the suspension",
        )


def _orthonormalise(measured: Measurement, out: Corrected) -> None:
    X = out.shapes_B
    gram = np.einsum("ink,jnk->ij", X, mass_times(measured, X))
    scale = np.sqrt(np.diag(gram))
    if not (scale > 0.0).all():
        label = measured.labels[int(np.argmin(scale))]
        raise InputError(
            f"mode {label!r}: the shape moves no mass; expected motion of nodes with mass"
        )
    if measured.mass_normalised:
        for i in np.flatnonzero(np.abs(scale**2 - 1.0) > SCALED):
            out.add_warning(
                "measured-modal-mass",
                f"mode {measured.labels[i]!r}: the nodal masses give a modal mass of "
                f"{scale[i] ** 2:.3g}, but mass_normalised = true requires 1",
            )
    cosine = gram / np.outer(scale, scale)
    if not np.linalg.eigvalsh(cosine)[0] > 1e-3:
        i, j = np.unravel_index(np.argmax(np.abs(np.triu(cosine, 1))), cosine.shape)
        raise InputError(
            f"modes {measured.labels[i]!r} and {measured.labels[j]!r}: the shapes are not "
            f"independent (cosine {cosine[i, j]:.3f} in the nodal masses): measure more nodes or "
            "directions to distinguish them"
        )
    pairs = np.argwhere(np.abs(np.triu(cosine, 1)) > COUPLED)
    for i, j in pairs:
        out.add_warning(
            "measured-shapes-coupled",
            f"modes {measured.labels[i]!r} and {measured.labels[j]!r}: cosine "
            f"{cosine[i, j]:.2f} in the nodal masses (modes: below {COUPLED:g}); the second was "
            "made orthogonal to the first. Check masses and shapes",
        )
    upper = np.linalg.inv(np.linalg.cholesky(cosine)).T / scale[:, None]
    out.shapes_B = np.einsum("ink,ij->jnk", X, upper)


# A modal package from measured modes: lumped inertia of the nodes, measured frequencies.

VTK_VERTEX, VTK_LINE = 1, 3


def experimental_package(measured: Measurement, provenance: Mapping[str, Any]) -> ModalPackage:
    """Package of a measured body; warnings are added to its provenance.

    Raises
    ------
    InputError : shapes that contradict the support of the test or each other.
    """
    out = corrected_shapes(measured)
    shapes_B = np.ascontiguousarray(out.shapes_B)
    phi_B, psi_B = (np.moveaxis(shapes_B[..., part], 0, 2) for part in (slice(0, 3), slice(3, 6)))
    w = measured.frequencies
    connectivity, offsets, types = _cells(measured)
    interfaces = tuple(_interface(measured, name, out) for name in measured.interfaces)
    return ModalPackage(
        body=measured.body,
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
        reference_condition="mean-axis" if measured.held is None else "clamped",
        mode_labels=measured.labels,
        provenance={**provenance, "warnings": out.warnings},
    )


def _cells(measured: Measurement) -> tuple[IntArray, IntArray, IntArray]:
    """Connectivity, offsets and types: the lines of the file, or the nodes as points."""
    pairs = [list(pair) for nodes in measured.lines for pair in pairwise(nodes)]
    cells = np.array(pairs or [[i] for i in range(len(measured.node_ids))], dtype=np.int64)
    count, size = cells.shape
    kind = VTK_LINE if pairs else VTK_VERTEX
    offsets = size * np.arange(count + 1, dtype=np.int64)
    return cells.ravel(), offsets, np.full(count, kind, dtype=np.int64)


def _interface(measured: Measurement, name: str, out: Corrected) -> Interface:
    """Mean motion of its nodes; the measured rotation, or that of the best-fitting rigid motion."""
    rows = measured.interfaces[name]
    mean = out.shapes_B[:, rows].mean(axis=1)
    position = measured.nodes_B[rows].mean(axis=0)
    psi = mean[:, 3:].T
    if not measured.has_rotations and name != measured.held:
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
