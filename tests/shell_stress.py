"""Stresses of a shell body cell by cell, to compare the search of strength/ with."""

import numpy as np

from plymotion.solver.package import ModalPackage


def shell_resultants(package: ModalPackage, row: int, q: np.ndarray) -> np.ndarray:
    """Resultants N, M, T of one cell in its axes, (8, t) [N/m, N], at coordinates q (t, m)."""
    assert package.cell_resultants is not None
    return np.asarray(package.cell_resultants.resultants_E[row] @ q.T)


def shell_ply_stress(package: ModalPackage, row: int, q: np.ndarray) -> np.ndarray:
    """Stress in the plies of one cell in ply axes, (t, k, 3, 6) [Pa].

    Ply from the bottom up; bottom, middle and top of it; 11, 22, 33, 23, 13, 12.
    """
    assert package.cell_resultants is not None
    laminate = package.laminates[package.cell_resultants.laminate[row]]
    return np.moveaxis(laminate.stress_M @ shell_resultants(package, row, q), -1, 0)
