"""Ply stresses of beams and shells point by point, as references for the search of strength/."""

import numpy as np

from plymotion.solver.math.arrays import Array
from plymotion.solver.package import ModalPackage
from plymotion.solver.package.shell.shell_schema import ShellFile
from plymotion.solver.strength.strength_summary import BodyStrength
from plymotion.solver.strength.weakest_plies import body_search, resultants, unit_stress_M


def body_strength(package: ModalPackage, t: Array, q: Array) -> BodyStrength | None:
    """What the search finds in times t (t,) with coordinates q (t, m); None without strengths."""
    search = body_search(package)
    if search is None:
        return None
    search.take(t, q)
    return search.found()


def beam_ply_stress(package: ModalPackage, station: int, q: Array) -> Array:
    """Stress of all points of a station's section in ply axes, (t, p, 6) [Pa], at q (t, m)."""
    assert package.recovery is not None
    section = package.sections[package.recovery.section[station]].recovery
    assert section is not None
    F = resultants(package, q)[station]
    return np.einsum("pij,jt->tpi", unit_stress_M(section), F, optimize=True)


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


def shell_file_ply_stress(shell: ShellFile, resultants_E: Array) -> list[Array]:
    """Stress of every ply in its own axes, region by region, [(l, cells, k, 3, 6)] [Pa].

    Parameters
    ----------
    resultants_E : (l, c, 8) of load cases or modes

    Returns
    -------
    For each region: load case, cell of the region (in the order of the mesh), ply from the bottom
    up, bottom, middle and top of it, and 11, 22, 33, 23, 13, 12.
    """
    out = []
    for row, laminate in enumerate(shell.mesh.laminate):
        operator = shell.laminates[laminate].stress_M
        some = resultants_E[:, shell.mesh.region == row]
        stress = some @ operator.reshape(-1, 8).T
        out.append(stress.reshape(*some.shape[:2], *operator.shape[:3]))
    return out
