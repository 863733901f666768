"""A modal package as the .fem file of MBDyn's modal joint: record groups 1 to 12.

Checked against the text of the format (the manual's section on the FEM file format), without a run
of MBDyn.
"""

from collections.abc import Iterable, Iterator
from pathlib import Path

import numpy as np

from ....solver.errors import printable
from ....solver.math.arrays import Array
from ....solver.package import ModalPackage
from ....solver.package.body.plausibility import centre_inertia
from ....solver.package.common.files import write_text

SUFFIX = ".fem"


def write(package: ModalPackage, out: Path, source: Path) -> str:
    """Write nodes, shapes, modal matrices, nodal masses and the inertia of the rigid body.

    The joint has its own keys for damping; the file has no place for it.

    Parameters
    ----------
    package, out, source : see contract.py
    """
    write_text(out, "\n".join(_lines(package)) + "\n", encoding="ascii")
    return f"{package.n_mode} modes at {len(package.nodes_B)} nodes; MBDyn was not run with it"


def _lines(package: ModalPackage) -> Iterator[str]:
    n, m = len(package.nodes_B), package.n_mode
    yield f"** {printable(package.body)[:60]}: modal package of Plymotion; m, kg, s"
    yield from _group(1, "HEADER")
    yield "**   REVISION, NODES, NORMAL, ATTACHMENT, CONSTRAINT, REJECTED MODES"
    yield f"   REV0 {n} {m} 0 0 0"
    yield from _group(2, "FINITE ELEMENT NODE LIST")
    yield from (str(label) for label in package.node_ids)
    for number, title in ((3, "INITIAL MODAL DISPLACEMENTS"), (4, "INITIAL MODAL VELOCITIES")):
        yield from _group(number, title)
        yield from _rows(np.zeros((m, 1)))
    for k, axis in enumerate("XYZ"):
        yield from _group(5 + k, f"NODAL {axis} COORDINATES")
        yield from _rows(package.nodes_B[:, k : k + 1])
    yield from _group(8, "MODE SHAPES")
    for i, shape in enumerate(package.shapes_B, 1):
        yield f"**    NORMAL MODE SHAPE #  {i}"
        yield from _rows(shape)
    yield from _group(9, "MODAL MASS MATRIX")
    yield from _rows(package.mass)
    yield from _group(10, "MODAL STIFFNESS MATRIX")
    yield from _rows(package.stiffness)
    yield from _group(11, "DIAGONAL OF LUMPED MASS MATRIX")
    turning = np.diagonal(package.node_inertia_B, axis1=1, axis2=2)
    yield from _rows(np.hstack([np.repeat(package.node_mass[:, None], 3, axis=1), turning]))
    yield from _group(12, "GLOBAL INERTIA")
    mass = package.invariants.mass
    yield from _rows(np.array([[mass]]))
    yield from _rows(np.vstack([package.invariants.S0_B / mass, centre_inertia(package)]))


def _group(number: int, title: str) -> Iterable[str]:
    return "**", f"** RECORD GROUP {number}, {title}"


def _rows(values: Array) -> Iterator[str]:
    for row in values:
        yield " ".join(f"{value:.16e}" for value in row)
