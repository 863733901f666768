"""All modes of a reduced body, orthonormal in mass and stiffness. Paper: Eq. (15)."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...solver.math.arrays import Array, IntArray
from .eigenmodes import SPARE, Eigenmodes, ModeRequest, eigenmodes
from .kinds import Participation, shares_of
from .reference import Condition, EigenSolver, ModeError, StaticShapes
from .static import StaticLoad, static_modes

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
    loads : each adds its static shape, see `static_modes`
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

    `unit_loads` (n_dof, l), nodal forces and moments, give the compliance of the whole body.
    Raises ModeError if the modes are not orthonormal to RESIDUAL.
    """
    n_dof, count = condition.K.shape[0], len(loads)
    unit = np.zeros((n_dof, 0)) if unit_loads is None else unit_loads
    requested = [np.array([getattr(a, n) for a in loads]).reshape(count, n_dof).T for n in LOADS]
    found = StaticShapes(*np.zeros((3, n_dof, 0)))
    if count or unit.shape[1]:
        requested = [np.hstack([requested[0], unit]), np.hstack([requested[1], 0.0 * unit])]
        found = condition.static(*requested)
    C = found.columns[:, count:].T @ found.loads[:, count:]
    added = static_modes(condition, kept, loads, found, participation)
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
        raise ModeError(
            f"modes are not orthonormal: X'MX - I is {mass:.2e}, X'KX - Lambda (scaled) "
            f"{stiffness.max():.2e}, expected below {RESIDUAL:.0e} and {allowed.min():.0e} "
            f"({STATIC_RESIDUAL:.0e} of static modes)"
        )
