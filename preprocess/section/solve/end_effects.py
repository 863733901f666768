"""Compliance that a beam lacks at an end that is held: Saint-Venant's end effects.

The stresses of the beam let its sections warp. At an end that is held as a rigid face they cannot:
a field that decays along the beam cancels the warping there. Twice its energy is what the beam has
less of compliance. The field is u = X a(x1) + R phi(x1), with displacements X of the section, and
strains phi of the beam such that its stresses have no resultants. X has the warping W of the six
unit resultants and, step by step, what decaying fields have beside it:

    E X_1 = (H' - H) W,    E X_2 = M W + (H' - H) X_1

with E = <G_h, C G_h>, H = <G_h, C G_l>, M = <G_l, C G_l>. The field with the least energy in this
basis has no more compliance than the three-dimensional one. An I section in torsion loses
sqrt(E I_w / (G J)) of its length, as Vlasov's theory says.
"""

import numpy as np
from scipy.linalg import LinAlgError, solve_continuous_are

from ....solver.math.arrays import Array
from ..errors import SectionError
from .recovery import unit_displacements
from .timoshenko import SectionStiffness
from .warping import WarpingSolver, motions_of_beam

STEPS = 2
DEPENDENT = 1e-10  # energy of a combination of columns that is left out, of the largest


def end_compliance(result: SectionStiffness, solver: WarpingSolver, C: Array) -> Array | None:
    """Return S (6, 6): under resultants F6, a beam held at an end has F6' S F6 / 2 less energy.

    Units are those of the inverse of a stiffness times a length: [m/N, 1/N, 1/(N m)].

    Parameters
    ----------
    result : stiffness and warping of a prismatic beam
    solver : with the factors of the same material, in the unknowns of `result`
    C : (c, 1 or q, 6, 6) stiffness of the points, section axes [Pa]

    Returns
    -------
    None if the equations are too ill-conditioned for it.
    """
    size = float(np.sqrt(result.space.area))
    try:
        E, H, M = _decaying_fields(result, solver, C)
    except SectionError:
        return None
    for columns in range(len(E), 0, -6):  # very thin walls: fewer steps, better conditioned
        few = np.s_[:columns, :columns]
        try:
            S = _least_energy(E[few], H[few], M[few], size)[:6, :6]
        except (LinAlgError, ValueError):  # of the ordering of eigenvalues
            continue
        if np.isfinite(S).all():
            return S
    return None


def _decaying_fields(
    result: SectionStiffness, solver: WarpingSolver, C: Array
) -> tuple[Array, Array, Array]:
    """E, H and M (m, m) of the columns of X, those of W first, without resultants."""
    space = result.space
    rigid = space.strain_along_beam(motions_of_beam(space))
    of_rigid = C @ rigid
    A = space.work(of_rigid, rigid)

    def stress(strain: Array) -> Array:
        """Stress of a strain and of the beam's strain that cancels the resultants."""
        return np.asarray(C @ (strain - rigid @ np.linalg.solve(A, space.work(of_rigid, strain))))

    def product(W: Array) -> Array:
        return space.load_in_section(C @ space.strain_in_section(W))

    blocks = [unit_displacements(space, result)[0]]
    loads: list[tuple[Array, Array, Array]] = []  # of E, H, M: one block of columns each
    for step in range(STEPS + 1):
        within = stress(space.strain_in_section(blocks[step]))
        of_E, forth = space.load_in_section(within), space.load_along_beam(within)
        along = stress(space.strain_along_beam(blocks[step]))
        of_H, of_M = space.load_in_section(along), space.load_along_beam(along)
        loads.append((of_E, of_H, of_M))
        if step < STEPS:
            load = forth - of_H + (loads[step - 1][2] if step else 0.0)
            size = float(np.linalg.norm(forth) + np.linalg.norm(of_H))
            blocks.append(solver.solve(load, size, product))
    X = np.hstack(blocks)
    E, H, M = (X.T @ np.hstack(parts) for parts in zip(*loads, strict=True))
    return E, H, M


def _least_energy(E: Array, H: Array, M: Array, size: float) -> Array:
    """P (m, m): a' P a / 2 is the least energy of a field that begins with X a and decays.

    The energy per length is (y' E y + 2 y' H z + z' M z) / 2 with z = dy/dx1: a regulator with the
    control z. `size` is a length of the section, by which slopes are scaled.
    """
    values, vectors = np.linalg.eigh(0.5 * (E + E.T) + 0.5 * (M + M.T) / size**2)
    kept = values > DEPENDENT * values[-1]
    roots = np.sqrt(values[kept])
    basis, back = vectors[:, kept] / roots, roots[:, None] * vectors[:, kept].T
    E, H, M = (basis.T @ matrix @ basis for matrix in (E, H / size, M / size**2))
    none, unit = np.zeros_like(E), np.eye(len(E))
    P = solve_continuous_are(none, unit, 0.5 * (E + E.T), 0.5 * (M + M.T), s=H)
    P = size * back.T @ P @ back
    return np.asarray(0.5 * (P + P.T))
