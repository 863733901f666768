"""Eigenmodes of a body under its reference condition: solution, names, signs, selection.

An eigensolver does not determine the sign of a mode and, for equal frequencies, the basis of
their space. Both are fixed here, so that repeated builds give the same package:

- modes of equal frequency (a square section has equal bending modes in any plane) are rotated so
  that their motion separates into the body's directions, bending-xy first, then bending-xz,
  torsion, axial; - nodes are searched from the farthest from the reference node towards it. The
  first node that moves by at least half of the largest motion moves in the positive direction (of
  the component that names the mode: y, z, rotation x, x).
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import scipy.linalg

from ...solver.math.arrays import Array, IntArray
from .reference import Condition, EigenSolver, ModeError

# Component (of ux uy uz rx ry rz) that determines name and sign of the mode.
COMPONENTS = {"bending-xy": 1, "bending-xz": 2, "torsion": 3, "axial": 0}
KINDS = tuple(COMPONENTS)

COINCIDENT = 1e-8  # relative distance below which eigenvalues are treated as equal
TIE = 1e-6  # shares of mass or work closer than this count as equal: the first kind or load is used

# columns (n_dof, m) -> (4, m, m): modal mass split over KINDS
Participation = Callable[[Array], Array]


def clusters(values: Array) -> list[tuple[int, int]]:
    """Ranges (first, end) of equal values in ascending eigenvalues."""
    if not len(values):
        return []
    breaks = np.nonzero(np.diff(values) > COINCIDENT * np.abs(values[1:]))[0] + 1
    return list(pairwise([0, *breaks.tolist(), len(values)]))


def separating_rotation(values: Array, P: Array) -> Array:
    """Rotation (m, m) of modes that aligns those of equal frequency with the body's directions.

    Parameters
    ----------
    values : (m,) ascending eigenvalues
    P : (4, m, m) modal mass by KINDS
    """
    rank = np.arange(len(KINDS), 0, -1.0)  # distinct weights separate all kinds in one step
    turn = np.eye(len(values))
    for first, end in clusters(values):
        if end - first > 1:
            part = slice(first, end)
            weighted = np.einsum("k,kij->ij", rank, P[:, part, part])
            turn[part, part] = scipy.linalg.eigh(weighted)[1][:, ::-1]
    return turn


def shares_of(P: Array) -> Array:
    """Share (m, 4) of each mode's mass that moves in each of KINDS, from the split (4, m, m)."""
    return np.asarray(np.einsum("kii->ik", P) / np.einsum("kii->i", P)[:, None])


def kind_of(share: Array) -> str:
    """Kind of the largest share."""
    return KINDS[int(np.argmax(share >= share.max() - TIE))]


def signs(columns: Array, kinds: list[str], far_to_near: IntArray) -> Array:
    """+1 or -1 for every column, by the rule at the top of this file.

    Parameters
    ----------
    columns : modes (n_dof, k), six components of each node
    kinds : name of each mode
    far_to_near : nodes from the farthest to the reference node
    """
    values = np.ones(len(kinds))
    for i, kind in enumerate(kinds):
        motion = columns[COMPONENTS[kind] :: 6, i][far_to_near]
        first = int(np.argmax(np.abs(motion) >= 0.5 * np.abs(motion).max()))
        values[i] = 1.0 if motion[first] > 0.0 else -1.0
    return values


SPARE = 4


@dataclass(frozen=True)
class ModeRequest:
    """How many modes of which kind: "lowest" or one of KINDS."""

    kind: str
    count: int


@dataclass(frozen=True)
class Eigenmodes:
    """Selected eigenmodes in ascending frequency; see `Modes` for the fields."""

    values: Array
    columns_B: Array
    labels: tuple[str, ...]
    shares: Array
    others: tuple[Array, Array] | None = None  # values and columns found, but not selected


def eigenmodes(
    condition: Condition,
    requests: Sequence[ModeRequest],
    participation: Participation,
    far_to_near: IntArray,
    solver: EigenSolver,
    spare: int = SPARE,
) -> Eigenmodes:
    """Eigenmodes selected by kind.

    Parameters
    ----------
    condition : reference condition of the body
    requests : kinds and counts; each takes the lowest modes of its kind that
        earlier requests have not taken
    participation : splits modal mass over KINDS, see `Participation`
    far_to_near : (n,) node numbers, from the farthest from the reference node
    solver : e.g. `fenicsx.eigenpairs`
    spare : additional modes that the first attempt computes, because modes of other kinds lie
        between the requested ones

    Raises
    ------
    ModeError : the model has fewer modes of a kind than requested.
    """
    n_dof = condition.K.shape[0]
    wanted = sum(request.count for request in requests)
    if wanted == 0:
        return Eigenmodes(np.zeros(0), np.zeros((n_dof, 0)), (), np.zeros((0, len(KINDS))))
    n_mode = min(wanted + spare, condition.n_finite)
    while True:
        values, X = condition.lowest(n_mode, solver)
        complete = n_mode == condition.n_finite
        usable = n_mode if complete else clusters(values)[-1][0]
        # A Krylov method may return only one of two modes of equal frequency: count them.
        ready = complete or (
            usable > 0
            and condition.count_below(0.5 * values[usable - 1 : usable + 1].sum()) == usable
        )
        P = participation(X[:, :usable])
        rotation = separating_rotation(values[:usable], P)
        values = np.einsum("ij,i,ij->j", rotation, values[:usable], rotation)
        X = X[:, :usable] @ rotation
        shares = shares_of(np.einsum("ai,kab,bj->kij", rotation, P, rotation, optimize=True))
        names = [kind_of(share) for share in shares]
        chosen, missing = _choose(names, requests)
        if ready and missing is None:
            break
        if complete and missing is not None:
            census = ", ".join(f"{names.count(kind)} {kind}" for kind in KINDS)
            raise ModeError(
                f"modes: {requests[missing].count} of kind {requests[missing].kind!r} requested; "
                f"with {condition.n_free} free dofs this mesh has {census}: request fewer or "
                "increase `elements`"
            )
        n_mode = min(2 * n_mode, condition.n_finite)
    columns = X[:, chosen]
    columns = columns * signs(columns, [names[i] for i in chosen], far_to_near)
    labels = tuple(f"{names[i]} {names[: i + 1].count(names[i])}" for i in chosen)
    left = np.setdiff1d(np.arange(len(values)), chosen)
    others = values[left], X[:, left]
    return Eigenmodes(values[chosen], columns, labels, shares[chosen], others)


def _choose(names: list[str], requests: Sequence[ModeRequest]) -> tuple[list[int], int | None]:
    """Numbers of the selected modes, ascending, and the first request that is not met."""
    taken: set[int] = set()
    for number, request in enumerate(requests):
        fits = [
            i for i, name in enumerate(names) if i not in taken and request.kind in ("lowest", name)
        ]
        taken.update(fits[: request.count])
        if len(fits) < request.count:
            return sorted(taken), number
    return sorted(taken), None
