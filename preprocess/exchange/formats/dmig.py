"""A body as NASTRAN bulk data: grid points at its interfaces, DMIG of stiffness and mass.

The six motions of the frame and the modal coordinates, z, give the six motions of every interface,
u = A z. As many coordinates are replaced by u; the others become scalar points.
"""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import scipy.linalg

from ....solver.errors import InputError, printable
from ....solver.math.arrays import Array
from ....solver.package import ModalPackage
from ....solver.package.body.invariants import free_body_mass, rigid_motions
from ....solver.package.common.files import write_text

SUFFIX = ".bdf"
RANK = 1e-9  # of the motions of the interfaces by their coordinates


def write(package: ModalPackage, out: Path, source: Path) -> str:
    """Write GRID, SPOINT, DMIG KAAX and MAAX (large field, ten digits).

    Raises InputError if the modes do not move the interfaces independently.

    Parameters
    ----------
    package, out, source : see contract.py
    """
    K, M, points = superelement(package)
    n = len(package.interfaces)
    lines = [
        f"$ {printable(package.body)}: {n} interfaces, {points} scalar points; m, kg, s",
        "$ K2GG = KAAX and M2GG = MAAX in the case control section",
    ]
    for i, interface in enumerate(package.interfaces, 1):
        lines.append(f"$ GRID {i}: {printable(interface.name)}")
        x, y, z = (_real(value) for value in interface.position_B)
        lines += [f"GRID*   {i:16d}{'':16s}{x}{y}", f"*       {z}"]
    lines += [f"SPOINT,{n + 1 + k}" for k in range(points)]
    labels = [(1 + k // 6, 1 + k % 6) for k in range(6 * n)]
    labels += [(n + 1 + k, 0) for k in range(points)]
    for name, A in (("KAAX", K), ("MAAX", M)):
        lines += [f"DMIG    {name:8s}{0:8d}{6:8d}{2:8d}{0:8d}", *_columns(name, A, labels)]
    write_text(out, "\n".join(lines) + "\n", encoding="ascii")
    return f"{n} grid points, {points} scalar points"


def superelement(package: ModalPackage) -> tuple[Array, Array, int]:
    """Stiffness and mass in interface motions and scalar points, and the number of the latter."""
    m, n = package.n_mode, len(package.interfaces)
    A = np.zeros((6 * n, 6 + m))
    for i, interface in enumerate(package.interfaces):
        A[6 * i : 6 * i + 6, :6] = rigid_motions(interface.position_B[None])[0]
        A[6 * i : 6 * i + 6, 6:] = np.vstack([interface.phi_B, interface.psi_B])
    K = np.zeros((6 + m, 6 + m))
    K[6:, 6:] = package.stiffness
    M = free_body_mass(package)
    size = 1.0 / np.sqrt(np.diag(M))
    rank = int(np.linalg.matrix_rank(A * size, rtol=RANK))
    if rank < 6 * n:
        raise InputError(
            f"{package.body}: the modes move the {n} interfaces in {rank} of {6 * n} independent "
            'ways; expected static shapes (kind = "attachment") in all six directions of every '
            "interface but the one that carries the frame"
        )
    # Columns: unit motion of each interface of least mass norm, then motions that keep them still.
    scaled = A * size
    T = size[:, None] * np.hstack([np.linalg.pinv(scaled), scipy.linalg.null_space(scaled)])
    K, M = (T.T @ part @ T for part in (K, M))
    return (K + K.T) / 2.0, (M + M.T) / 2.0, 6 + m - 6 * n


def _columns(name: str, A: Array, labels: list[tuple[int, int]]) -> Iterator[str]:
    """The lower triangle, one large-field card per column."""
    for j, (node, direction) in enumerate(labels):
        yield f"DMIG*   {name:<16s}{node:16d}{direction:16d}"
        for (other, its), value in list(zip(labels, A[:, j], strict=True))[j:]:
            if value:
                yield f"*       {other:16d}{its:16d}{_real(value)}"


def _real(value: float) -> str:
    """Sixteen columns: as many digits as fit."""
    digits = 10 if value < 0 or abs(value) < 1e-99 else 11
    return f"{value:.{digits - 1}E}".rjust(16)
