"""Flat triangles on a warped surface: do their rotations lock for the thickness?

The normal of a flat triangle is tilted against that of the surface at its corners. Where the
surface turns twistwise, a rotation of bending has a component along the normal of the triangle,
which its membrane resists as a rotation in its plane. Two energies tell that triangles lock, both
over the strain energy of a state:

- that of these components alone. It falls with the fourth power of the cell size. It is far above
  1 where triangles lock, and below 1 where displacements are right to 5 %, but at folds;
- that of the membranes beyond their mean strain. It is what locking costs in fact, and what
  bending of a wall in its plane costs; at folds it is small.

Quadrilaterals do not lock (docs/shells-accuracy.md).
"""

from collections.abc import Sequence

import numpy as np

from ...solver.math.arrays import Array
from .membranes import MEMBRANES
from .problem import ShellProblem
from .stiffness import cell_stiffness, membrane_stiffness
from .triangles import Triangles

LOCKED = 2.0  # energy of tilted rotations over the strain energy that is warned about,
PAID = 0.02  # if membranes have this share of the strain energy beyond their mean strain
FOLD = 0.98  # cosine between the normals of a cell and of a node below which there is a fold
TILTED = 1e-3  # sine of the tilt above which a cell counts
AT_A_TIME = 4096  # cells whose matrices are in memory together
ROTATIONS = slice(2, None, 3)  # about the normal, among the membrane's degrees of freedom


def warped_warnings(problem: ShellProblem, u: Array, names: Sequence[str]) -> list[dict[str, str]]:
    """A warning if triangles lock in one of the states u (n_dof, m), which `names` describe."""
    tilted, paid = tilted_energies(problem, u)
    bad = np.flatnonzero((tilted > LOCKED) & (paid > PAID))
    if not bad.size:
        return []
    worst = bad[np.argmax(tilted[bad])]
    more = "" if bad.size == 1 else f" and {bad.size - 1} more"
    text = (
        f"{names[worst]}{more}: triangles are too large for the thickness of this warped surface; "
        "the shell is far too stiff (rotations that are tilted into their planes would take "
        f"{tilted[worst]:.2g} of the strain energy, at most {LOCKED:g} is safe); use "
        'element = "quadrilateral" in [mesh], or smaller cells'
    )
    return [{"code": "shell-triangles-warped", "message": text}]


def tilted_energies(problem: ShellProblem, u: Array) -> tuple[Array, Array]:
    """Energies of tilted triangles, over the strain energy.

    In a cell with normal e3, corner i has the tilt t_i = e3 - (e3.n_i) n_i, n_i the normal of the
    surface at the node. With the rotations th_i of its corners less their mean, the first energy
    is that of the rotations t_i.th_i about the normal. Corners at folds do not count.

    Parameters
    ----------
    u : (n_dof, m) states

    Returns
    -------
    (m,) of the tilted rotations alone, and (m,) of the membranes beyond their mean strain, both 0
    for a state without strain energy
    """
    count = u.shape[1]
    found = np.zeros((2, count))
    membrane = MEMBRANES[problem.choice.membrane]
    if not count or not membrane.rotations:
        return found[0], found[1]
    normal, smooth = _normals(problem)
    nodal = u.reshape(-1, 6, count)
    for region in problem.regions:
        geometry = region.geometry
        if not isinstance(geometry, Triangles):
            continue
        stiffness = cell_stiffness(region.stiffness)[0]
        e3 = geometry.A_GE[:, :, 2]
        n = normal[region.nodes]
        tilt = e3[:, None] - np.einsum("ci,cki->ck", e3, n)[..., None] * n
        tilt *= smooth[region.nodes][..., None]
        cells = np.flatnonzero(np.linalg.norm(tilt, axis=2).max(axis=1) > TILTED)
        for first in range(0, len(cells), AT_A_TIME):
            some = cells[first : first + AT_A_TIME]
            t = geometry[some]
            A = stiffness[some] if len(stiffness) > 1 else stiffness
            strains = membrane.strains(t, A, problem.choice.beta0)
            K = membrane_stiffness(t, A, strains)
            corners = nodal[region.nodes[some]]
            turned = corners[:, :, 3:] - corners[:, :, 3:].mean(axis=1, keepdims=True)
            about = np.einsum("cki,ckim->ckm", tilt[some], turned)
            found[0] += np.einsum("ckm,ckm->m", about, K[:, ROTATIONS, ROTATIONS] @ about)
            own = _in_plane(t, corners)
            mean = strains.mean_strain @ own
            found[1] += np.einsum("cim,cim->m", own, K @ own)
            found[1] -= np.einsum("c,cim,cim->m", t.area, mean, A @ mean)
    energy = np.einsum("nm,nm->m", u, problem.K @ u)
    shares = np.divide(found, energy, out=np.zeros_like(found), where=energy > 0.0)
    return shares[0], shares[1]


def _in_plane(t: Triangles, corners: Array) -> Array:
    """The membrane's degrees of freedom (c, 9, m) of the corners (c, 3, 6, m) in G."""
    out = np.empty((len(t), 9, corners.shape[3]))
    out[:, 0::3] = np.einsum("ci,ckim->ckm", t.A_GE[:, :, 0], corners[:, :, :3])
    out[:, 1::3] = np.einsum("ci,ckim->ckm", t.A_GE[:, :, 1], corners[:, :, :3])
    out[:, ROTATIONS] = np.einsum("ci,ckim->ckm", t.A_GE[:, :, 2], corners[:, :, 3:])
    return out


def _normals(problem: ShellProblem) -> tuple[Array, Array]:
    """Unit normals of the surface at the nodes (n, 3), and 0 at folds, 1 elsewhere (n,)."""
    total = np.zeros((problem.mesh.n_node, 3))
    for region in problem.regions:
        e3 = region.geometry.A_GE[:, :, 2] * region.geometry.area[:, None]
        np.add.at(total, region.nodes, e3[:, None])
    length = np.linalg.norm(total, axis=1, keepdims=True)
    normal = np.divide(total, length, out=np.zeros_like(total), where=length > 0.0)
    smooth = np.ones(len(normal))
    for region in problem.regions:
        along = np.einsum("ci,cki->ck", region.geometry.A_GE[:, :, 2], normal[region.nodes])
        smooth[region.nodes[along < FOLD]] = 0.0
    return normal, smooth
