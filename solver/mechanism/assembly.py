"""Convert readable tables of bodies, markers and joints to a `Model`."""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ..dynamics.elements.added_inertia import (
    inertia_of,
    is_positive,
    missing_inertia,
    of_one_length,
)
from ..dynamics.elements.constraints.treatment import Treatment
from ..dynamics.elements.forces.table import KINDS as FORCE_KINDS
from ..dynamics.elements.forces.table import MOST_ROWS, N_PARAMETER, rows_in_use
from ..dynamics.elements.joints.table import CONSTRAINTS, COUPLED, KINDS, NAMES, ROWS
from ..dynamics.elements.joints.table import N_PARAMETER as N_JOINT_PARAMETER
from ..dynamics.model.layout import make_layout
from ..dynamics.model.model import GROUND, Model
from ..math.arrays import Array, IntArray
from ..math.laws import N_COEFFICIENT, Law
from ..package.body.invariants import inertia_at_rest
from ..package.body.package_schema import Invariants, SecondOrder
from .tables import (
    Body,
    CoordinateTable,
    CouplingRow,
    ForceTable,
    JointTable,
    MarkerTable,
    Measured,
    RotorTable,
    quantities_of,
    reads_motion,
    rotor_arrays,
)
from .tolerances import NO_SECOND_ORDER


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

    Parameters
    ----------
    index : number of the body
    body : its table without point masses
    markers : markers of the mechanism
    point_masses : marker and mass [kg] of each
    """
    for k, m in point_masses:
        if markers[k].body != index:
            continue
        inv, x, phi = body.invariants, markers[k].x, markers[k].phi
        body = body._replace(
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
    """Return the point masses (marker and mass) of a body with second-order motion.

    Parameters
    ----------
    index : number of the body
    markers : markers of the mechanism
    used : second-order components (6) of each marker that are not zero
    point_masses : marker and mass [kg] of each
    """
    return [(k, m) for k, m in point_masses if markers[k].body == index and any(used[k][:3])]


def pieces(bodies: list[Body]) -> tuple[list[MarkerTable], list[float]]:
    """Return markers and masses [kg] of the pieces of stiffened bodies, which no joint uses."""
    markers: list[MarkerTable] = []
    masses: list[float] = []
    for i, body in enumerate(bodies):
        if body.second_order is None or (own := body.second_order.pieces) is None:
            continue
        masses += own.mass.tolist()
        for phi, h in zip(own.phi_B, own.h_B, strict=True):
            still = np.zeros_like(phi), np.zeros_like(h)
            markers.append(MarkerTable(i, np.zeros(3), np.eye(3), phi, still[0], h, still[1]))
    return markers, masses


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

    Parameters
    ----------
    bodies : tables of all bodies
    markers : markers of the mechanism
    point_masses : marker and mass [kg] of each
    """
    scale = []
    for i, body in enumerate(bodies):
        carried = [(m, markers[k].x) for k, m in point_masses if markers[k].body == i]
        mass = body.invariants.mass + sum(m for m, _ in carried)
        trace = np.trace(body.invariants.J0_B) + 2.0 * np.trace(body.invariants.T00_B)
        rotary = (trace + sum(2.0 * m * (x @ x) for m, x in carried)) / 3.0
        # a mass point has no rotary inertia: joints must constrain its rotations
        scale += [mass] * 3 + [rotary or mass] * 3 + list(np.diag(body.mass))
    whole = np.array(scale, dtype=float)
    none, some = whole == 0.0, whole > 0.0  # of a body without mass, for scaling only
    whole[none] = whole[some].min(initial=1.0)
    return whole


def filled(lists: Sequence[Sequence[float]], columns: int) -> Array:
    """Return lists of numbers as rows (n, columns), filled up with zeros."""
    out = np.zeros((len(lists), columns))
    for row, numbers in zip(out, lists, strict=True):
        row[: len(numbers)] = numbers
    return out


def pairs(markers: list[tuple[int, int]]) -> np.ndarray:
    """Return pairs of markers as rows (n, 2)."""
    return np.array(markers, dtype=np.int64).reshape(-1, 2)


def starts(sizes: np.ndarray) -> np.ndarray:
    """Return where parts of these sizes (n,) begin, and the end of the last: (n + 1,)."""
    return np.concatenate([[0], np.cumsum(sizes)]).astype(np.int64)


def stack(arrays: list[Array], shape: tuple[int, ...]) -> Array:
    """Return arrays of one shape as one array (n, *shape)."""
    return np.ascontiguousarray(np.array(arrays, dtype=float).reshape(-1, *shape))


def flat(arrays: list[Array]) -> Array:
    """Return the entries of all arrays, one array after the other."""
    if not arrays:
        return np.zeros(0)
    return np.concatenate([np.ascontiguousarray(a, dtype=float).reshape(-1) for a in arrays])


FREEDOMS = 6


class Stand(NamedTuple):
    """A joint or drive as seen from here: what it takes and where it holds on."""

    removes: tuple[str, ...] | None  # freedoms that its rows take, one each; None: others as well
    bodies: tuple[int, int]  # of its two markers; -1: ground
    rigid: bool  # its marker on the body does not depend on the modes
    x: Array  # (3,) of that marker
    A: Array  # (3, 3)


def driven_frames(joints: Sequence[Stand]) -> IntArray:
    """Return, by joint, the body whose frame it drives, alone or with others; -1: none."""
    out = np.full(len(joints), -1, dtype=np.int64)
    at_body: dict[int, list[int]] = {}
    for k, joint in enumerate(joints):
        if joint.rigid and min(joint.bodies) < 0 <= max(joint.bodies):
            at_body.setdefault(max(joint.bodies), []).append(k)
    for body, indices in at_body.items():
        taken = [joints[k].removes for k in indices]
        freedoms = [freedom for removes in taken if removes is not None for freedom in removes]
        if None in taken or not len(freedoms) == len(set(freedoms)) == FREEDOMS:
            continue
        first = joints[indices[0]]
        same = all(
            np.allclose(joints[k].x, first.x, rtol=0.0, atol=1e-12)
            and np.allclose(joints[k].A, first.A, rtol=0.0, atol=1e-12)
            for k in indices
        )
        if same:
            out[indices] = body
    return out


def marker_second_order(bodies: list[Body], marker: MarkerTable) -> Array:
    """Second-order tables of a marker, (6, m, m); empty for a linear body."""
    if marker.body == GROUND or bodies[marker.body].second_order is None:
        return np.zeros((6, 0, 0))
    if marker.H is None or marker.H_psi is None:
        name = bodies[marker.body].name
        raise ValueError(f"a marker on {name} has no H, H_psi: a stiffened body needs them")
    return np.concatenate([marker.H, marker.H_psi])


def of_motion(H: Array, marker: MarkerTable) -> list[bool]:
    """Return which tables (6, m, m) of a marker are above the round-off of the others.

    Rotations are taken relative to the square of the first order.
    """
    turn = float(np.abs(marker.psi).max(initial=0.0))
    return [*_used(H[:3], 0.0), *_used(H[3:], turn**2)]


def _used(T: Array, scale: float) -> list[bool]:
    """Return which tables of T (r, m, m) have an entry above round-off."""
    largest = np.abs(T).max(axis=(1, 2), initial=0.0)
    return [bool(x > NO_SECOND_ORDER * max(scale, largest.max())) for x in largest]


def pairs_used(invariants: Invariants) -> list[bool]:
    """Return for each pair 3 a + b of axes whether T01 or T11 has an entry there."""
    T01, T11 = invariants.T01_B, invariants.T11_B.transpose(0, 1, 3, 2)
    used = np.abs(T01).max(axis=2, initial=0.0) + np.abs(T11).max(axis=(2, 3), initial=0.0)
    return [bool(u) for u in (used > 0.0).ravel()]


def assemble_model(
    bodies: list[Body],
    markers: list[MarkerTable],
    joints: list[JointTable],
    point_masses: Sequence[tuple[int, float]] = (),
    gravity_G: Array | tuple[float, float, float] = (0.0, 0.0, 0.0),
    alpha: float = 5.0,
    beta: float = 5.0,
    forces: Sequence[ForceTable] = (),
    measured: Measured | None = None,
    rotor: RotorTable | None = None,
) -> Model:
    """Concatenate the tables to a model.

    Parameters
    ----------
    point_masses : pairs of (marker index, mass [kg])
    gravity_G : (3,) [m/s2]
    alpha, beta : Baumgarte's constants, Eq. (13) [1/s]
    measured : what expressions of laws and forces read; none if None
    rotor : in the wind; its loads follow the force elements
    """
    measured = measured or Measured()
    forces = [*forces, *(rotor.forces if rotor else ())]
    own, own_mass = pieces(bodies)
    first_piece = len(markers)
    moving = [*point_masses, *enumerate(own_mass, first_piece)]
    markers = [*markers, *own]
    n_mode = np.array([b.mass.shape[0] for b in bodies], dtype=np.int64)
    joints = [*joints, *(_coupling(row, measured) for row in measured.couplings)]
    kinds = np.array([KINDS[j.kind] for j in joints], dtype=np.int64)
    laws: list[Law] = []
    joint_law, force_law = _numbered(joints, laws), _numbered(forces, laws)
    in_wind = rotor_arrays(rotor, len(forces), len(laws))
    laws += rotor.laws if rotor else ()
    carrying = [with_points(i, body, markers, point_masses) for i, body in enumerate(bodies)]
    inv = [b.invariants for b in carrying]
    second = [b.second_order for b in carrying]
    stiffened = np.array([n if s else 0 for n, s in zip(n_mode, second, strict=True)], dtype=int)
    Z = [np.concatenate([s.Z0_B, *s.Z1_B]) if s else np.zeros((12, 0, 0)) for s in second]
    Z_used = [[*_used(T[:3], 0.0), *_used(T[3:], 0.0)] for T in Z]  # above round-off of the others
    marker_H = [marker_second_order(bodies, marker) for marker in markers]
    used = [of_motion(H, m) for H, m in zip(marker_H, markers, strict=True)]
    carried = [carried_masses(i, markers, used, moving) for i in range(len(bodies))]
    marker_second = starts(np.array([H.size for H in marker_H], dtype=np.int64))[:-1]
    joint_marker = pairs([(j.marker_1, j.marker_2) for j in joints])
    force_marker = pairs([(e.marker_1, e.marker_2) for e in forces])
    marker_body = np.array([m.body for m in markers], dtype=np.int64)
    marker_size = [m.phi.size for m in markers]
    joint_row = starts(np.array([len(ROWS[NAMES[k]]) for k in kinds], dtype=np.int64))
    scale = inertia_scale(bodies, markers, point_masses)
    quantities = quantities_of(measured, laws, forces)
    driven = driven_frames([_stand(j, markers, marker_H) for j in joints])
    added = [
        # a frame that is driven is no unknown
        np.zeros((0, 6 + n_mode[i])) if i in driven and is_positive(body.mass) else missing(body)
        for i, body in enumerate(carrying)
    ]
    return Model(
        n_body=len(bodies),
        n_pos=int((7 + n_mode).sum()),
        n_vel=int((6 + n_mode).sum()),
        n_constraint=int(joint_row[-1]),
        n_mode=n_mode,
        pos_start=starts(7 + n_mode)[:-1],
        vel_start=starts(6 + n_mode)[:-1],
        mode_start=starts(n_mode),
        square_start=starts(n_mode**2),
        mass=np.array([i.mass for i in inv]),
        S0=stack([i.S0_B for i in inv], (3,)),
        T00=stack([i.T00_B for i in inv], (3, 3)),
        J0=stack([i.J0_B for i in inv], (3, 3)),
        S=flat([i.S_B for i in inv]),
        T01=flat([i.T01_B for i in inv]),
        T11=flat([i.T11_B.transpose(0, 1, 3, 2) for i in inv]),
        J_psi=flat([i.J_psi_B for i in inv]),
        M_qq=flat([b.mass for b in carrying]),
        K_qq=flat([b.stiffness for b in bodies]),
        D_qq=flat([b.damping for b in bodies]),
        gravity_G=np.asarray(gravity_G, dtype=float),
        marker_body=marker_body,
        marker_x=stack([m.x for m in markers], (3,)),
        marker_A=stack([m.A for m in markers], (3, 3)),
        marker_start=starts(np.array(marker_size, dtype=np.int64))[:-1],
        marker_phi=flat([m.phi for m in markers]),
        marker_psi=flat([m.psi for m in markers]),
        joint_kind=kinds,
        joint_marker=joint_marker,
        joint_row=joint_row,
        joint_law=joint_law,
        joint_parameters=filled([j.parameters for j in joints], N_JOINT_PARAMETER),
        force_kind=np.array([FORCE_KINDS.get(e.kind, -1) for e in forces], dtype=np.int64),
        force_marker=force_marker,
        force_law=force_law,
        force_parameters=filled([e.parameters for e in forces], N_PARAMETER),
        law_start=starts(np.array([len(law.times) for law in laws], dtype=np.int64)),
        law_time=np.concatenate([np.zeros(0), *[law.times for law in laws]]),
        law_coefficient=np.concatenate(
            [np.zeros((0, N_COEFFICIENT)), *[law.coefficients for law in laws]]
        ),
        inertia_scale=scale,
        redundant=0,
        alpha=float(alpha),
        beta=float(beta),
        penalty=0.0,
        multiplier_tolerance=0.0,
        multiplier_iterations=0,
        pair_used=np.array([pairs_used(i) for i in inv], dtype=np.int8).reshape(-1, 9),
        added_inertia=inertia_of(added, scale, starts(6 + n_mode)),
        added_direction=of_one_length(added),
        layout=make_layout(
            n_mode,
            marker_body,
            joint_marker,
            joint_row,
            force_marker,
            uncoupled=[
                is_uncoupled(b) and not d[:, 6:].any() for b, d in zip(carrying, added, strict=True)
            ],
            driven=driven,
            added=[len(directions) for directions in added],
            element_rows=[_element_rows(e) for e in forces],
            most_element_rows=MOST_ROWS,
            measured=measured.markers,
            couplings=[
                [k for m, _ in row.terms for k in _ends(measured.coordinates[m])]
                for row in measured.couplings
            ],
        ),
        second_start=starts(stiffened**2),
        third_start=starts(stiffened**3),
        fourth_start=starts(stiffened**4),
        Z=flat(Z),
        Z_used=np.array(Z_used, dtype=np.int8).reshape(-1, 12),
        G3=flat([s.G3 for s in second if s]),
        G4=flat([s.G4.transpose(0, 2, 3, 1) for s in second if s]),
        marker_second=np.where([H.size > 0 for H in marker_H], marker_second, -1).astype(np.int64),
        marker_H=flat(marker_H),
        marker_H_used=np.array(used, dtype=np.int8).reshape(-1, 6),
        carried_start=starts(np.array([len(c) for c in carried], dtype=np.int64)),
        carried_marker=np.array([k for c in carried for k, _ in c], dtype=np.int64),
        carried_mass=np.array([mass for c in carried for _, mass in c], dtype=float),
        carried_whole=np.array([k < first_piece for c in carried for k, _ in c], dtype=np.int8),
        n_aux=int(quantities.rate.size),
        quantities=quantities,
        rotor=in_wind,
    )


def _ends(coordinate: CoordinateTable) -> tuple[int, int]:
    return coordinate.marker_1, coordinate.marker_2


def _coupling(row: CouplingRow, measured: Measured) -> JointTable:
    """Return a coupling as a joint between the markers of its first coordinate."""
    one, two = _ends(measured.coordinates[row.terms[0][0]])
    return JointTable(row.name, COUPLED[row.unit], one, two)


def _element_rows(force: ForceTable) -> list[int]:
    """Return the rows of an element in Newton's matrix."""
    if not force.is_its_size:
        return rows_in_use(force.kind, force.parameters)
    return [0] if reads_motion(force.size) else []


def _stand(joint: JointTable, markers: list[MarkerTable], H: Sequence[Array]) -> Stand:
    """Return the data of a joint for the search of driven frames."""
    pair = (joint.marker_1, joint.marker_2)
    bodies = (markers[pair[0]].body, markers[pair[1]].body)
    k = pair[0] if bodies[0] >= 0 else pair[1]
    one = markers[k]
    rigid = not (one.phi.any() or one.psi.any() or H[k].any())
    kind = CONSTRAINTS[joint.kind]
    known = kind.removes if len(kind.removes) == len(kind.units) else None
    return Stand(known, bodies, rigid, one.x, one.A)


def _numbered(tables: Sequence[JointTable] | Sequence[ForceTable], laws: list[Law]) -> np.ndarray:
    """Return the number of each law, -1 for none, and collect the laws."""
    numbers = []
    for table in tables:
        numbers.append(-1 if table.law is None else len(laws))
        if table.law is not None:
            laws.append(table.law)
    return np.array(numbers, dtype=np.int64)


def treated(model: Model, treatment: Treatment) -> Model:
    """Return the model with the parameters of a treatment."""
    alpha = beta = penalty = 0.0
    if treatment.name == "baumgarte":
        alpha, beta = treatment.alpha, treatment.beta
    elif treatment.name == "augmented-lagrangian":
        alpha, beta = treatment.ratio * treatment.frequency, treatment.frequency
        penalty = treatment.penalty
    elif treatment.name == "projection":
        # The same solution, which handles singular positions, without feedback.
        penalty = treatment.penalty
    return model._replace(
        alpha=float(alpha),
        beta=float(beta),
        penalty=float(penalty),
        multiplier_tolerance=float(treatment.multiplier_tolerance),
        multiplier_iterations=int(treatment.multiplier_iterations),
    )
