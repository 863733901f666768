"""Cells of a section with their stiffness, for codes that have no meshes of composite walls."""

import subprocess
import sys
from pathlib import Path

import numpy as np
from scenes import BUILD, ROOT

from plymotion.solver.package.section.section_file import read_section


def cells(name: str, file: Path) -> str:
    """Path of an `.npz` with corners (n, 2), cells (c, 4) and C (c, 6, 6) in section axes.

    Made by `plymotion section` on its coarse mesh, once. "" where cells are curved, not
    quadrilaterals, or have several plies.
    """
    made = BUILD / "cells" / f"{name}.npz"
    if not made.exists():
        out = (BUILD / "cells" / name).absolute()
        command = [sys.executable, "-m", "plymotion", "section", str(file), "--out", str(out)]
        command += ["--no-estimate", "--no-figures", "--quiet", "--force"]
        subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)
        section = read_section(next(out.glob("**/*.vtkhdf")))
        mesh, points = section.mesh, section.recovery
        rows = np.split(mesh.connectivity, mesh.offsets[1:-1])
        corners = np.array([row[:4] for row in rows])
        several = [len(set(points.ply[points.cell == k])) > 1 for k in range(len(rows))]
        mids = [mesh.nodes[r[4:8]] - 0.5 * (mesh.nodes[r[:4]] + mesh.nodes[np.roll(r[:4], -1)])
                for r in rows if len(r) >= 8]  # fmt: skip
        usable = set(mesh.cell_types) <= {9, 23, 28} and not any(several)
        if not usable or np.abs(mids).max(initial=0.0) > 1e-9 * np.ptp(mesh.nodes):
            np.savez(made, usable=False)
        else:
            first = [int(np.argmax(points.cell == k)) for k in range(len(rows))]
            C = [turned(points.A_BM[j]) @ points.C_M[points.ply[j]] @ turned(points.A_BM[j]).T
                 for j in first]  # fmt: skip
            used, numbers = np.unique(corners, return_inverse=True)
            np.savez(made, usable=True, nodes=mesh.nodes[used],
                     cells=numbers.reshape(corners.shape), C=np.array(C))  # fmt: skip
    with np.load(made) as found:
        return str(made.absolute()) if found["usable"] else ""


def turned(A: np.ndarray) -> np.ndarray:
    """Stress in axes of the ply to axes of the section, (6, 6), in the order 11 22 33 23 13 12."""
    pairs = [(0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1)]
    T = np.zeros((6, 6))
    for i, (a, b) in enumerate(pairs):
        for j, (c, d) in enumerate(pairs):
            T[i, j] = A[a, c] * A[b, d] + (A[a, d] * A[b, c] if c != d else 0.0)
    return T
