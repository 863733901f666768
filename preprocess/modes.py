"""Modes of a body held at its reference node: solve, name, choose, make unique.

An eigensolver leaves open the sign of a mode and, where frequencies coincide,
the basis of their space. Both are fixed here, so that a package built twice is
the same package:

- modes whose frequencies coincide (a square section bends alike in any plane)
  are turned until their motion separates into the body's directions, bending-xy
  first, then bending-xz, torsion, axial;
- going from the node farthest from the reference node towards it, the first
  node that moves by at least half of the largest motion moves in the positive
  direction (of the component that names the mode: y, z, rotation x, x).
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
import scipy.linalg
import scipy.sparse as sp
import scipy.sparse.linalg as spla

from ..solver.package.schema import Array, IntArray

# Component (of ux uy uz rx ry rz) whose motion names and signs the mode.
COMPONENTS = {"bending-xy": 1, "bending-xz": 2, "torsion": 3, "axial": 0}
KINDS = tuple(COMPONENTS)
CHOICES = ("lowest", *KINDS)

COINCIDENT = 1e-8  # relative distance of eigenvalues that count as one
RESIDUAL = 1e-8  # of X'MX = I and X'KX = Lambda, scaled
TIE = 1e-6  # shares of modal mass closer than this are equal: the earlier kind wins

EigenSolver = Callable[[Any, Any, int], tuple[Array, Array]]
# columns (n_dof, m) -> (4, m, m): modal mass split over KINDS
Participation = Callable[[Array], Array]


class ModeError(Exception):
    """Modes that the model does not have, or that fail their checks."""


@dataclass(frozen=True)
class ModeRequest:
    """How many modes of which kind: one of CHOICES."""

    kind: str
    count: int


@dataclass(frozen=True)
class Modes:
    """Chosen modes, ascending in frequency.

    Attributes
    ----------
    values : (m,) eigenvalues, squared angular frequencies [rad2/s2]
    columns_B : (n_dof, m) nodal displacements and rotations, mass-normalised,
        zero at the held dofs [m, rad per unit modal coordinate]
    labels : m of e.g. "bending-xy 2": the second of its kind by frequency
    shares : (m, 4) share of the modal mass that moves in each of KINDS
    """

    values: Array
    columns_B: Array
    labels: tuple[str, ...]
    shares: Array


def constrained_modes(
    K: Any,
    M: Any,
    held: IntArray,
    requests: Sequence[ModeRequest],
    participation: Participation,
    far_to_near: IntArray,
    solver: EigenSolver,
) -> Modes:
    """Modes with the dofs `held` at rest, chosen by kind.

    Parameters
    ----------
    K, M : (n_dof, n_dof) sparse stiffness and mass of the free body, six dofs a node
    held : dofs that do not move; they are eliminated
    requests : kinds and counts; each takes the lowest modes of its kind that
        the requests before it have left
    participation : splits modal mass over KINDS, see `Participation`
    far_to_near : (n,) node numbers, from the farthest from the reference node
    solver : e.g. `fenicsx.eigenpairs`

    Raises
    ------
    ModeError : the model has fewer modes of a kind than asked for, or the
        modes are not orthonormal to RESIDUAL.
    """
    n_dof = K.shape[0]
    free = np.setdiff1d(np.arange(n_dof), held)
    wanted = sum(request.count for request in requests)
    if wanted == 0:
        return Modes(np.zeros(0), np.zeros((n_dof, 0)), (), np.zeros((0, len(KINDS))))
    K_free, M_free = (sp.csr_matrix(A)[free][:, free] for A in (K, M))
    # a dof without mass has no mode of its own
    n_finite = int(np.count_nonzero(np.abs(M_free).sum(axis=1)))

    def split(X_free: Array) -> Array:
        columns = np.zeros((n_dof, X_free.shape[1]))
        columns[free] = X_free
        return participation(columns)

    n_mode = min(wanted + 4, n_finite)
    while True:
        values, X = solver(K_free, M_free, n_mode)
        complete = n_mode == n_finite
        usable = n_mode if complete else _clusters(values)[-1][0]
        found = complete or (
            usable > 0 and _count_below(K_free, M_free, values[usable - 1 : usable + 1]) == usable
        )
        values, X, P = _separated(values[:usable], X[:, :usable], split)
        shares = np.einsum("kii->ik", P) / np.einsum("kii->i", P)[:, None]
        names = [_kind(share) for share in shares]
        chosen, missing = _choose(names, requests)
        if found and missing is None:
            break
        if complete and missing is not None:
            raise ModeError(_too_few(requests[missing], names, K_free.shape[0]))
        n_mode = min(2 * n_mode, n_finite)

    columns = np.zeros((n_dof, len(chosen)))
    columns[free] = X[:, chosen]
    kinds = [names[i] for i in chosen]
    columns *= _signs(columns, kinds, far_to_near)
    _check(K, M, values[chosen], columns)
    labels = tuple(f"{names[i]} {names[: i + 1].count(names[i])}" for i in chosen)
    return Modes(values[chosen], columns, labels, shares[chosen])


def _clusters(values: Array) -> list[tuple[int, int]]:
    """Ranges (first, end) of eigenvalues that coincide."""
    breaks = np.nonzero(np.diff(values) > COINCIDENT * np.abs(values[1:]))[0] + 1
    edges = [0, *breaks.tolist(), len(values)]
    return list(pairwise(edges))


def _count_below(K: Any, M: Any, neighbours: Array) -> int:
    """Number of eigenvalues below the middle of two neighbours (Sylvester's law of inertia).

    A Krylov method may return one of two coinciding modes only; the signs of
    the pivots of K - sigma M tell how many there are.
    """
    shifted = (K - 0.5 * neighbours.sum() * M).tocsc()
    try:
        factors = spla.splu(
            shifted,
            permc_spec="MMD_AT_PLUS_A",
            diag_pivot_thresh=0.0,
            options={"SymmetricMode": True},
        )
        if np.array_equal(factors.perm_r, factors.perm_c):
            return int(np.count_nonzero(factors.U.diagonal() < 0.0))
    except RuntimeError:
        pass  # a pivot is exactly zero: rows would have to be exchanged
    _, D, _ = scipy.linalg.ldl(shifted.toarray())
    return int(np.count_nonzero(scipy.linalg.eigvalsh(D) < 0.0))


def _separated(
    values: Array, X: Array, split: Callable[[Array], Array]
) -> tuple[Array, Array, Array]:
    """Turn coinciding modes into the body's directions; also returns the split modal mass."""
    P = split(X)
    rank = np.arange(len(KINDS), 0, -1.0)  # distinct weights tell all kinds apart at once
    turn = np.eye(len(values))
    for first, end in _clusters(values) if len(values) else []:
        if end - first > 1:
            part = slice(first, end)
            weighted = np.einsum("k,kij->ij", rank, P[:, part, part])
            turn[part, part] = scipy.linalg.eigh(weighted)[1][:, ::-1]
    values = np.einsum("ij,i,ij->j", turn, values, turn)
    return values, X @ turn, np.einsum("ai,kab,bj->kij", turn, P, turn, optimize=True)


def _kind(share: Array) -> str:
    return KINDS[int(np.argmax(share >= share.max() - TIE))]


def _choose(names: list[str], requests: Sequence[ModeRequest]) -> tuple[list[int], int | None]:
    """Numbers of the chosen modes, ascending, and the first request that is not met."""
    taken: set[int] = set()
    for number, request in enumerate(requests):
        fits = [
            i for i, name in enumerate(names) if i not in taken and request.kind in ("lowest", name)
        ]
        taken.update(fits[: request.count])
        if len(fits) < request.count:
            return sorted(taken), number
    return sorted(taken), None


def _too_few(request: ModeRequest, names: list[str], n_free: int) -> str:
    census = ", ".join(f"{names.count(kind)} {kind}" for kind in KINDS)
    return (
        f"modes: {request.count} of kind {request.kind!r} asked for; with {n_free} free dofs this "
        f"mesh has {census}: ask for fewer or give `elements` a larger value"
    )


def _signs(columns: Array, kinds: list[str], far_to_near: IntArray) -> Array:
    """+1 or -1 for every column, by the rule at the top of this file."""
    signs = np.ones(len(kinds))
    for i, kind in enumerate(kinds):
        motion = columns[COMPONENTS[kind] :: 6, i][far_to_near]
        first = int(np.argmax(np.abs(motion) >= 0.5 * np.abs(motion).max()))
        signs[i] = 1.0 if motion[first] > 0.0 else -1.0
    return signs


def _check(K: Any, M: Any, values: Array, X: Array) -> None:
    """Compare X'MX with I and X'KX with Lambda, scaled by the frequencies."""
    scale = np.sqrt(np.outer(values, values))
    mass = float(np.abs(X.T @ (M @ X) - np.eye(len(values))).max())
    stiffness = float(np.abs((X.T @ (K @ X) - np.diag(values)) / scale).max())
    if not max(mass, stiffness) < RESIDUAL:
        raise ModeError(
            f"modes are not orthonormal: X'MX - I is {mass:.2e}, X'KX - Lambda (scaled) "
            f"{stiffness:.2e}, expected below {RESIDUAL:.0e}"
        )
