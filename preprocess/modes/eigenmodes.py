"""Eigenmodes of a body under its reference condition: solution, names, selection."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...solver.math.arrays import Array, IntArray
from .kinds import KINDS, Participation, clusters, kind_of, separating_rotation, shares_of, signs
from .reference import Condition, EigenSolver, ModeError

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
        found = complete or (
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
        if found and missing is None:
            break
        if complete and missing is not None:
            raise ModeError(_too_few(requests[missing], names, condition.n_free))
        n_mode = min(2 * n_mode, condition.n_finite)
    columns = X[:, chosen]
    columns = columns * signs(columns, [names[i] for i in chosen], far_to_near)
    labels = tuple(f"{names[i]} {names[: i + 1].count(names[i])}" for i in chosen)
    return Eigenmodes(values[chosen], columns, labels, shares[chosen])


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


def _too_few(request: ModeRequest, names: list[str], n_free: int) -> str:
    census = ", ".join(f"{names.count(kind)} {kind}" for kind in KINDS)
    return (
        f"modes: {request.count} of kind {request.kind!r} requested; with {n_free} free dofs this "
        f"mesh has {census}: request fewer or increase `elements`"
    )
