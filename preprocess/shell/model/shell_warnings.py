"""Checks of a shell: coded warnings and errors for problems that the analysis would not show."""

from collections.abc import Callable, Sequence

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components

from ....solver.errors import coded, few
from ....solver.math.arrays import Array, IntArray
from ....solver.package.common.cells import NONE, corner_counts
from ....solver.package.shell import elements
from ...mesh_input import coincident
from ..elements.drilling import DRILLINGS
from ..elements.membranes import MEMBRANES
from ..elements.pairs import Choice
from ..elements.plates import PLATES, shear_ratio
from ..shell_cells import DOFS, ShellError, ShellMesh
from .freedom import Freedom
from .links import Link
from .regions import Region, cell_axes

Warnings = list[dict[str, str]]
Progress = Callable[[str], None]

SLIVER = 0.05  # area over the sum of squared sides; 1 where they are equal
COINCIDENT = 1e-7  # relative to the size of the mesh: two nodes at the same position
FLAT = 1e-6  # sine of the angle between normals of a flat part
KINK = 0.9  # cosine between neighbouring normals below which a wall ends
UNPAIRED = 0.25  # share of triangles that stay, against the request; of gmsh's below a fifth
ACROSS = 4  # cells across a wall that constant-strain triangles need for bending in its plane


def _at(place: Array) -> str:
    return "({:.4g}, {:.4g}, {:.4g})".format(*place)


def model_warnings(
    mesh: ShellMesh, regions: Sequence[Region], links: Sequence[Link], choice: Choice
) -> Warnings:
    """All warnings about mesh and elements.

    Parameters
    ----------
    mesh : of the shell
    regions : all cells, with their laminates
    links : reference points with their groups
    choice : the elements
    """
    shared = Sides(mesh, regions)
    warnings = [*_slivers(mesh), *_unmerged(mesh, links), *_turned(mesh, shared), *_unpaired(mesh)]
    if MEMBRANES[choice.membrane].stiff_in_plane:
        warnings += _narrow_walls(mesh, shared, choice.membrane)
    limit = PLATES[choice.plate].shear_ratio_limit
    if limit is not None:
        warnings += _sides_too_short(mesh, regions, choice.plate, limit)
    return warnings


class Sides:
    """Sides shared by exactly two cells: `cells` (s, 2), their `ends` (s, 2), and whether the side
    has the same direction in both cells, which means that their normals disagree."""

    def __init__(self, mesh: ShellMesh, regions: Sequence[Region]) -> None:
        self.normals_G = cell_axes(mesh, regions)[:, :, 2]
        edges = mesh.edges
        turned = np.einsum("ci,ci->c", self.normals_G, mesh.area_vectors_G) < 0.0
        forward = (edges.ends[:, 0] < edges.ends[:, 1]) ^ turned[edges.owner]
        a, b = edges.shared.T
        self.cells = edges.owner[edges.shared]
        self.ends = edges.ends[a]
        self.same = forward[a] == forward[b]
        self.boundary = edges.nodes[edges.count != 2]  # of one cell, or of three and more


def _slivers(mesh: ShellMesh) -> Warnings:
    squares = (np.diff(mesh.points_G[mesh.edges.ends], axis=1)[:, 0] ** 2).sum(axis=1)
    area = np.linalg.norm(mesh.area_vectors_G, axis=1)
    best = np.where(corner_counts(mesh.cells) == 3, 4.0 * np.sqrt(3.0), 4.0)
    quality = best * area / np.bincount(mesh.edges.owner, weights=squares)
    bad = np.flatnonzero(quality < SLIVER)
    if not bad.size:
        return []
    worst = bad[np.argmin(quality[bad])]
    return coded(
        "sliver",
        f"{bad.size} of {len(area)} cells are slivers, the worst at "
        f"{_at(mesh.centres_G[worst])} has a shape of {quality[worst]:.2g} (equal sides: 1): "
        "results near them are inaccurate; use a more uniform mesh there",
    )


def _unmerged(mesh: ShellMesh, links: Sequence[Link]) -> Warnings:
    pairs = coincident(mesh.points_G, COINCIDENT * mesh.size)
    if len(pairs):
        return coded(
            "nodes-not-merged",
            f"{len(pairs)} pairs of nodes have the same position, one at "
            f"{_at(mesh.points_G[pairs[0, 0]])}: parts that touch there are not connected. "
            "In gmsh, use BooleanFragments, or Coherence",
        )
    n_part = Freedom(mesh, links).parts().max() + 1
    if n_part > 1:
        return coded("several-parts", f"the shell is in {n_part} parts that are not connected")
    hinges = _hinges(mesh, links)
    if not hinges.size:
        return []
    return coded(
        "several-parts",
        f"parts of the shell touch in {hinges.size} single nodes, one at "
        f"{_at(mesh.points_G[hinges[0]])}, which hardly hold a part against turning: results "
        "depend on the mesh. Parts must share sides of cells, or be joined by a link",
    )


def _hinges(mesh: ShellMesh, links: Sequence[Link]) -> IntArray:
    """Nodes of cells that neither common sides nor links connect."""
    edges, own = mesh.edges, len(mesh.cells) + len(mesh.edges.count)
    pairs = [(edges.owner, len(mesh.cells) + edges.number)]
    for row, link in enumerate(links):
        cells = edges.owner[np.isin(edges.ends, link.group.nodes).any(axis=1)]
        pairs.append((cells, np.full(cells.size, own + row)))
    a, b = map(np.concatenate, zip(*pairs, strict=True))
    graph = sp.csr_matrix((np.ones(a.size), (a, b)), shape=(own + len(links),) * 2)
    part = connected_components(graph, directed=False)[1][edges.owner]
    lowest, highest = np.full(mesh.n_node, len(part)), np.full(mesh.n_node, -1)
    for end in edges.ends.T:
        np.minimum.at(lowest, end, part)
        np.maximum.at(highest, end, part)
    return np.flatnonzero(lowest < highest)


def _turned(mesh: ShellMesh, shared: Sides) -> Warnings:
    wrong = np.flatnonzero(shared.same)
    if not wrong.size:
        return []
    place = mesh.points_G[shared.ends[wrong[0]]].mean(axis=0)
    return coded(
        "normals-disagree",
        f"the normals e3 of neighbours disagree along {wrong.size} sides, one at {_at(place)}: "
        "bottom and top of the lay-up, and the direction of pressures, are reversed there. Reverse "
        "the surface in gmsh, or set flip = true for its region",
    )


def _unpaired(mesh: ShellMesh) -> Warnings:
    left, of, reason = mesh.unpaired
    if left <= UNPAIRED * of:
        return []
    return coded(
        "triangles-not-paired",
        f'element = "quadrilateral": {left} of {of} triangles stay triangles, because {reason}; '
        "make the quadrilaterals in gmsh (Recombine Surface), or a mesh with angles of 37 to 143 "
        "deg between its lines",
    )


def _narrow_walls(mesh: ShellMesh, shared: Sides, membrane: str) -> Warnings:
    """Walls between folds or free edges with few constant-strain triangles across."""
    n_cell = len(mesh.cells)
    a, b = shared.cells.T
    smooth = np.abs(np.einsum("si,si->s", shared.normals_G[a], shared.normals_G[b])) > KINK
    graph = sp.csr_matrix((np.ones(smooth.sum()), (a[smooth], b[smooth])), shape=(n_cell, n_cell))
    n_wall, wall = connected_components(graph, directed=False)
    edge = np.zeros(mesh.n_node, dtype=bool)
    edge[shared.boundary] = True
    edge[shared.ends[~smooth]] = True
    # one cell across: all its corners on the edge; then one more node for every two cells
    depth = np.where(edge, 0, np.iinfo(np.int64).max)
    there = mesh.cells != NONE
    for layer in range(ACROSS // 2):
        near = ((depth[mesh.cells] == layer) & there).any(axis=1)
        nodes = mesh.cells[near]
        nodes = nodes[nodes != NONE]
        depth[nodes] = np.minimum(depth[nodes], layer + 1)
    deepest = np.zeros(n_wall, dtype=np.int64)
    np.maximum.at(deepest, wall, np.where(there, depth[mesh.cells], 0).max(axis=1))
    narrow = np.flatnonzero(deepest < ACROSS // 2)
    if not narrow.size:
        return []
    cell = int(np.flatnonzero(wall == narrow[0])[0])
    return coded(
        "cst-in-plane-bending",
        f"membrane = {membrane} with fewer than {ACROSS} cells across {narrow.size} walls, one at "
        f"{_at(mesh.centres_G[cell])}: constant-strain triangles are far "
        "too stiff in bending of a wall in its own plane (4.5 times and more at one cell); use "
        f"membrane = {elements.MEMBRANE}",
    )


def _sides_too_short(
    mesh: ShellMesh, regions: Sequence[Region], plate: str, limit: float
) -> Warnings:
    """Sides with a `shear_ratio` above the limit of the plate."""
    worst, place = 0.0, ""
    for region in regions:
        if region.nodes.shape[1] == 4:
            continue
        t, laminate = region.geometry, region.stiffness
        ratio = shear_ratio(laminate.D, laminate.Ds, np.moveaxis(t.tangent, 2, 0), t.length)
        cell = int(np.argmax(ratio.max(axis=1)))
        if ratio[cell].max() > worst:
            worst = float(ratio[cell].max())
            place = _at(mesh.centres_G[region.cells[cell]])
    if worst <= limit:
        return []
    return coded(
        "dst-thick",
        f"plate = {plate} with sides short for the thickness (12 D / (Ds L^2) = {worst:.2g} at "
        f"{place}, at most {limit:g} is safe): it does not converge there, and "
        f"refinement makes it worse; use plate = {elements.PLATE}",
    )


def drilling_motions(freedom: Freedom, regions: Sequence[Region], choice: Choice) -> list[Array]:
    """Zero-energy motions (n_dof,) of the drilling stiffness of the paper: in a flat part, all
    nodes rotate about the normal by the same angle without displacement.

    Parameters
    ----------
    freedom : degrees of freedom of the shell, and its supports
    regions : all cells
    choice : the elements
    """
    drilling = DRILLINGS.get(choice.drilling_form())
    if MEMBRANES[choice.membrane].rotations or drilling is None or not drilling.free_rotation:
        return []
    mesh = freedom.mesh
    normals = Sides(mesh, regions).normals_G
    parts = freedom.parts()
    of_cell = parts[mesh.cells[:, 0]]
    motions_kept = []
    for part in np.unique(of_cell):
        inside = of_cell == part
        normal = normals[inside][0]
        flat = bool(np.linalg.norm(np.cross(normals[inside], normal), axis=1).max() < FLAT)
        nodes = np.flatnonzero(parts == part)
        held = freedom.fixed[np.isin(freedom.fixed // DOFS, nodes)]
        turned = held[held % DOFS >= 3]
        stopped = bool(np.any(np.abs(normal[turned % DOFS - 3]) > FLAT))
        linked = any(
            link.kind == "rigid" and parts[link.group.nodes[0]] == part for link in freedom.links
        )
        if flat and not stopped and not linked:
            motion = np.zeros((freedom.n_dof // DOFS, DOFS))
            motion[nodes, 3:] = normal
            motions_kept.append(motion.ravel())
    return motions_kept


def drilling_warning(count: int) -> Warnings:
    """Warning about motions that `drilling_motions` found."""
    return coded(
        "drilling-fictitious-flat",
        f"{count} flat part{'s keep' if count > 1 else ' keeps'} a zero-energy motion, rotation of "
        'all nodes about the normal, with drilling = "fictitious": a spurious frequency of 0 '
        'Hz. Use "tie", membrane = "opt", or fix the rotation at one node',
    )


def check_supported(freedom: Freedom, motions: Sequence[Array], drilling: Sequence[Array]) -> None:
    """Refuse load cases of a shell with free motions.

    Parameters
    ----------
    freedom : degrees of freedom of the shell
    motions : (n_dof,) free rigid motions
    drilling : (n_dof,) those of the drilling stiffness

    Raises
    ------
    ShellError
        There are such motions; the message lists them.
    """
    if motions:
        listed = few((freedom.describe(motion) for motion in motions), "; ")
        part = " of its parts" if freedom.parts().max() > 0 else ""
        raise ShellError(
            f"supports: {len(motions)} rigid motions{part} are free: {listed}. Load cases need "
            "supports that prevent all of them"
        )
    if drilling:
        raise ShellError(f"supports: {drilling_warning(len(drilling))[0]['message']}")


def zero_energy_warnings(n_zero: int, n_rigid: int) -> Warnings:
    """Warning if there are more modes without strain energy than free rigid motions."""
    if n_zero == n_rigid:
        return []
    return coded(
        "zero-energy-modes",
        f"{n_zero} modes have no strain energy, {n_rigid} rigid motions are free: the others are "
        "mechanisms of the elements, not vibrations",
    )
