"""Input of a beam to the mode computation: reference, static and spinning shapes, mesh error."""

from collections.abc import Sequence
from typing import Literal

import numpy as np

from ...solver.errors import coded, few
from ...solver.math.arrays import Array, IntArray
from ...solver.package.body.invariants import rigid_motions
from ..modes.reduced import StaticLoad, accelerations
from ..modes.reference import HELD, Condition, HeldDofs, MeanAxis
from .element import BeamElement, scaled_inverse
from .line import BeamLine, LineSection

LIMIT = 0.01  # relative frequency error above which a mesh is reported as coarse


def frequency_error(
    line: BeamLine,
    values: Array,
    columns_B: Array,
    mass_form: str,
    halves: Sequence[LineSection] | None = None,
) -> Array:
    """Estimated relative error of the frequencies, (m,); positive where they are too high.

    Parameters
    ----------
    line : the beam
    values : (m,) eigenvalues [rad2/s2]
    columns_B : (6 n, m) mass-normalised modes, body axes
    mass_form : "consistent" or "lumped"
    halves : (2 e,) sections of both halves of each element of a tapered beam; None: uniform
    """
    nodal_E = line.to_element(columns_B)
    change = np.zeros(len(values))
    for span in line.spans:
        element, mass = span.element, span.section.mass
        d = nodal_E[span.numbers]
        k, L = 2 * span.numbers[0], 0.5 * element.length
        # nodes of the halved element: first, last (12 values), middle (6)
        P = np.vstack([np.eye(12), element.shape(np.array([L]))[0]])
        first, second = np.r_[0:6, 12:18], np.r_[12:18, 6:12]
        K_fine, M_fine = np.zeros((18, 18)), np.zeros((18, 18))
        own = [span.section] * 2 if halves is None else halves[k : k + 2]
        for dofs, section in zip((first, second), own, strict=True):
            half = BeamElement(L, section.K)
            K_fine[np.ix_(dofs, dofs)] += half.stiffness()
            M_fine[np.ix_(dofs, dofs)] += half.mass_matrix(section.mass, mass_form)
        gained = P.T @ M_fine @ P - element.mass_matrix(mass, mass_form)
        change += values * np.einsum("eim,ij,ejm->m", d, gained, d, optimize=True)
        r = values * np.einsum("ij,ejm->eim", M_fine[12:] @ P, d)
        if halves is not None:  # of a uniform element both are 0
            gained = P.T @ K_fine @ P - element.stiffness()
            change -= np.einsum("eim,ij,ejm->m", d, gained, d, optimize=True)
            r -= np.einsum("ij,ejm->eim", K_fine[12:] @ P, d)
        follow = scaled_inverse(K_fine[12:, 12:])
        change += np.einsum("eim,ij,ejm->m", r, follow, r, optimize=True)
    return 0.5 * 4.0 / 3.0 * change / values


def coarse_mesh_warnings(
    labels: tuple[str, ...], error: Array, elements: int
) -> list[dict[str, str]]:
    """Warning `mesh-coarse-for-modes` naming the modes beyond LIMIT; empty if there are none.

    Parameters
    ----------
    labels : of m modes
    error : (m,) relative errors of their frequencies, of any sign
    elements : number of elements of the beam
    """
    coarse = [
        f"{label} ({abs(e):.1%})" for label, e in zip(labels, error, strict=True) if abs(e) > LIMIT
    ]
    if not coarse:
        return []
    message = (
        f"{elements} elements are too few for the modes {few(coarse)}: estimated frequency "
        f"error above {LIMIT:.0%}; increase `elements`"
    )
    return coded("mesh-coarse-for-modes", message)


# Transverse displacement, and the rotation that equals its slope, with its sign.
PLANES = {"spinning-xy": (1, 5, 1.0), "spinning-xz": (2, 4, -1.0)}


def spinning_loads(
    condition: Condition, line: BeamLine, requested: tuple[tuple[str, int], ...], origin: int
) -> list[StaticLoad]:
    """Loads of the static modes "spinning-xy" and "spinning-xz".

    Parameters
    ----------
    condition : reference condition; not a mean axis, because a mean axis carries the first load
    line : the beam, straight and, for the tension, uniform
    requested : key of PLANES and number of shapes
    origin : node on the axis of rotation
    """
    x = line.nodes_B[:, 0] - line.nodes_B[origin, 0]
    tension = 0.5 * (np.where(x < 0.0, x[0], x[-1]) ** 2 - x**2)
    zero = np.zeros(6 * line.n_node)
    loads = []
    for kind, count in requested:
        across, turning, sign = PLANES[kind]
        pull = x
        for k in range(count):
            acceleration = np.zeros((line.n_node, 6))
            acceleration[:, across] = pull / np.abs(pull).max()
            load = acceleration.ravel()
            loads.append(StaticLoad(f"{kind} {k + 1}", zero, load))
            shape = condition.static(zero[:, None], load[:, None]).columns[:, 0]
            slope = sign * shape.reshape(-1, 6)[:, turning]
            order: Literal[1, 2] = 2 if line.n_node > 2 else 1
            pull = np.gradient(tension * slope, line.nodes_B[:, 0], edge_order=order)
    return loads


def reference_condition(
    line: BeamLine, mass_form: str, kind: str, nodes: tuple[int, ...]
) -> Condition:
    """Reference condition of a beam.

    Parameters
    ----------
    line : the beam
    mass_form : "consistent" or "lumped": of the eigenproblem and of the mean axis
    kind : one of REFERENCE_CONDITIONS
    nodes : nodes that carry the frame: one if clamped, two for a chord; for a mean axis none, or
        two that carry the loads of static shapes as a chord does

    Raises
    ------
    ModeError : a mean axis of a body without inertia about some axis.
    """
    K, M = line.stiffness(), line.mass_matrix(mass_form)
    held = held_dofs(kind, nodes)
    if held is None:
        rigid = rigid_motions(line.nodes_B).reshape(6 * line.n_node, 6)
        still = held_dofs("chord", nodes) if nodes else None
        return MeanAxis(K, M, rigid, still=still, reactions=bool(nodes))
    return HeldDofs(K, M, held)


def held_dofs(kind: str, nodes: tuple[int, ...]) -> IntArray | None:
    """Dofs (6,) that are fixed in the frame of `reference_condition`; None for a mean axis."""
    if kind == "mean-axis":
        return None
    return np.array([6 * n + dof for n, own in zip(nodes, HELD[kind], strict=True) for dof in own])


def unit_forces(line: BeamLine, node_of: dict[str, int]) -> Array:
    """Unit forces and moments at the interfaces with these nodes, (6 n, 6 i)."""
    at = [6 * node + k for node in node_of.values() for k in range(6)]
    forces = np.zeros((6 * line.n_node, len(at)))
    forces[at, np.arange(len(at))] = 1.0
    return forces


def unit_loads(condition: Condition, line: BeamLine, forces: Array) -> Array:
    """Unit loads (6 n, 6 i + 12) of the compliance of a package: of i interfaces, and inertia.

    The nodes turn with the slope t x A t of the moved line, and with half of the curl about its
    tangent t: a consistent mass would bend elements whose ends do not turn.

    Parameters
    ----------
    condition : reference condition, which has the mass
    line : the beam, n nodes
    forces : (6 n, 6 i) unit forces and moments at the interfaces
    """
    fields = accelerations(np.repeat(line.nodes_B, 6, axis=0), np.arange(len(forces)) % 6)
    t = np.gradient(line.nodes_B, line.along, axis=0)
    t /= np.linalg.norm(t, axis=1, keepdims=True)
    slope = np.einsum("nak,nb->nkab", np.cross(t[:, None], np.eye(3)), t)
    turns = fields.reshape(-1, 6, 3, 4)[:, 3:, :, :3]
    turns[:] = slope + np.einsum("nk,nl,nlab->nkab", t, t, turns)
    return np.hstack([forces, condition.M @ fields])
