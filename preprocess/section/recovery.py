"""What a section file holds: strains of the six resultants, mesh and plies, effects of held ends.

End effects are the compliance that a beam lacks at an end that is held (Saint-Venant). The
stresses of the beam let its sections warp. At an end that is held as a rigid face they cannot:
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

from ...solver.math.arrays import Array
from ...solver.package.common.recovery_schema import SectionRecovery
from ...solver.package.section.section_schema import SectionMeshData
from .helical import CentralSolutions, TwistedStrains
from .section_specification import SectionError
from .space.layers import Layup
from .space.section_cells import FULL, CellMesh, IntArray
from .space.section_mesh import SectionMesh
from .space.space import SectionSpace
from .timoshenko import CLASSICAL, SHEAR, SectionStiffness, beam_strain_fields
from .warping import WarpingSolver, motions_of_beam

Result = SectionStiffness | CentralSolutions  # of a prismatic, of a twisted or curved beam


def unit_displacements(space: SectionSpace, result: SectionStiffness) -> tuple[Array, Array]:
    """Warping w and w' + Psi e of the six unit resultants, each (n_dof, 6).

    Strain of point = G_h w + G_l (w' + Psi e). With the shear forces F_s constant along the
    beam, e' = T F_s, e = A^-1 (F_c - (B - B') e'), w = V0 e + V1 F_s and w' = V0 e'.

    Paper: Eq. (37), Eq. (38), in reverse.
    """
    F = np.eye(6)
    F_c, F_s = F[CLASSICAL], F[SHEAR]
    change = result.T @ F_s
    e = np.linalg.solve(result.A, F_c - (result.B - result.B.T) @ change)
    w = result.V0 @ e + result.V1 @ F_s
    return w, result.V0 @ change + beam_strain_fields(space) @ e


def unit_strains(space: SectionSpace, result: Result) -> Array:
    """Strains of the six unit resultants at the points of a space, (c, q, 6, 6), own cells."""
    if isinstance(result, CentralSolutions):
        at = TwistedStrains(space, result.strains.k)
        return at.strain_in_section(result.W) + at.strain_along_beam(result.Q)
    w, along = unit_displacements(space, result)
    return space.strain_in_section(w) + space.strain_along_beam(along)


def unit_warping(space: SectionSpace, result: Result) -> Array:
    """Displacements (n_dof, 6) of the six unit resultants without rigid motion of the section."""
    if not isinstance(result, CentralSolutions):
        return unit_displacements(space, result)[0]
    rigid = result.strains.Z
    load = space.load(space.at_points(rigid))
    return np.asarray(result.W - rigid @ np.linalg.solve(rigid.T @ load, load.T @ result.W))


def section_recovery(
    space: SectionSpace, lay: Layup, strain_B: Array, materials: dict[str, dict[str, object]]
) -> SectionRecovery:
    """Data for the recovery of ply stresses.

    Parameters
    ----------
    space : its points become the points of recovery
    lay : plies at these points
    strain_B : `unit_strains` at these points
    materials : constants by name, as described
    """
    c, q = space.weights.shape
    A_BM = np.broadcast_to(lay.A_BM, (c, q, 3, 3))
    # work is the same in both axes: stress_B = T stress_M, so strain_M = T' strain_B
    strain_M = np.swapaxes(lay.T, -1, -2) @ strain_B
    real = space.weights.ravel() > 0.0  # not those that fill up cells with fewer points
    return SectionRecovery(
        points=space.points.reshape(-1, 2)[real],
        weights=space.weights.ravel()[real],
        cell=np.repeat(np.arange(c), q)[real],
        ply=lay.ply.ravel()[real],
        A_BM=A_BM.reshape(-1, 3, 3)[real],
        strain_M=strain_M.reshape(-1, 6, 6)[real],
        C_M=lay.stiffness_M,
        plies=lay.plies,
        materials=materials,
    )


# VTK's number for a cell with these of our nodes, by kind. A cell with others is written with all.
# Our order of corners, middles and centre is VTK's.
VTK_CELLS = ({3: 5, 6: 22}, {4: 9, 8: 23, 9: 28})


def mesh_data(mesh: SectionMesh, space: SectionSpace, lay: Layup) -> SectionMeshData:
    """The mesh with region, ply and directions of every cell.

    Parameters
    ----------
    mesh : of the section
    space : points of its cells; that in the middle stands for the cell
    lay : plies and directions at these points
    """
    cells = mesh.cells
    c = cells.n_cell
    points, tables, types = numbered(cells)
    connectivity = [table[table >= 0] for table in tables]
    every, middle = np.arange(c), middles(space)
    A_BM = lay.A_BM[every, middle if lay.A_BM.shape[1] > 1 else 0]
    return SectionMeshData(
        nodes=points,
        connectivity=np.concatenate(connectivity),
        offsets=np.cumsum([0, *map(len, connectivity)]).astype(np.int64),
        cell_types=types,
        region=cells.region.astype(np.int64),
        regions=cells.regions,
        ply=lay.ply[every, middle],
        layer_direction=lay.y2[every, middle],
        fibre=A_BM[:, :, 0],
    )


def middles(space: SectionSpace) -> IntArray:
    """The point of each cell that represents it: the nearest to its centre, (c,)."""
    areas = space.weights[..., None]
    centre = (areas * space.points).sum(axis=1, keepdims=True) / areas.sum(axis=1, keepdims=True)
    away = np.linalg.norm(space.points - centre, axis=-1)
    return np.asarray(np.argmin(np.where(space.weights > 0.0, away, np.inf), axis=1))


def nodal_displacements(space: SectionSpace, W: Array) -> Array:
    """Displacement columns (n_dof, m) at the nodes of `mesh_data`, (m, n, 3)."""
    points, tables, _ = numbered(space.mesh)
    out = np.zeros((len(points), 3, W.shape[1]))
    for (kind, rows), values in zip(
        space.mesh.of_kinds, space.at_corners_and_middles(W), strict=True
    ):
        nodes = tables[rows, : FULL[kind]]
        out[nodes[nodes >= 0]] = values[nodes >= 0]
    return np.ascontiguousarray(np.moveaxis(out, 2, 0))


def numbered(mesh: CellMesh) -> tuple[Array, IntArray, IntArray]:
    """Positions of the nodes in use, nodes of each cell (c, 9) with -1 for none, VTK's types."""
    used, compact = np.unique(mesh.nodes, return_inverse=True)
    absent = int(used[0] < 0)
    tables = compact.reshape(mesh.nodes.shape).astype(np.int64) - absent
    points = [mesh.points[used[absent:]]]
    types = np.zeros(mesh.n_cell, dtype=np.int64)
    total = len(points[0])
    for (kind, rows), shape in zip(mesh.of_kinds, mesh.shapes, strict=True):
        full = FULL[kind]
        there = tables[rows] >= 0
        count = there.sum(axis=1)
        types[rows] = VTK_CELLS[kind][full]
        regular = np.zeros(len(rows), dtype=bool)
        for n, vtk in VTK_CELLS[kind].items():
            these = (count == n) & there[:, :n].all(axis=1)
            types[rows[these]] = vtk
            regular |= these
        cell, node = np.nonzero((tables[rows][:, :full] < 0) & ~regular[:, None])
        tables[rows[cell], node] = total + np.arange(len(cell))
        points.append(shape[cell, node])
        total += len(cell)
    return np.concatenate(points), tables, types


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
