"""All modes of a reduced body, orthonormal in mass and stiffness (Paper: Eq. (15)).

They are eigenmodes and static modes: shapes of loads that the kept eigenmodes cannot represent.

A load at an interface deforms the body in the shape K^-1 f. Eigenmodes converge slowly to it (for a
force with 1/k^3, for a moment with 1/k in the number k of bending modes). With the shape itself
added, the static response is exact for any number of eigenmodes. The parts along the eigenmodes are
removed from each shape. The remainders are combined to the natural modes of the space that they
add. Then all modes are orthonormal, and modal mass and stiffness are diagonal. The frequencies of
static modes are those of the reduced model. They are high and are not frequencies of the body.

Orthogonality is computed in energy as x' f with the load f = K x of a shape. This avoids the
differences of large numbers in x' K x.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.linalg

from ...solver.errors import coded, few
from ...solver.math.arrays import Array, IntArray
from ...solver.package.specification import DIRECTIONS
from .eigenmodes import (
    SPARE,
    TIE,
    Eigenmodes,
    ModeRequest,
    Participation,
    eigenmodes,
    separating_rotation,
    shares_of,
)
from .reference import Condition, EigenSolver, ModeError, StaticShapes

DEPENDENT = 1e-6  # energy norm of the new part of a shape, relative to that of the whole shape
GRADED = 1e-6  # smaller inverse eigenvalues, relative to the largest, are computed in the next pass
CARRIED = 1e-12  # of a load on dofs that move, relative to the whole load: round-off of links
MASSLESS = 1e-14  # inverse eigenvalues below this, relative to the largest of all, are round-off


@dataclass(frozen=True)
class StaticLoad:
    """A load of a requested static shape.

    Attributes
    ----------
    label : e.g. "attachment mid y"
    force_B : (n_dof,) forces and moments on the nodes, body axes [N, N m]
    acceleration_B : (n_dof,) a of the distributed load M a [m/s2, rad/s2]
    """

    label: str
    force_B: Array
    acceleration_B: Array


def inertia_loads(rigid: Array) -> list[StaticLoad]:
    """Loads M a of the six rigid accelerations a = `rigid` (n_dof, 6), in order of DIRECTIONS."""
    zero = np.zeros(len(rigid))
    return [
        StaticLoad(f"inertia {direction}", zero, column)
        for direction, column in zip(DIRECTIONS, rigid.T, strict=True)
    ]


def accelerations(places_B: Array, direction: IntArray) -> Array:
    """Fields A [x; 1] of a rigid body that accelerates and spins, on dofs, (n_dof, 12).

    By rows of A (3, 4). `places_B` (n_dof, 3) and `direction` (n_dof,) are those of the dofs;
    rotations are half of the curl, those of a spin, as in the motions that `checks.statics` takes
    from the invariants.
    """
    moves = direction < 3
    fields = np.zeros((len(direction), 3, 4))
    curl = np.moveaxis(np.cross(np.eye(3), np.eye(3)[:, None]), 2, 0)
    fields[~moves, :, :3] = 0.5 * curl[direction[~moves] - 3]
    fields[moves, direction[moves]] = np.column_stack([places_B, np.ones(len(moves))])[moves]
    return fields.reshape(-1, 12)


@dataclass(frozen=True)
class StaticModes:
    """Modes of the space that the static shapes add, in ascending frequency; see `Modes`."""

    values: Array
    columns_B: Array
    accelerations_B: Array
    combination: Array  # (n_eigen + n_load, k) of the eigenmodes and static shapes
    labels: tuple[str, ...]
    warnings: tuple[dict[str, str], ...]


@dataclass(frozen=True)
class _Shapes:
    """Columns x with their accelerations a and loads K x; all (n_dof, k).

    `of` (r, k) are the coefficients of the given columns in them.
    """

    x: Array
    a: Array
    load: Array
    of: Array

    def __matmul__(self, T: Array) -> "_Shapes":
        return _Shapes(self.x @ T, self.a @ T, self.load @ T, self.of @ T)

    def __sub__(self, other: "_Shapes") -> "_Shapes":
        return _Shapes(*(getattr(self, n) - getattr(other, n) for n in _PARTS))

    def energy(self) -> Array:
        """Twice the strain energy of each column, (k,)."""
        return np.asarray(np.einsum("nk,nk->k", self.x, self.load))

    @staticmethod
    def joined(parts: Sequence["_Shapes"]) -> "_Shapes":
        return _Shapes(*(np.hstack([getattr(p, n) for p in parts]) for n in _PARTS))


_PARTS = ("x", "a", "load", "of")


def _static_modes(
    condition: Condition,
    kept: Eigenmodes,
    loads: Sequence[StaticLoad],
    static: StaticShapes,
    participation: Participation,
) -> StaticModes:
    """Modes that the static shapes `static` of `loads` add to the eigenmodes `kept`.

    There is a warning instead of a mode for a load that the reference condition carries, for a
    shape that is a combination of eigenmodes and earlier shapes, and for a shape that moves no
    mass.
    """
    n_dof = condition.K.shape[0]
    empty = np.zeros((n_dof, 0))
    if not loads:
        return StaticModes(np.zeros(0), empty, empty, np.zeros((len(kept.values), 0)), (), ())
    unit, count = np.eye(len(kept.values) + len(loads)), len(kept.values)
    x, a, load = (part[:, : len(loads)] for part in static)
    moving = np.abs(load[condition.free]).max(axis=0) > CARRIED * np.abs(load).max(axis=0)
    x = np.where(moving, x, 0.0)  # of a load that the frame carries there is round-off alone
    shapes = _Shapes(x, a, load, unit[:, count:])
    inertia = kept.columns_B * kept.values
    eigen = _Shapes(kept.columns_B, inertia, condition.M @ inertia, unit[:, :count])
    remainders, independent = _independent(eigen @ np.diag(1.0 / np.sqrt(kept.values)), shapes)
    values, modes = _diagonalised(condition.M, eigen, remainders, participation)
    applied = shapes.load[:, independent] / np.sqrt(shapes.energy()[independent])
    work = applied.T @ (modes.x / np.sqrt(values))
    owner = _owners(work)
    sign = np.where(work[owner, np.arange(len(owner))] < 0.0, -1.0, 1.0)
    named = [independent[i] for i in owner]
    return StaticModes(
        values,
        modes.x * sign,
        modes.a * sign,
        modes.of * sign,
        tuple(loads[k].label for k in named),
        _warnings([load.label for k, load in enumerate(loads) if k not in named]),
    )


def _independent(basis: _Shapes, shapes: _Shapes) -> tuple[_Shapes, list[int]]:
    """New part of each shape, of unit energy, energy-orthogonal to a basis of unit energy.

    Also returns the numbers of the shapes that have a new part.
    """
    energy = shapes.energy()
    kept: list[int] = []
    for k in np.flatnonzero(energy > 0.0):
        one = shapes @ (np.eye(len(energy))[:, [k]] / np.sqrt(energy[k]))
        for _ in range(2):  # two passes are enough: the second removes the round-off of the first
            one = one - basis @ (basis.load.T @ one.x)
        norm = float(np.sqrt(one.energy()[0].clip(min=0.0)))
        if norm > DEPENDENT:
            basis = _Shapes.joined([basis, one @ np.array([[1.0 / norm]])])
            kept.append(int(k))
    first = basis.x.shape[1] - len(kept)
    return basis @ np.eye(basis.x.shape[1])[:, first:], kept


def _diagonalised(
    M: Any, eigen: _Shapes, remainders: _Shapes, participation: Participation
) -> tuple[Array, _Shapes]:
    """Natural modes of the space of `remainders`, of unit modal mass, in ascending frequency.

    Inverse eigenvalues far below the largest one are affected by round-off. Therefore the softest
    modes are computed first, then those of the remainder. Shapes that move no mass have no mode.
    """
    groups, largest = [eigen], 0.0
    while remainders.x.shape[1]:
        inverse, V = (
            part[..., ::-1] for part in scipy.linalg.eigh(remainders.x.T @ (M @ remainders.x))
        )
        largest = max(largest, inverse[0])
        if inverse[0] <= MASSLESS * largest:
            break
        count = np.count_nonzero(inverse > GRADED * inverse[0])
        groups.append(remainders @ (V[:, :count] / np.sqrt(inverse[:count])))
        remainders = remainders @ V[:, count:]
    modes = _Shapes.joined(groups)
    # Gram-Schmidt in mass from soft to stiff: removing soft parts hardly changes a stiff mode's
    # energy.
    factor = np.linalg.cholesky(modes.x.T @ (M @ modes.x))
    modes = modes @ np.linalg.inv(factor).T[:, eigen.x.shape[1] :]
    modes = modes @ separating_rotation(modes.energy(), participation(modes.x))
    return modes.energy(), modes


def _owners(work: Array) -> IntArray:
    """Load that determines name and sign of each mode, (k,): the load that does most work on it.

    `work` (l, k): rows loads, columns modes. If loads do equal work (the two ends of a free
    beam), they are assigned in order.
    """
    from scipy.optimize import linear_sum_assignment  # takes as long to load as all the rest

    order = np.outer(np.arange(work.shape[0]), np.arange(work.shape[1]))
    claim = work**2 + TIE * order / max(order.size, 1)
    load, mode = linear_sum_assignment(claim, maximize=True)
    return np.asarray(load[np.argsort(mode)], dtype=np.int64)


def _warnings(dropped: list[str]) -> tuple[dict[str, str], ...]:
    if not dropped:
        return ()
    message = (
        f"no mode for {few(dropped)}: the reference condition carries such a load, or its "
        "shape is a combination of earlier modes, or it moves no mass"
    )
    return tuple(coded("static-modes-dependent", message))


LOADS = ("force_B", "acceleration_B")  # of StaticLoad
RESIDUAL = 1e-8  # of X'MX = I and X'KX = Lambda, scaled
STATIC_RESIDUAL = 1e-6  # of X'KX with static modes: they are small differences of large shapes


@dataclass(frozen=True)
class Modes:
    """Modes of a body: eigenmodes in ascending frequency, then static modes in ascending frequency.

    Attributes
    ----------
    values : (m,) squared angular frequencies [rad2/s2]
    columns_B : (n_dof, m) nodal displacements and rotations, mass-normalised,
        relative to the frame [m, rad per unit modal coordinate]
    accelerations_B : (n_dof, m) field a of each mode's distributed load M a: eigenvalue times
        column of an eigenmode, without nodal forces [m/s2, rad/s2]
    kinds : m of "fixed_normal" (eigenmode) and "attachment" (static)
    labels : m of e.g. "bending-xy 2" (the second of its kind by frequency), "attachment mid y"
    shares : (m, 4) share of the modal mass that moves in each of KINDS
    compliance : (l, l) of the unit loads that it was asked for, of the whole body
    others : values and columns of eigenmodes that were found, but not selected
    static : static shapes of the loads, then of the unit loads
    combination : (n_eigen + n_load, n_static) of eigenmodes and static shapes in the static modes
    warnings : coded messages about requested modes
    """

    values: Array
    columns_B: Array
    accelerations_B: Array
    kinds: tuple[str, ...]
    labels: tuple[str, ...]
    shares: Array
    compliance: Array | None = None
    warnings: tuple[dict[str, str], ...] = ()
    others: tuple[Array, Array] | None = None
    static: StaticShapes | None = None
    combination: Array | None = None

    def of_package(self, damping_ratio: float) -> dict[str, Any]:
        """Fields of a `ModalPackage` that follow from the modes and the damping ratio of each."""
        frequencies = np.sqrt(self.values)
        damping = np.diag(2.0 * damping_ratio * frequencies)
        modal = {"mass": np.eye(len(frequencies)), "stiffness": np.diag(self.values)}
        fields = {"mode_kinds": self.kinds, "frequencies": frequencies, "damping": damping}
        return {**fields, **modal, "compliance": self.compliance}


def reduced_modes(
    condition: Condition,
    requests: Sequence[ModeRequest],
    loads: Sequence[StaticLoad],
    participation: Participation,
    far_to_near: IntArray,
    solver: EigenSolver,
    spare: int = SPARE,
    unit_loads: Array | None = None,
) -> Modes:
    """Eigenmodes selected by kind, and static modes of loads.

    Parameters
    ----------
    condition : reference condition of the body
    requests, participation, far_to_near, solver, spare : see `eigenmodes`
    loads : each adds its static shape, see `_static_modes`
    unit_loads : see `completed`

    Raises
    ------
    ModeError : the model has fewer modes of a kind than requested, or the
        modes are not orthonormal to RESIDUAL.
    """
    kept = eigenmodes(condition, requests, participation, far_to_near, solver, spare)
    return completed(condition, kept, loads, participation, unit_loads)


def completed(
    condition: Condition,
    kept: Eigenmodes,
    loads: Sequence[StaticLoad],
    participation: Participation,
    unit_loads: Array | None = None,
) -> Modes:
    """The eigenmodes `kept`, and the static modes that `loads` add to them.

    Parameters
    ----------
    condition : reference condition of the body
    kept : eigenmodes
    loads : each adds its static shape
    participation : splits the modal mass of columns over the kinds of motion (eigenmodes.py)
    unit_loads : (n_dof, l) nodal forces and moments that give the compliance of the whole body.
        In a mean axis its inertia balances them, whatever carries the loads of static shapes:
        reactions would do work on modes that the single load does not.

    Raises
    ------
    ModeError
        The modes are not orthonormal to RESIDUAL.
    """
    n_dof, count = condition.K.shape[0], len(loads)
    unit = np.zeros((n_dof, 0)) if unit_loads is None else unit_loads
    requested = [np.array([getattr(a, n) for a in loads]).reshape(count, n_dof).T for n in LOADS]
    static = StaticShapes(*np.zeros((3, n_dof, 0)))
    if count or unit.shape[1]:
        balancing = condition.relief(unit)
        requested = [np.hstack([requested[0], unit]), np.hstack([requested[1], balancing])]
        static = condition.static(*requested)
    C = static.columns[:, count:].T @ static.loads[:, count:]
    added = _static_modes(condition, kept, loads, static, participation)
    n_eigen, n_static = len(kept.values), len(added.values)
    modes = Modes(
        np.concatenate([kept.values, added.values]),
        np.hstack([kept.columns_B, added.columns_B]),
        np.hstack([kept.columns_B * kept.values, added.accelerations_B]),
        ("fixed_normal",) * n_eigen + ("attachment",) * n_static,
        kept.labels + added.labels,
        np.vstack([kept.shares, shares_of(participation(added.columns_B))]),
        None if unit_loads is None else 0.5 * (C + C.T),
        added.warnings,
        kept.others,
        static,
        added.combination,
    )
    _check(condition, modes)
    return modes


def _check(condition: Condition, modes: Modes) -> None:
    """Compare X'MX with I and X'KX with Lambda, scaled by the frequencies.

    X'KX may have what its products round: in a thin shell the membranes are 1e8 times as stiff as
    bending.
    """
    X, values = modes.columns_B, modes.values
    if not len(values):
        return
    static = np.array([kind == "attachment" for kind in modes.kinds])
    allowed = np.where(static[:, None] | static, STATIC_RESIDUAL, RESIDUAL)
    scale = np.sqrt(np.outer(values, values))
    products = np.abs(X).T @ (abs(condition.K) @ np.abs(X)) / scale
    allowed = np.maximum(allowed, np.finfo(np.float64).eps * products)
    mass = float(np.abs(X.T @ (condition.M @ X) - np.eye(len(values))).max())
    stiffness = np.abs((X.T @ (condition.K @ X) - np.diag(values)) / scale)
    if not (mass < RESIDUAL and (stiffness < allowed).all()):
        spread = f"{scale.max() / scale.min():.1e}"
        raise ModeError(
            f"modes are not orthonormal: X'MX - I is {mass:.2e}, X'KX - Lambda (scaled) "
            f"{stiffness.max():.2e}, expected below {RESIDUAL:.0e} and {allowed.min():.0e} "
            f"({STATIC_RESIDUAL:.0e} of static modes); the highest has {spread} times "
            "the eigenvalue of the lowest: are all sizes in m? Otherwise ask for fewer modes"
        )


def pairs(m: int) -> tuple[IntArray, IntArray]:
    """Modes of each pair i <= j."""
    return np.triu_indices(m)


def square(values: Array, m: int) -> Array:
    """Values (a, pairs, ...) as symmetric tables (a, m, m, ...)."""
    i, j = pairs(m)
    out = np.empty((len(values), m, m, *values.shape[2:]))
    out[:, i, j] = out[:, j, i] = values
    return out


def turned(turn: Array, arms: Array) -> Array:
    """(a_i x (a_j x d) + a_j x (a_i x d))/2 of points of a rigid interface, (k, 3, pairs) [m].

    Parameters
    ----------
    turn : (3, m) rotation a of the interface in the modes [rad]
    arms : (k, 3) d, from its reference point to the points [m]
    """
    i, j = pairs(turn.shape[1])
    one, other, d = turn.T[i], turn.T[j], arms[:, None]
    moved = 0.5 * (np.cross(one, np.cross(other, d)) + np.cross(other, np.cross(one, d)))
    return np.swapaxes(moved, 1, 2)
