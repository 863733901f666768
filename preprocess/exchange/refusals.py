"""What is wrong with the matrices of a body: each check raises InputError."""

import numpy as np
import scipy.sparse as sp
import scipy.sparse.csgraph as graphs

from ...solver.errors import InputError
from ...solver.math.arrays import Array
from ..parts import Part, own
from .free_body import DIRECTIONS, FreeBody

SYMMETRY = 1e-8  # |A - A'| relative to the largest entry
FREE = 1e-8  # force of a rigid motion relative to the sum of the absolute terms
TOTAL_MASS = 1e-3  # relative: given and found mass
DENSITY = (1e-2, 3e4)  # kg/m3 of the box around the body
THINNEST = 0.1  # least extent of that box relative to the largest: beams and flat shells


def check_free_body(body: FreeBody, total_mass: float | None) -> None:
    """Raise InputError for matrices that are not those of one free body in SI units.

    Parameters
    ----------
    total_mass : the mass that the user knows [kg]
    """
    _labels(body)
    _matrices(body)
    _translations(body)
    _one_part(body)
    _rigid_motions(body)
    mass = masses(body)
    _mass(body, mass, total_mass)
    _density(body, float(mass.mean()))


def masses(body: FreeBody) -> Array:
    """Mass against translation along x, y and z, (3,) [kg]."""
    R = body.rigid_motions()[:, :3]
    return np.einsum("ni,ni->i", R, body.M @ R)


def _labels(body: FreeBody) -> None:
    ids, count = np.unique(body.node_ids, return_counts=True)
    if (count > 1).any():
        label = ids[count > 1][0]
        raise InputError(f"{body.where}: node {label} occurs twice; expected unique labels")
    pairs = 6 * body.dof_node + body.dof_direction
    _, first, count = np.unique(pairs, return_index=True, return_counts=True)
    if (count > 1).any():
        raise InputError(
            f"{body.where}: {int((count - 1).sum())} of {len(pairs)} degrees of freedom repeat the "
            f"label of another, first {body.labels(first[count > 1][0])}; expected one row for "
            "each label (CalculiX expands shells to solids and repeats their labels: import "
            'shells by their modes, from = "calculix-modes")'
        )


def _matrices(body: FreeBody) -> None:
    for name, A in (("stiffness", own(body.K)), ("mass", own(body.M))):
        if not np.isfinite(A.data).all():
            raise InputError(f"{body.where}: {name}: expected finite numbers, found nan or inf")
        largest = float(np.abs(A.data).max(initial=0.0))
        if largest == 0.0:
            raise InputError(f"{body.where}: {name}: all entries are zero")
        above, below = (
            float(np.abs(part.data).max(initial=0.0)) for part in (sp.triu(A, 1), sp.tril(A, -1))
        )
        if (above == 0.0) != (below == 0.0):
            side = "lower" if above == 0.0 else "upper"
            raise InputError(
                f"{body.where}: {name}: holds its {side} triangle only; expected the whole "
                "matrix (a Matrix Market file of one triangle needs `symmetric` in its first line)"
            )
        gap = float(np.abs((A - A.T).data).max(initial=0.0))
        if gap > SYMMETRY * largest:
            raise InputError(
                f"{body.where}: {name}: expected a symmetric matrix; it differs from its "
                f"transpose by {gap / largest:.3g} of its largest entry"
            )


def _translations(body: FreeBody) -> None:
    """Every node with a dof has all translations: dofs that were held are not left out."""
    present = np.zeros((len(body.nodes), 6), dtype=bool)
    present[body.dof_node, body.dof_direction] = True
    partly = present.any(axis=1) & ~present[:, :3].all(axis=1)
    if partly.any():
        row = int(np.argmax(partly))
        missing = [DIRECTIONS[k] for k in range(3) if not present[row, k]]
        raise InputError(
            f"{body.where}: node {body.node_ids[row]} has no degree of freedom along "
            f"{', '.join(missing)} ({int(partly.sum())} such nodes): the matrices are of a held "
            "body, whose held mass is lost; export those of the free body, without supports"
        )


def _one_part(body: FreeBody) -> None:
    together = sp.csr_matrix(
        (np.ones(len(body.dof_node)), (body.dof_node, np.arange(len(body.dof_node)))),
        shape=(len(body.nodes), len(body.dof_node)),
    )
    pattern = together @ (abs(body.K) + abs(body.M)) @ together.T
    pattern = pattern.whole() if isinstance(pattern, Part) else pattern
    _, part = graphs.connected_components(pattern, directed=False)
    used = np.unique(body.dof_node)
    parts, first = np.unique(part[used], return_index=True)
    if len(parts) > 1:
        named = ", ".join(str(body.node_ids[used[row]]) for row in sorted(first)[:4])
        raise InputError(
            f"{body.where}: {len(parts)} unconnected parts with {6 * len(parts)} rigid motions, "
            f"with the nodes {named}; expected one body with six"
        )


def _rigid_motions(body: FreeBody) -> None:
    R = body.rigid_motions()
    centre = body.nodes.mean(axis=0)
    size = float(np.linalg.norm(np.ptp(body.nodes, axis=0))) or 1.0
    for k in range(3):  # about the centre, and of the size of a translation
        R[:, 3 + k] -= R[:, :3] @ np.cross(np.eye(3)[k], centre)
    R[:, 3:] /= size
    force = np.abs(body.K @ R).max(axis=0)
    terms = (abs(body.K) @ np.abs(R)).max(axis=0)
    ratio = force / terms
    held = [k for k in range(6) if not ratio[k] <= FREE]
    if not held:
        return
    names = ", ".join(
        f"{'rotation' if k > 2 else 'translation'} {DIRECTIONS[k % 3]} ({ratio[k]:.2g})"
        for k in held
    )
    reason = (
        "the coordinates do not belong to the matrices: compare the order of the nodes, their "
        "labels, the unit of length and the axes of the nodes"
        if min(held) > 2
        else "the body is held: remove supports, springs to the ground and constraints; or nodes "
        "have axes of their own, or the numbers too few digits"
    )
    raise InputError(
        f"{body.where}: expected six rigid motions without force, |K R| / |K||R| <= {FREE:.0e}; "
        f"a force opposes {names}: {reason}"
    )


def _mass(body: FreeBody, mass: Array, given: float | None) -> None:
    total = float(mass.mean())
    shown = ", ".join(f"{value:.9g}" for value in mass)
    if not mass.min() > 0.0 or np.ptp(mass) > 1e-6 * total:
        raise InputError(
            f"{body.where}: mass along x, y, z is {shown} kg; expected one positive value"
        )
    if given is not None and abs(total - given) > TOTAL_MASS * given:
        raise InputError(
            f"{body.where}: total_mass = {given:.9g} kg, but the mass matrix has {total:.9g} kg "
            f"({total / given - 1:+.2%}): compare units, density, and elements without mass"
        )


def _density(body: FreeBody, mass: float) -> None:
    extent = np.ptp(body.nodes, axis=0)
    box = float(np.prod(np.maximum(extent, THINNEST * extent.max())))
    density = mass / box if box else np.inf
    if not DENSITY[0] <= density <= DENSITY[1]:
        shown = " x ".join(f"{value:.4g}" for value in extent)
        raise InputError(
            f"{body.where}: {mass:.4g} kg in a box of {shown} m is {density:.3g} kg/m3, expected "
            f"{DENSITY[0]:g} to {DENSITY[1]:g}: check `units`"
        )
