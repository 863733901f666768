"""Inertia of the bodies, with the point masses that they carry."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...dynamics.elements.bodies.added_inertia import missing_inertia
from ...math.arrays import Array
from ...package.body.invariants import inertia_at_rest
from ...package.body.schema import SecondOrder
from .tables import Body, MarkerTable


def is_uncoupled(body: Body) -> bool:
    """True if mass, stiffness and damping of the modes are diagonal in every state."""
    matrices = (body.mass, body.stiffness, body.damping)
    return body.second_order is None and all(
        np.count_nonzero(a) == np.count_nonzero(np.diag(a)) for a in matrices
    )


def with_points(
    index: int,
    body: Body,
    markers: list[MarkerTable],
    point_masses: Sequence[tuple[int, float]],
) -> Body:
    """Return a body with the point masses of its markers as additional mass stations.

    A mass point moves with its marker, x + phi q, and 1/2 q' H q on a stiffened body. It is one
    more station in the sums of invariants.py and second_order.py of package/body/, without cost at
    run time.
    """
    for k, m in point_masses:
        if markers[k].body != index:
            continue
        inv, x, phi = body.invariants, markers[k].x, markers[k].phi
        body = replace(
            body,
            mass=body.mass + m * phi.T @ phi,
            invariants=replace(
                inv,
                mass=inv.mass + m,
                S0_B=inv.S0_B + m * x,
                S_B=inv.S_B + m * phi,
                T00_B=inv.T00_B + m * np.outer(x, x),
                T01_B=inv.T01_B + m * np.einsum("a,bi->abi", x, phi),
                T11_B=inv.T11_B + m * np.einsum("ai,bj->abij", phi, phi),
            ),
            second_order=_with_point(body.second_order, markers[k], m),
        )
    return body


def _with_point(second: SecondOrder | None, marker: MarkerTable, m: float) -> SecondOrder | None:
    if second is None or marker.H is None:
        return second
    H, phi = marker.H, marker.phi
    return replace(
        second,
        Z0_B=second.Z0_B + m * H,
        Z1_B=second.Z1_B + m * np.einsum("a,bij->abij", marker.x, H),
        G3=second.G3 + m * np.einsum("ai,ajk->ijk", phi, H),
        G4=second.G4 + m * np.einsum("aij,akl->ijkl", H, H),
    )


def carried_masses(
    index: int,
    markers: list[MarkerTable],
    used: list[list[bool]],
    point_masses: Sequence[tuple[int, float]],
) -> list[tuple[int, float]]:
    """Return the point masses (marker and mass) of a body with second-order motion."""
    return [(k, m) for k, m in point_masses if markers[k].body == index and any(used[k][:3])]


def missing(body: Body) -> Array:
    """Return the directions (d, 6 + m) in which a body has no inertia."""
    inv = body.invariants
    T = inv.T01_B
    coupling = np.array([T[1, 2] - T[2, 1], T[2, 0] - T[0, 2], T[0, 1] - T[1, 0]]) + inv.J_psi_B
    return missing_inertia(inv.mass, inertia_at_rest(inv), coupling, inv.S0_B, inv.S_B, body.mass)


def inertia_scale(
    bodies: list[Body],
    markers: list[MarkerTable],
    point_masses: Sequence[tuple[int, float]],
) -> Array:
    """Return a typical inertia of each velocity coordinate, (n_vel,) [kg, kg m2, modal mass].

    All rotations of a body use the mean of its three inertias. A thin rod has almost none
    about its axis, which must not give that rotation a larger weight than the others.
    """
    scale = []
    for i, body in enumerate(bodies):
        carried = [(m, markers[k].x) for k, m in point_masses if markers[k].body == i]
        mass = body.invariants.mass + sum(m for m, _ in carried)
        trace = np.trace(body.invariants.J0_B) + 2.0 * np.trace(body.invariants.T00_B)
        rotary = (trace + sum(2.0 * m * (x @ x) for m, x in carried)) / 3.0
        # a mass point has no rotary inertia: joints must constrain its rotations
        scale += [mass] * 3 + [rotary or mass] * 3 + list(np.diag(body.mass))
    return np.array(scale, dtype=float)
