"""Flat triangles on a warped surface: do their rotations lock for the thickness?

The normal of a flat triangle is tilted against that of the surface at its corners. Where the
surface turns twistwise, a rotation of bending has a component along the normal of the triangle,
which its membrane resists as a rotation in its plane. The work of the membranes on these components
alone, over that of the whole shell, is about the relative error of the strain energy by this
locking (docs/shells-accuracy.md). Quadrilaterals do not lock.
"""

from collections.abc import Sequence

import numpy as np

from ...solver.math.arrays import Array
from .membranes import MEMBRANES
from .problem import ShellProblem
from .stiffness import cell_stiffness, membrane_stiffness
from .triangles import Triangles

LOCKED = 0.1  # work on tilted rotations over twice the strain energy that is warned about
FOLD = 0.98  # cosine between the normals of a cell and of a node below which there is a fold
TILTED = 1e-3  # sine of the tilt above which a cell counts
AT_A_TIME = 4096  # cells whose matrices are in memory together
ROTATIONS = slice(2, None, 3)  # about the normal, among the membrane's degrees of freedom


def warped_warnings(problem: ShellProblem, u: Array, names: Sequence[str]) -> list[dict[str, str]]:
    """A warning if triangles lock in one of the states u (n_dof, m), which `names` describe."""
    share = tilted_work(problem, u)
    bad = np.flatnonzero(share > LOCKED)
    if not bad.size:
        return []
    worst = bad[np.argmax(share[bad])]
    more = "" if bad.size == 1 else f" and {bad.size - 1} more"
    text = (
        f"{names[worst]}{more}: triangles are too large for the thickness of this warped surface, "
        "and the shell is too stiff: rotations of bending that are tilted into their planes take "
        f"{100.0 * share[worst]:.2g} % of the strain energy, which is about its error; use "
        'element = "quadrilateral" in [mesh], or smaller cells'
    )
    return [{"code": "shell-triangles-warped", "message": text}]


def tilted_work(problem: ShellProblem, u: Array) -> Array:
    """Work of the membranes on rotations that triangles see because of their tilt.

    In a cell with normal e3, corner i has the tilt t_i = e3 - (e3.n_i) n_i, n_i the normal of the
    surface at the node. The work is that of the moments about e3, of the whole membrane, on the
    rotations t_i.th_i, th_i those of the corner less their mean over the cell. Corners at folds do
    not count.

    Parameters
    ----------
    u : (n_dof, m) states

    Returns
    -------
    (m,), over twice the strain energy; 0 for a state without strain energy
    """
    count = u.shape[1]
    work = np.zeros(count)
    membrane = MEMBRANES[problem.choice.membrane]
    if not count or not membrane.rotations:
        return work
    normal, smooth = _normals(problem)
    nodal = u.reshape(-1, 6, count)
    for region in problem.regions:
        geometry = region.geometry
        if not isinstance(geometry, Triangles):
            continue
        stiffness = cell_stiffness(region.stiffness)[0]
        e3, n = geometry.A_GE[:, :, 2], normal[region.nodes]
        tilt = e3[:, None] - np.einsum("ci,cki->ck", e3, n)[..., None] * n
        tilt *= smooth[region.nodes][..., None]
        cells = np.flatnonzero(np.linalg.norm(tilt, axis=2).max(axis=1) > TILTED)
        for first in range(0, len(cells), AT_A_TIME):
            some = cells[first : first + AT_A_TIME]
            t = geometry[some]
            A = stiffness[some] if len(stiffness) > 1 else stiffness
            strains = membrane.strains(t, A, problem.choice.beta0)
            corners = nodal[region.nodes[some]]
            turned = corners[:, :, 3:] - corners[:, :, 3:].mean(axis=1, keepdims=True)
            about = np.einsum("cki,ckim->ckm", tilt[some], turned)
            force = membrane_stiffness(t, A, strains) @ _in_plane(t, corners)
            work += np.einsum("ckm,ckm->m", about, force[:, ROTATIONS])
    energy = np.einsum("nm,nm->m", u, problem.K @ u)
    return np.divide(work, energy, out=np.zeros(count), where=energy > 0.0)


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
