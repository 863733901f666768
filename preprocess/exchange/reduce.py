"""From the free matrices of any code to a modal package: the one reduction of all sources."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import scipy.linalg

from ...solver.errors import InputError, nearest
from ...solver.math.arrays import Array, IntArray
from ...solver.package import Interface, ModalPackage
from ...solver.package.body.invariants import MOST_MODES
from ...solver.package.common.plain_data import SpecError, check_form
from ..modes.eigenmodes import (
    KINDS,
    Eigenmodes,
    Participation,
    clusters,
    separating_rotation,
    shares_of,
)
from ..modes.reduced import Modes, StaticLoad, accelerations, completed
from ..modes.reference import HELD, Algebra, Condition, HeldDofs, MeanAxis, ModeError
from .direct import Direct, Solver
from .free_body import DIRECTIONS, FreeBody, free_body, labelled_cells, recovered
from .import_table import SI, Reduction, UnitsTable, damping_ratio, provenance, sizes
from .imported_interfaces import Constrained, Link, constrained, links
from .inertia import Inertia, bent_body, inertia, second_order_sums
from .refusals import check_free_body

Tell = Callable[[str], None]  # called with the name of each step
ALONG = 1e-6  # sine of the angle between a chord and x
SPARE = 4
SEVENTH = 1e-14  # value of a mode without stiffness, relative to the largest K_ii / M_ii
ROUNDS = 4  # attempts to find all modes below the highest


def reduce_body(
    source: FreeBody,
    table: Reduction,
    tell: Tell = lambda _: None,
    solver: Callable[[Constrained], Solver] = lambda parts: Direct(parts.places),
    second_order: Callable[[Array], Array] | None = None,
) -> ModalPackage:
    """Modal package of a body from its free matrices.

    Parameters
    ----------
    source : in the units of `table`
    table : interfaces, reference condition and modes (docs/exchange.md)
    tell : called with the name of each step
    solver : made with the dofs after the rigid links
    second_order : forces of pairs of modes, of a body of three dofs per node (second_order.py)

    Raises
    ------
    InputError : the matrices are not those of one free body, or a request cannot be fulfilled.
    """
    length, mass, time = sizes(table["units"])
    body = source.in_units(length, mass, time)
    ratio = damping_ratio(table, body.where)
    tell(f"checking {len(body.dof_node)} degrees of freedom")
    check_free_body(body, table.get("total_mass"))
    every = links(body, table["interfaces"], length)
    parts = constrained(body, every)
    try:
        modes, condition = _modes(body, table, every, parts, tell, solver(parts))
    except ModeError as error:
        raise InputError(f"{body.where}: {error}") from error
    tell("inertia invariants")
    U = np.asarray(parts.T @ modes.columns_B)
    shapes = np.zeros((U.shape[1], len(body.nodes), 6))
    shapes[:, body.dof_node, body.dof_direction] = U.T
    package = _package(body, table, every, modes, U, shapes, inertia(body, shapes), ratio)
    if second_order is None or not 0 < U.shape[1] <= MOST_MODES:
        return package
    tell("second-order displacements")
    bent = bent_body(body, every, parts, condition, U, second_order(U))
    interfaces = tuple(
        replace(interface, H_B=H[:3], H_psi_B=H[3:])
        for interface, H in zip(package.interfaces, bent.of_link, strict=True)
    )
    sums = second_order_sums(body, U, bent.h)
    return replace(package, interfaces=interfaces, second_order=sums)


def from_matrices(
    M: Any,
    K: Any,
    nodes: Array,
    dofs: Array | Sequence[Sequence[int]],
    *,
    body: str,
    interfaces: Mapping[str, Any],
    reference: Mapping[str, Any],
    modes: Sequence[Mapping[str, Any]],
    units: UnitsTable = SI,
    node_ids: IntArray | None = None,
    cells: Sequence[Sequence[int]] | None = None,
    cell_types: Sequence[int] | None = None,
    total_mass: "float | None" = None,
    damping_ratio: float = 0.0,
    tell: Tell = lambda _: None,
) -> ModalPackage:
    """Reduce the mass and stiffness matrix of a free body to a modal package.

    Parameters
    ----------
    M, K : (N, N) matrices of the free body, dense or sparse, both triangles
    nodes : (n, 3) coordinates
    dofs : (N, 2) label of the node and direction (1 to 3 translations, 4 to 6 rotations) of each
        row of the matrices
    body : name
    interfaces, reference, modes : tables of an import file (docs/exchange.md)
    units : of length, mass and time of all arguments
    node_ids : (n,) labels of the nodes; absent: 1 to n
    cells : labels of the nodes of each cell, in the order of VTK; absent: points
    cell_types : VTK types; absent: by the number of nodes (2 line, 3 triangle, 4 quadrilateral,
        8 hexahedron)
    total_mass : mass to compare with [kg]
    damping_ratio : of every mode
    tell : called with the name of each step

    Raises
    ------
    InputError : the matrices are not those of one free body, or a request cannot be fulfilled.
    """
    where = "from_matrices"
    table = {
        "body": body,
        "reference": dict(reference),
        "modes": [dict(mode) for mode in modes],
        "interfaces": {name: dict(entry) for name, entry in interfaces.items()},
        "units": dict(units),
        "damping_ratio": damping_ratio,
        **({} if total_mass is None else {"total_mass": total_mass}),
    }
    try:
        reduction = check_form(table, Reduction)
    except SpecError as error:
        raise InputError(f"{where}: {error}") from error
    points = np.asarray(nodes, dtype=float)
    if points.ndim != 2 or points.shape[1] != 3 or not len(points):
        raise InputError(f"{where}: nodes: expected an array (n, 3), found {points.shape}")
    ids = np.arange(1, len(points) + 1) if node_ids is None else np.asarray(node_ids)
    numbers = np.asarray(dofs)
    if numbers.ndim != 2 or numbers.shape[1] != 2:
        raise InputError(f"{where}: dofs: expected an array (N, 2), found {numbers.shape}")
    source = free_body(
        where, K, M, points, ids, numbers, labelled_cells(cells, cell_types, ids, where)
    )
    return reduce_body(source, reduction, tell)


def _modes(
    body: FreeBody,
    table: Reduction,
    every: list[Link],
    parts: Constrained,
    tell: Tell,
    direct: Solver,
) -> tuple[Modes, Condition]:
    K, M = (parts.T.T @ A @ parts.T for A in (body.K, body.M))
    algebra = Algebra(direct.solve, direct.negative_pivots)
    kind = table["reference"]["kind"]
    carriers = _carriers(body, table, every)
    if kind == "mean-axis":
        still = _six_dofs(parts)
        condition: Condition = MeanAxis(K, M, parts.rigid, algebra, still)
        direct.add_subset(np.setdiff1d(np.arange(K.shape[0]), still))
    else:
        held = [
            parts.reference_dofs[link.name][list(own)]
            for link, own in zip(carriers, HELD[kind], strict=True)
        ]
        condition = HeldDofs(K, M, np.concatenate(held), algebra)
        direct.add_subset(condition.free)
    requests = table["modes"]
    count = sum(r["count"] for r in requests if r["kind"] == "lowest")
    tell(f"{count} vibrations of {K.shape[0]} degrees of freedom")

    def participation(columns: Array) -> Array:
        return _directions(body, np.asarray(parts.T @ columns))

    def name_of(dof: int) -> str:
        return body.labels(int(np.argmax(np.abs(parts.T[:, [dof]].toarray()[:, 0]))))

    kept = _vibrations(condition, count, direct, participation, name_of, body.where)
    loads = _loads(table, every, parts)
    tell(f"{len(loads)} static shapes")
    fields = accelerations(body.nodes[body.dof_node], body.dof_direction)
    at_links = [(link.motion @ parts.T).T.toarray() for link in every]
    unit = np.hstack([*at_links, parts.T.T @ (body.M @ fields)])
    return completed(condition, kept, loads, participation, unit), condition


def _six_dofs(parts: Constrained) -> IntArray:
    """Six dofs far apart that prevent rigid motions."""
    size = float(np.ptp(parts.places, axis=0).max()) or 1.0
    centred = parts.rigid.copy()
    for k, axis in enumerate(np.eye(3)):
        centred[:, 3 + k] -= centred[:, :3] @ np.cross(axis, parts.places.mean(axis=0))
    centred[:, 3:] /= size
    _, pivots = scipy.linalg.qr(centred.T, mode="r", pivoting=True)
    return np.sort(pivots[:6])


def _carriers(body: FreeBody, table: Reduction, every: list[Link]) -> list[Link]:
    """Interfaces that carry the frame: one, two of a chord, or none."""
    reference = table["reference"]
    at = reference.get("at", [])
    names = [at] if isinstance(at, str) else at
    expected = {"clamped": 1, "chord": 2, "mean-axis": 0}[reference["kind"]]
    where = f"{body.where}: reference"
    if len(names) != expected:
        raise InputError(
            f'{where}.at = {at!r}: expected {expected} interface(s) with kind "{reference["kind"]}"'
        )
    by_name = {link.name: link for link in every}
    for name in names:
        if name not in by_name:
            raise InputError(f'{where}.at = "{name}": no such interface{nearest(name, by_name)}')
        if not by_name[name].rigid:
            raise InputError(
                f'{body.where}: interfaces.{name}.link = "average": expected "rigid": it carries '
                "the body frame"
            )
    carriers = [by_name[name] for name in names]
    if expected == 2:
        along = carriers[1].position - carriers[0].position
        if not np.linalg.norm(along[1:]) <= ALONG * np.linalg.norm(along) > 0.0:
            raise InputError(
                f"{where}.at: expected two interfaces on a line along the body's x; {names[0]} is "
                f"at {carriers[0].position.tolist()} m, {names[1]} at "
                f"{carriers[1].position.tolist()} m"
            )
    return carriers


def _loads(table: Reduction, every: list[Link], parts: Constrained) -> list[StaticLoad]:
    by_name = {link.name: link for link in every}
    zero = np.zeros(parts.T.shape[1])
    loads = []
    for i, request in enumerate(table["modes"]):
        if request["kind"] != "attachment":
            continue
        if request["at"] not in by_name:
            hint = nearest(request["at"], by_name)
            raise ModeError(f'modes[{i}].at = "{request["at"]}": no such interface{hint}')
        for direction in request.get("directions", DIRECTIONS):
            row = by_name[request["at"]].motion[DIRECTIONS.index(direction)]
            force = np.asarray((row @ parts.T).todense()).ravel()
            loads.append(StaticLoad(f"attachment {request['at']} {direction}", force, zero))
    return loads


def _directions(body: FreeBody, U: Array) -> Array:
    """Modal mass by main direction of motion: along y, along z, zero, along x; (4, m, m)."""
    diagonal = body.M.diagonal()
    split = []
    for axis in (1, 2, None, 0):
        rows = np.flatnonzero(body.dof_direction == axis) if axis is not None else np.arange(0)
        split.append(U[rows].T @ (diagonal[rows, None] * U[rows]))
    return np.array(split)


def _package(
    body: FreeBody,
    table: Reduction,
    every: list[Link],
    modes: Modes,
    U: Array,
    shapes: Array,
    sums: Inertia,
    ratio: float,
) -> ModalPackage:
    """Nodes of the body, and one node without mass at the reference point of each interface."""
    n, ends = len(body.nodes), len(every)
    motions = [np.asarray(link.motion @ U) for link in every]  # (6, m) each
    first = int(body.node_ids.max(initial=0)) + 1
    labels = first + np.arange(ends)
    interfaces = tuple(
        Interface(
            link.name,
            "node",
            np.array([label], dtype=np.int64),
            np.ones(1),
            link.position,
            link.A_BI,
            motion[:3],
            motion[3:],
        )
        for link, label, motion in zip(every, labels, motions, strict=True)
    )
    plies = body.layups and recovered(body.layups, body.nodes, body.cells, shapes, body.where)
    return ModalPackage(
        **modes.of_package(ratio),
        body=table["body"],
        nodes_B=np.vstack([body.nodes, *(link.position for link in every)]),
        node_ids=np.concatenate([body.node_ids, labels]),
        connectivity=body.cells.connectivity,
        offsets=body.cells.offsets,
        cell_types=body.cells.types,
        shapes_B=np.concatenate([shapes, *(motion.T[:, None] for motion in motions)], axis=1),
        node_mass=np.concatenate([sums.node_mass, np.zeros(ends)]),
        node_inertia_B=np.concatenate([sums.node_inertia, np.zeros((ends, 3, 3))]),
        invariants=sums.invariants,
        interfaces=interfaces,
        reference_condition=table["reference"]["kind"],
        mode_labels=modes.labels,
        laminates=plies.laminates if plies else (),
        cell_resultants=plies.cells if plies else None,
        provenance={
            **provenance(table, body.notes, n, sums.form),
            "warnings": list(modes.warnings),
        },
    )


def _vibrations(
    condition: Condition,
    count: int,
    direct: Solver,
    participation: Participation,
    name_of: Callable[[int], str],
    where: str,
) -> Eigenmodes:
    """The `count` lowest modes: shift-invert Lanczos, and a Sturm count.

    Raises InputError for a motion without stiffness besides the six rigid ones, named with
    `name_of` its largest dof, and for modes that the count does not confirm.
    """
    n_dof = condition.K.shape[0]
    if count == 0:
        return Eigenmodes(np.zeros(0), np.zeros((n_dof, 0)), (), np.zeros((0, len(KINDS))))
    if count + SPARE >= condition.n_finite - 1:
        raise InputError(
            f"{where}: modes: {count} vibrations of a body with {condition.n_finite} massive "
            f"degrees of freedom; expected at most {condition.n_finite - SPARE - 2}"
        )
    spare = SPARE
    for _ in range(ROUNDS):
        values, X = condition.lowest(count + spare, direct.eigenpairs)
        _check_stiffness(condition, values, X, name_of, where)
        # The shift of the count lies between two groups of equal values, at least `count` of them.
        ends = [end for _, end in clusters(values)[:-1] if end >= count]
        if ends:
            middle = 0.5 * float(values[ends[0] - 1] + values[ends[0]])
            if not direct.counts or _count_below(condition, middle) == ends[0]:
                break
        spare *= 2
    else:
        raise InputError(
            f"{where}: modes: the Sturm count does not confirm the {count} lowest modes; expected "
            "matrices without nearly rigid parts"
        )
    values, X = values[: ends[0]], X[:, : ends[0]]
    X = X @ separating_rotation(values, participation(X))
    values, X = values[:count], X[:, :count]
    # the first of the nearly largest entries of a column is positive
    first = np.argmax(np.abs(X) >= 0.999 * np.abs(X).max(axis=0), axis=0)
    X = X * np.where(X[first, np.arange(count)] < 0.0, -1.0, 1.0)
    labels = tuple(f"vibration {i + 1}" for i in range(count))
    return Eigenmodes(values, X, labels, shares_of(participation(X)))


def _count_below(condition: Condition, value: float) -> int:
    """Sturm count; -1 where a front is singular, by chance of the value."""
    try:
        return condition.count_below(value)
    except ArithmeticError:
        return -1


def _check_stiffness(
    condition: Condition, values: Array, X: Array, name_of: Callable[[int], str], where: str
) -> None:
    """Raise InputError for a mode whose value is round-off: a seventh rigid motion."""
    stiffness, mass = condition.K.diagonal(), condition.M.diagonal()
    largest = float((stiffness[mass > 0.0] / mass[mass > 0.0]).max())
    free = np.flatnonzero(values <= SEVENTH * largest)
    if len(free):
        named = "; ".join(name_of(int(np.argmax(np.abs(X[:, i])))) for i in free[:3])
        raise InputError(
            f"{where}: expected six motions without stiffness, found {6 + len(free)}: largest at "
            f"{named}: a mechanism, a hinge, or a degree of freedom without stiffness"
        )
