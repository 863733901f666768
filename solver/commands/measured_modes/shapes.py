"""Measured shapes made fit for a floating frame: tied to it, orthonormal in the nodes' mass.

A measured shape has any scale, is nearly but not quite orthogonal to the others in the mass of the
nodes, and holds a little of the support's motion. Three corrections, each with a doubt if it is
large:

- the frame: nodes that were held are at rest; a body that hung freely loses what its shapes have
  of the rigid motions, so that they have no momentum (mean axis);
- scale: unit modal mass;
- orthogonality: each shape loses what it has of the shapes below it in frequency (Gram-Schmidt).
  The lowest, which matter most and are measured best, stay as they are; spreading the correction
  over all alike makes the lowest frequencies of a modified body several times worse.

The frequencies stay the measured ones.
"""

from dataclasses import dataclass, field

import numpy as np

from ...errors import InputError
from ...math.arrays import Array
from ...package.body.invariants import rigid_motions
from .measurement import Measurement

HELD = 0.01  # motion of held nodes, against the largest: more is no clamp
RIGID = 0.1  # share of a shape's mass norm that is rigid motion
COUPLED = 0.1  # cosine of two shapes in the mass of the nodes
SCALED = 0.1  # modal mass of mass-normalised shapes, from 1


@dataclass
class Corrected:
    """Shapes (m, n, 6) of unit modal mass, and doubts about the measurement."""

    shapes_B: Array
    warnings: list[dict[str, str]] = field(default_factory=list)

    def doubt(self, code: str, message: str) -> None:
        """Add a warning."""
        self.warnings.append({"code": code, "message": message})


def corrected_shapes(measured: Measurement) -> Corrected:
    """Tie, scale and orthonormalise the shapes of a measurement.

    Raises
    ------
    InputError : a held interface moves; shapes are not independent.
    """
    out = Corrected(measured.shapes_B.copy())
    if measured.table.reference.kind == "clamped":
        _hold(measured, out)
    else:
        _float(measured, out)
    _orthonormalise(measured, out)
    return out


def mass_times(measured: Measurement, shapes_B: Array) -> Array:
    """Momentum and angular momentum of each node per unit rate of shapes (m, n, 6)."""
    momentum = measured.node_mass[:, None] * shapes_B[..., :3]
    spin = np.einsum("nab,mnb->mna", measured.node_inertia_B, shapes_B[..., 3:])
    return np.concatenate([momentum, spin], axis=-1)


def _hold(measured: Measurement, out: Corrected) -> None:
    at = str(measured.table.reference.at)
    rows = measured.rows(at)
    for part, unit in ((slice(0, 3), "displacement"), (slice(3, 6), "rotation")):
        largest = np.abs(out.shapes_B[..., part]).max(axis=(1, 2))
        moved = np.abs(out.shapes_B[:, rows, part]).max(axis=(1, 2))
        bad = np.flatnonzero(moved > HELD * largest)
        if bad.size:
            i = int(bad[0])
            raise InputError(
                f"mode {measured.labels[i]!r}: the {unit} of the held interface {at} is "
                f"{moved[i] / largest[i]:.1%} of the largest, expected below {HELD:.0%}: "
                'a body that was not held needs reference.kind = "mean-axis"'
            )
    out.shapes_B[:, rows] = 0.0


def _float(measured: Measurement, out: Corrected) -> None:
    R = np.moveaxis(rigid_motions(measured.nodes_B), 2, 0)  # (6, n, 6)
    MR, X = mass_times(measured, R), out.shapes_B
    inertia = np.einsum("ink,jnk->ij", R, MR)
    # nodes on one line without inertias have no inertia about it, and no motion to take away
    share = np.linalg.pinv(inertia, rcond=1e-10, hermitian=True) @ np.einsum("ink,mnk->im", MR, X)
    rigid = np.einsum("im,ink->mnk", share, R)
    before = np.einsum("mnk,mnk->m", X, mass_times(measured, X))
    ratio = np.sqrt(np.einsum("mnk,mnk->m", rigid, mass_times(measured, rigid)) / before)
    out.shapes_B = X - rigid
    for i in np.flatnonzero(ratio > RIGID):
        out.doubt(
            "measured-shape-rigid",
            f"mode {measured.labels[i]!r}: {ratio[i]:.0%} of the shape is motion of the body as a "
            f"whole (a free body: below {RIGID:.0%}); it was taken out. Check the nodal masses and "
            "the suspension",
        )


def _orthonormalise(measured: Measurement, out: Corrected) -> None:
    X = out.shapes_B
    gram = np.einsum("ink,jnk->ij", X, mass_times(measured, X))
    scale = np.sqrt(np.diag(gram))
    if not (scale > 0.0).all():
        label = measured.labels[int(np.argmin(scale))]
        raise InputError(f"mode {label!r}: the shape moves no mass; expected motion where mass is")
    if measured.table.mass_normalised:
        for i in np.flatnonzero(np.abs(scale**2 - 1.0) > SCALED):
            out.doubt(
                "measured-modal-mass",
                f"mode {measured.labels[i]!r}: the nodal masses give a modal mass of "
                f"{scale[i] ** 2:.3g}, its shape is said to have 1",
            )
    cosine = gram / np.outer(scale, scale)
    if not np.linalg.eigvalsh(cosine)[0] > 1e-3:
        i, j = np.unravel_index(np.argmax(np.abs(np.triu(cosine, 1))), cosine.shape)
        raise InputError(
            f"modes {measured.labels[i]!r} and {measured.labels[j]!r}: the shapes are not "
            f"independent (cosine {cosine[i, j]:.3f} in the nodal masses): more nodes or "
            "directions tell them apart"
        )
    pairs = np.argwhere(np.abs(np.triu(cosine, 1)) > COUPLED)
    for i, j in pairs:
        out.doubt(
            "measured-shapes-coupled",
            f"modes {measured.labels[i]!r} and {measured.labels[j]!r}: cosine "
            f"{cosine[i, j]:.2f} in the nodal masses (modes: below {COUPLED:g}); the second was "
            "made orthogonal to the first. Check masses and shapes",
        )
    upper = np.linalg.inv(np.linalg.cholesky(cosine)).T / scale[:, None]
    out.shapes_B = np.einsum("ink,ij->jnk", X, upper)
