"""Compile readable tables of bodies, markers and joints into a frozen `Model`."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from .forces.table import KINDS as FORCE_KINDS
from .forces.table import N_PARAMETER
from .joints.table import KINDS, NAMES, ROWS
from .laws import N_COEFFICIENT, Law
from .model import GROUND, Model
from .package.invariants import inertia_at_rest
from .package.schema import Array, Invariants, ModalPackage
from .plan import make_plan, positive_inertia


@dataclass(frozen=True)
class Body:
    """Inertia and elasticity of one body, in its own frame; rigid if it has no modes."""

    name: str
    invariants: Invariants
    mass: Array  # (m, m) modal mass
    stiffness: Array  # (m, m)
    damping: Array  # (m, m)


def rigid_body(name: str, mass: float, centre_B: Array, inertia_B: Array) -> Body:
    """Return a rigid body of given mass, mass centre (3,) and inertia about it (3, 3)."""
    centre = np.asarray(centre_B, dtype=float)
    empty = np.zeros((0, 0))
    invariants = Invariants(
        mass=mass,
        S0_B=mass * centre,
        S_B=np.zeros((3, 0)),
        T00_B=mass * np.outer(centre, centre),
        T01_B=np.zeros((3, 3, 0)),
        T11_B=np.zeros((3, 3, 0, 0)),
        J0_B=np.asarray(inertia_B, dtype=float),
        J_psi_B=np.zeros((3, 0)),
        mass_form="lumped",
    )
    return Body(name, invariants, empty, empty, empty)


def flexible_body(name: str, package: ModalPackage) -> Body:
    """Return the body that a modal package describes."""
    return Body(name, package.invariants, package.mass, package.stiffness, package.damping)


@dataclass(frozen=True)
class MarkerTable:
    """One marker: body index (GROUND = -1), rest frame, and its mode shapes."""

    body: int
    x: Array  # (3,) body components; global for the ground [m]
    A: Array = field(default_factory=lambda: np.eye(3))
    phi: Array = field(default_factory=lambda: np.zeros((3, 0)))
    psi: Array = field(default_factory=lambda: np.zeros((3, 0)))


@dataclass(frozen=True)
class JointTable:
    """One joint between two markers; kind is a key of `joints.table.KINDS`."""

    name: str
    kind: str
    marker_1: int
    marker_2: int
    law: Law | None = None  # of a drive
    length: float = 0.0  # of a distance [m]


@dataclass(frozen=True)
class ForceTable:
    """One force element between two markers; kind is a key of `forces.table.KINDS`."""

    name: str
    kind: str
    marker_1: int
    marker_2: int
    parameters: tuple[float, ...] = ()  # forces.table.PARAMETERS
    law: Law | None = None  # of an actuator or a load


def assemble_model(
    bodies: list[Body],
    markers: list[MarkerTable],
    joints: list[JointTable],
    point_masses: Sequence[tuple[int, float]] = (),
    gravity_G: Array | tuple[float, float, float] = (0.0, 0.0, 0.0),
    alpha: float = 5.0,
    beta: float = 5.0,
    forces: Sequence[ForceTable] = (),
) -> Model:
    """Lay the tables end to end.

    Parameters
    ----------
    point_masses : pairs of (marker index, mass [kg])
    gravity_G : (3,) [m/s2]
    alpha, beta : Baumgarte's constants, Eq. (13) [1/s]
    """
    n_mode = np.array([b.mass.shape[0] for b in bodies], dtype=np.int64)
    for marker in markers:
        expected = 0 if marker.body == GROUND else int(n_mode[marker.body])
        if marker.phi.shape != (3, expected) or marker.psi.shape != (3, expected):
            raise ValueError(
                f"marker shapes {marker.phi.shape}, {marker.psi.shape}: expected (3, {expected})"
            )
    kinds = np.array([KINDS[j.kind] for j in joints], dtype=np.int64)
    parameters = np.zeros((len(forces), N_PARAMETER))
    for k, element in enumerate(forces):
        parameters[k, : len(element.parameters)] = element.parameters
    laws: list[Law] = []
    joint_law, force_law = _numbered(joints, laws), _numbered(forces, laws)
    carrying = [_with_points(i, body, markers, point_masses) for i, body in enumerate(bodies)]
    inv = [b.invariants for b in carrying]
    joint_marker = _pairs([(j.marker_1, j.marker_2) for j in joints])
    force_marker = _pairs([(e.marker_1, e.marker_2) for e in forces])
    marker_body = np.array([m.body for m in markers], dtype=np.int64)
    marker_size = [m.phi.size for m in markers]
    joint_row = _starts(np.array([len(ROWS[NAMES[k]]) for k in kinds], dtype=np.int64))
    return Model(
        n_body=len(bodies),
        n_pos=int((7 + n_mode).sum()),
        n_vel=int((6 + n_mode).sum()),
        n_constraint=int(joint_row[-1]),
        n_mode=n_mode,
        pos_start=_starts(7 + n_mode)[:-1],
        vel_start=_starts(6 + n_mode)[:-1],
        mode_start=_starts(n_mode),
        square_start=_starts(n_mode**2),
        mass=np.array([i.mass for i in inv]),
        S0=_stack([i.S0_B for i in inv], (3,)),
        T00=_stack([i.T00_B for i in inv], (3, 3)),
        J0=_stack([i.J0_B for i in inv], (3, 3)),
        S=_flat([i.S_B for i in inv]),
        T01=_flat([i.T01_B for i in inv]),
        T11=_flat([i.T11_B.transpose(0, 1, 3, 2) for i in inv]),
        J_psi=_flat([i.J_psi_B for i in inv]),
        M_qq=_flat([b.mass for b in carrying]),
        K_qq=_flat([b.stiffness for b in bodies]),
        D_qq=_flat([b.damping for b in bodies]),
        gravity_G=np.asarray(gravity_G, dtype=float),
        marker_body=marker_body,
        marker_x=_stack([m.x for m in markers], (3,)),
        marker_A=_stack([m.A for m in markers], (3, 3)),
        marker_start=_starts(np.array(marker_size, dtype=np.int64))[:-1],
        marker_phi=_flat([m.phi for m in markers]),
        marker_psi=_flat([m.psi for m in markers]),
        joint_kind=kinds,
        joint_marker=joint_marker,
        joint_row=joint_row,
        joint_law=joint_law,
        joint_length=np.array([j.length for j in joints], dtype=float),
        force_kind=np.array([FORCE_KINDS[e.kind] for e in forces], dtype=np.int64),
        force_marker=force_marker,
        force_law=force_law,
        force_parameters=parameters,
        law_start=_starts(np.array([len(law.times) for law in laws], dtype=np.int64)),
        law_time=np.concatenate([np.zeros(0), *[law.times for law in laws]]),
        law_coefficient=np.concatenate(
            [np.zeros((0, N_COEFFICIENT)), *[law.coefficients for law in laws]]
        ),
        point_marker=np.array([k for k, _ in point_masses], dtype=np.int64),
        point_mass=np.array([mass for _, mass in point_masses], dtype=float),
        inertia_scale=_inertia_scale(bodies, markers, point_masses),
        redundant=0,
        alpha=float(alpha),
        beta=float(beta),
        penalty=0.0,
        multiplier_tolerance=0.0,
        multiplier_iterations=0,
        pair_used=np.array([_pairs_used(i) for i in inv], dtype=np.int8).reshape(-1, 9),
        plan=make_plan(
            n_mode,
            marker_body,
            joint_marker,
            joint_row,
            force_marker,
            structured=all(_positive(b) for b in carrying),
        ),
    )


def _with_points(
    index: int,
    body: Body,
    markers: list[MarkerTable],
    point_masses: Sequence[tuple[int, float]],
) -> Body:
    """Return a body with the point masses that its markers carry among its mass stations.

    A mass point moves with its marker, x + phi q: one station more in the sums of
    package/invariants.py, and no cost at run time.
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
        )
    return body


def _pairs_used(invariants: Invariants) -> list[bool]:
    """Tell for each pair 3 a + b of axes whether T01 or T11 has an entry there."""
    T01, T11 = invariants.T01_B, invariants.T11_B.transpose(0, 1, 3, 2)
    used = np.abs(T01).max(axis=2, initial=0.0) + np.abs(T11).max(axis=(2, 3), initial=0.0)
    return [bool(u) for u in (used > 0.0).ravel()]


def _positive(body: Body) -> bool:
    inv = body.invariants
    T = inv.T01_B
    coupling = np.array([T[1, 2] - T[2, 1], T[2, 0] - T[0, 2], T[0, 1] - T[1, 0]]) + inv.J_psi_B
    J = inertia_at_rest(inv)
    return positive_inertia(inv.mass, J, coupling, inv.S0_B, inv.S_B, body.mass)


def _pairs(markers: list[tuple[int, int]]) -> np.ndarray:
    return np.array(markers, dtype=np.int64).reshape(-1, 2)


def _inertia_scale(
    bodies: list[Body],
    markers: list[MarkerTable],
    point_masses: Sequence[tuple[int, float]],
) -> Array:
    """Return a typical inertia of each velocity coordinate, (n_vel,) [kg, kg m2, modal mass].

    The mean of a body's three inertias serves all of its rotations: a thin rod has next to none
    about its axis, which must not make that rotation count for more than the others.
    """
    scale = []
    for i, body in enumerate(bodies):
        carried = [(m, markers[k].x) for k, m in point_masses if markers[k].body == i]
        mass = body.invariants.mass + sum(m for m, _ in carried)
        trace = np.trace(body.invariants.J0_B) + 2.0 * np.trace(body.invariants.T00_B)
        rotary = (trace + sum(2.0 * m * (x @ x) for m, x in carried)) / 3.0
        # a mass point has no rotary inertia: its rotations are held by joints, or nothing is
        scale += [mass] * 3 + [rotary or mass] * 3 + list(np.diag(body.mass))
    return np.array(scale, dtype=float)


def _numbered(tables: Sequence[JointTable] | Sequence[ForceTable], laws: list[Law]) -> np.ndarray:
    """Return the number of the law of each, -1 where it has none, and collect the laws."""
    numbers = []
    for table in tables:
        numbers.append(-1 if table.law is None else len(laws))
        if table.law is not None:
            laws.append(table.law)
    return np.array(numbers, dtype=np.int64)


def _starts(sizes: np.ndarray) -> np.ndarray:
    return np.concatenate([[0], np.cumsum(sizes)]).astype(np.int64)


def _stack(arrays: list[Array], shape: tuple[int, ...]) -> Array:
    return np.ascontiguousarray(np.array(arrays, dtype=float).reshape(-1, *shape))


def _flat(arrays: list[Array]) -> Array:
    if not arrays:
        return np.zeros(0)
    return np.concatenate([np.ascontiguousarray(a, dtype=float).reshape(-1) for a in arrays])
