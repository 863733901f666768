"""What pictures of a run need: surface, modes and resultants of every body, and the joints."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cache, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..dynamics.elements.forces.table import FORCES
from ..dynamics.elements.joints.contract import FREEDOMS
from ..dynamics.elements.joints.table import JOINTS
from ..dynamics.evaluation.series import loads_of_markers
from ..math.arrays import Array, IntArray, distinct
from ..math.laws import lengths_along
from ..math.rows import LongRows
from ..mechanism.built_mechanism import BuiltMechanism
from ..package import ModalPackage
from ..package.section.stress import strengths
from ..results import BodyGeometry
from ..results.datasets import MOST_NAMED
from ..results.file import frames
from ..results.outline import Outline, section_outline
from ..results.run_result import BodyView, Link, Loads, Side, Sites, Surface
from ..results.surfaces import (
    LINES,
    Ball,
    extruded,
    faces,
    frames_along,
    picture_surface,
    rigid_surface,
    spokes,
    square,
    uniform_box,
    with_spheres,
)
from ..strength.search import Points, governing_points
from ..strength.weakest_plies import cell_centres, stressed_cells, unit_stress_M

if TYPE_CHECKING:
    from ..inputs.case.tables.schema import Mechanism

GLYPH = 0.012  # width of a bar without a known section, over the length of the body
LOADED = 200  # times at which pictures show loads
TIMES = 40  # that the governing points of a section are chosen from


def with_views(
    bodies: tuple[BodyGeometry, ...],
    built: BuiltMechanism,
    y: Array | LongRows,
    balls: Mapping[int, Sequence[Ball]],
    pictures: Mapping[str, Path],
) -> tuple[BodyGeometry, ...]:
    """Return the drawn bodies with what they need to be shown in motion.

    Parameters
    ----------
    y : (k, n_pos + n_vel) states at the output times
    balls : point masses by the number of their body
    pictures : STL files of rigid bodies by name
    """
    model = built.model
    times = distinct(np.linspace(0, len(y) - 1, TIMES).round().astype(int))
    states = np.asarray(y[times])
    reach = max((_size(body.nodes_B) for body in bodies), default=0.0)
    viewed = []
    # By the identity of the package, or what a rigid body is drawn from: bodies may share one.
    surfaces: dict[Any, Callable[[], Surface]] = {}
    for i, body in enumerate(bodies):
        package, first = built.packages.get(body.name), int(model.pos_start[i])
        mass = float(model.mass[i])
        if package is None:
            own, S_B, J_B = _without_points(built, i)
            edges, axes_B = uniform_box(own, S_B, J_B)
            box_B = S_B / own if own > 0.0 else np.zeros(3)
            # Beside a large neighbour, a small body is still to be seen.
            width = 2.0 * GLYPH * (max(_size(body.nodes_B), 0.5 * reach) or 0.1)
            centre_B = model.S0[i] / mass if mass else np.zeros(3)
            drawn = body.nodes_B, box_B, edges, axes_B, width, reach or np.inf
            key: Any = tuple(np.asarray(part).tobytes() for part in drawn)
            draw = partial(rigid_surface, *drawn)
            if body.name in pictures and pictures[body.name].is_file():
                key, draw = body.name, partial(picture_surface, body.nodes_B, pictures[body.name])
            if key not in surfaces:
                surfaces[key] = cache(draw)
            view = BodyView(
                first_position=first,
                shapes_B=np.zeros((0, len(body.nodes_B), 6)),
                stiffness=np.zeros((0, 0)),
                frequencies=np.zeros(0),
                labels=(),
                mass=mass,
                centre_B=centre_B,
                draw=surfaces[key],
            )
        else:
            q = states[:, first + 7 : first + 7 + package.n_mode]
            if id(package) not in surfaces:
                surfaces[id(package)] = cache(partial(_surface, package))
            view = _flexible(package, first, q, surfaces[id(package)])
        if i in balls:
            with_balls = partial(_with_balls, view.draw, body.nodes_B, balls[i], reach)
            view = replace(view, draw=with_balls)
        viewed.append(replace(body, view=view))
    return tuple(viewed)


def point_masses(mechanism: "Mechanism", built: BuiltMechanism) -> dict[int, list[Ball]]:
    """Return place [m] and mass [kg] of the point masses of a case by the number of their body."""
    balls: dict[int, list[Ball]] = {}
    for mass in mechanism.masses.values():
        body, place = built.places[mass.at]
        balls.setdefault(body, []).append((place.position_B, mass.mass))
    return balls


def pictures(mechanism: "Mechanism") -> dict[str, Path]:
    """Return the STL files of rigid bodies by name."""
    files = {name: getattr(body, "picture", None) for name, body in mechanism.bodies.items()}
    return {name: Path(file) for name, file in files.items() if file is not None}


def _with_balls(
    draw: Callable[[], Surface], nodes_B: Array, balls: Sequence[Ball], reach: float
) -> Surface:
    return with_spheres(draw(), nodes_B, balls, reach)


def _without_points(built: BuiltMechanism, body: int) -> tuple[float, Array, Array]:
    """Return mass, first moment and inertia of a body about its origin, without point masses."""
    model = built.model
    mass, S, J = float(model.mass[body]), model.S0[body].copy(), model.J0[body].copy()
    for marker, m in built.point_masses:
        if model.marker_body[marker] == body:
            x = model.marker_x[marker]
            mass, S = mass - m, S - m * x
            J -= m * (x @ x * np.eye(3) - np.outer(x, x))
    return mass, S, J


def _size(nodes_B: Array) -> float:
    return float(np.linalg.norm(np.ptp(nodes_B, axis=0)))


def links(mechanism: "Mechanism", built: BuiltMechanism) -> tuple[Link, ...]:
    """Return joints, and forces that are drawn as coils, with the markers on both sides."""
    drawn = []
    for name, joint in built.joints.items():
        if joint.rows:
            one, two = built.model.joint_marker[joint.rows[0]].tolist()
            free = tuple(f for f in FREEDOMS if f not in JOINTS[joint.kind].removes)
            drawn.append(Link(name, joint.kind, (_side(built, one), _side(built, two)), free))
    for name, (one, two) in zip(built.force_names, built.model.force_marker.tolist(), strict=False):
        force = mechanism.forces.get(name)
        if force is not None and FORCES[force.kind].coil:
            drawn.append(Link(name, force.kind, (_side(built, one), _side(built, two))))
    return tuple(drawn)


def drawn_loads(
    built: BuiltMechanism, t: Array, y: Array | LongRows, multipliers: Array | LongRows
) -> Loads | None:
    """Return the loads of joints and force elements for pictures; None without, or of too many.

    On the second place of each, at some of the output times t (k,), with states y (k, n) and
    multipliers (k, n_c).

    Parameters
    ----------
    built : the built mechanism
    t : output times (k,) [s]
    y : states (k, n)
    multipliers : multipliers of the constraints (k, n_c)
    """
    model, names = built.model, [*built.joints, *built.force_names]
    # Rows of `loads_of_markers`: both sides of every joint table, then of every force element.
    places = [[2 * row + 1 for row in joint.rows] for joint in built.joints.values()]
    after = model.joint_marker.size
    places += [[after + 2 * k + 1] for k in range(len(built.force_names))]
    known = [k for k, rows in enumerate(places) if rows]
    if not 0 < len(known) <= MOST_NAMED:
        return None
    times = frames(len(t), LOADED)
    rows = np.asarray(y[times]), np.asarray(multipliers[times])
    loads, origins = loads_of_markers(model, t[times], *rows)
    return Loads(
        tuple(names[k] for k in known),
        t[times],
        np.stack([origins[:, places[k][0]] for k in known], axis=1),
        np.stack([loads[:, places[k]].sum(axis=1) for k in known], axis=1),
    )


def _side(built: BuiltMechanism, marker: int) -> Side:
    model = built.model
    body = int(model.marker_body[marker])
    m = int(model.n_mode[body]) if body >= 0 else 0
    start = int(model.marker_start[marker])
    phi, psi = (
        flat[start : start + 3 * m].reshape(3, m) for flat in (model.marker_phi, model.marker_psi)
    )
    return Side(body, model.marker_x[marker], model.marker_A[marker], phi, psi)


def _flexible(package: ModalPackage, first: int, q: Array, draw: Callable[[], Surface]) -> BodyView:
    sites = _stations(package, q) or _cells(package, q)
    known = {key: package.provenance[key] for key in PROVENANCE if key in package.provenance}
    return BodyView(
        first_position=first,
        shapes_B=package.shapes_B,
        stiffness=package.stiffness,
        frequencies=package.frequencies,
        labels=package.mode_labels or package.mode_kinds,
        mass=package.invariants.mass,
        centre_B=package.invariants.S0_B / package.invariants.mass,
        draw=draw,
        sites=sites,
        provenance=known,
    )


PROVENANCE = ("inputs_sha256", "versions", "command", "source")


def _surface(package: ModalPackage) -> Surface:
    nodes, n = package.nodes_B, len(package.nodes_B)
    if not np.isin(package.cell_types, LINES).all():
        site = np.full(len(package.cell_types), -1)
        cells, _ = stressed_cells(package)
        if cells is not None:
            site[cells.cell] = np.arange(len(cells.cell))
        return faces(package.connectivity, package.offsets, package.cell_types, site)
    line = np.column_stack([np.arange(n - 1), np.arange(1, n)]).ravel()
    if not np.array_equal(package.connectivity, line):
        return spokes(nodes, GLYPH * _size(nodes))
    outlines, first_B = _outlines(package)
    ends, starts = _stations_of_nodes(package)
    return extruded(nodes, outlines, frames_along(nodes, first_B), ends, starts)


def _outlines(package: ModalPackage) -> tuple[list[Outline], Array | None]:
    """Return the outline of each element, or one for all, and the axes at the first node."""
    recovery, n = package.recovery, len(package.nodes_B)
    outlines = [section_outline(s.recovery) if s.recovery else None for s in package.sections]
    known = [k for k, outline in enumerate(outlines) if outline is not None]
    if recovery is None or not known:
        width = GLYPH * float(np.linalg.norm(np.diff(package.nodes_B, axis=0), axis=1).sum())
        return [square(width)], None
    # Sections between analysed stations have no cells: they are drawn by those around them.
    middle = [float(recovery.station_x[recovery.section == k].mean()) for k in range(len(outlines))]
    whole = [
        outline or _between([(middle[j], o) for j in known if (o := outlines[j])], middle[k])
        for k, outline in enumerate(outlines)
    ]
    _, starts = _stations_of_nodes(package)
    return [whole[int(recovery.section[starts[e]])] for e in range(n - 1)], recovery.A_BE


def _between(known: list[tuple[float, Outline]], x: float) -> Outline:
    """Return the outline at x of known ones along a beam: the nearer one, in between in size."""
    known = sorted(known, key=lambda pair: pair[0])
    places = [place for place, _ in known]
    near = min((abs(place - x), k) for k, place in enumerate(places))[1]
    low, high = (
        np.array([getattr(o.points, side)(axis=0) for _, o in known]) for side in ("min", "max")
    )
    begin, end = (
        np.array([np.interp(x, places, corners[:, a]) for a in (0, 1)]) for corners in (low, high)
    )
    share = (known[near][1].points - low[near]) / (high[near] - low[near])
    return known[near][1]._replace(points=begin + share * (end - begin))


def _stations_of_nodes(package: ModalPackage) -> tuple[IntArray, IntArray]:
    """Stations of each node (n,) as end of an element and as start of one; -1 without any."""
    n = len(package.nodes_B)
    if package.recovery is None:
        return np.full(n, -1), np.full(n, -1)
    along = lengths_along(package.nodes_B)
    x = package.recovery.station_x - package.recovery.station_x[0]
    near = 1e-6 * (along[-1] or 1.0)
    last = len(x) - 1
    ends = np.minimum(np.searchsorted(x, along - near), last)
    starts = np.clip(np.searchsorted(x, along + near) - 1, 0, last)
    return ends, starts


def _stations(package: ModalPackage, q: Array) -> Sites | None:
    recovery = package.recovery
    if recovery is None or not package.n_mode:
        return None
    along, x = lengths_along(package.nodes_B), recovery.station_x - recovery.station_x[0]
    place = np.column_stack([np.interp(x, along, package.nodes_B[:, a]) for a in range(3)])
    parts = []
    for section in package.sections:
        r = section.recovery
        if r is None:
            parts.append(Points(np.zeros((0, 6, 6)), np.zeros(0, dtype=np.int64), {}))
            continue
        known = strengths(r)
        of_ply = {k: known[p.material] for k, p in enumerate(r.plies) if p.material in known}
        parts.append(Points(unit_stress_M(r), r.ply, of_ply))
    plies = [[vars(p) for p in s.recovery.plies] if s.recovery else [] for s in package.sections]
    compliance = np.array([np.linalg.inv(s.K) for s in package.sections])
    return _sites(place, recovery.resultants_E, recovery.section, compliance, parts, plies, q)


def _cells(package: ModalPackage, q: Array) -> Sites | None:
    cells, laminates = stressed_cells(package)
    if cells is None or not package.n_mode or not len(cells.cell):
        return None
    parts, plies, compliance = [], [], []
    for laminate in laminates:
        known = strengths(laminate)
        _, levels, _, r = laminate.stress_M.shape
        of_ply = {k: known[p.material] for k, p in enumerate(laminate.plies) if p.material in known}
        ply = np.repeat(np.arange(len(laminate.plies)), levels)
        parts.append(Points(laminate.stress_M.reshape(-1, 6, r), ply, of_ply))
        plies.append(
            [
                {"region": laminate.name, "index": k, "material": p.material}
                | {"angle_deg": p.angle_deg}
                for k, p in enumerate(laminate.plies)
            ]
        )
        C = np.zeros((r, r))
        C[:6, :6], C[6:, 6:] = np.linalg.inv(laminate.ABD), np.linalg.inv(laminate.Ds)
        compliance.append(C)
    place = cell_centres(package, cells)
    R, kind = cells.resultants_E, cells.laminate
    sites = _sites(place, R, kind, np.array(compliance), parts, plies, q)
    return replace(sites, dimension=2 if package.face_stresses is None else 3)


def _sites(
    place_B: Array,
    resultants_E: Array,
    kind: IntArray,
    compliance: Array,
    parts: list[Points],
    of_parts: list[list[dict[str, object]]],
    q: Array,
) -> Sites:
    """Put sites together with the points that govern at the times of q (t, m)."""
    stress, point_kind, point_ply = [], [], []
    plies: list[dict[str, object]] = []
    for k, points in enumerate(parts):
        rows = governing_points(points, resultants_E[kind == k], q)
        stress.append(points.stress_M[rows])
        point_kind.append(np.full(len(rows), k))
        point_ply.append(points.ply[rows] + len(plies))
        plies += [
            {**ply, "strength": vars(points.strengths[j]) if j in points.strengths else None}
            for j, ply in enumerate(of_parts[k])
        ]
    return Sites(
        place_B=place_B,
        resultants_E=resultants_E,
        kind=kind,
        compliance=compliance,
        stress_M=np.concatenate(stress),
        point_kind=np.concatenate(point_kind),
        point_ply=np.concatenate(point_ply),
        plies=tuple(plies),
    )
