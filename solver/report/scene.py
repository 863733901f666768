"""The moving bodies of a run for the view of the page: motion, results at sites, joints.

results/run_result.py has the equations of motion. Sites are stations of a beam, cells of a shell,
faces of a solid; their strain energy and exposure are computed here for the page and for the files
of the animation.
"""

from collections.abc import Callable, Iterator

import numpy as np

from ..dynamics.elements.forces.table import FORCES
from ..math.arrays import Array, IntArray
from ..package.common.materials import PlyStrength, YieldStrength
from ..results import BodyGeometry, RunResult
from ..results.run_result import BodyView, Link, Loads, Side, Sites, Surface
from ..results.summary import findings
from ..results.surfaces import halved, prism, unit_sphere
from ..strength import criteria_of
from ..strength.criteria.von_mises import equivalent_stress
from .inline import Blob
from .report_data import Story

SITES_AT_ONCE = 2_000_000  # numbers in memory at a time


def site_energy(sites: Sites, q: Array) -> Array:
    """Strain energy for unit length, area or volume, (k, s) [J/m, J/m2, J/m3], at q (k, m)."""
    F = np.einsum("sjm,km->ksj", sites.resultants_E, q, optimize=True)
    C = sites.compliance[sites.kind]
    return np.asarray(0.5 * np.einsum("ksi,sij,ksj->ks", F, C, F, optimize=True))


def site_exposure(sites: Sites, q: Array) -> Array:
    """Largest exposure 1/R of the governing points under all criteria, (k, s) [-].

    NaN where no ply has strengths.
    """
    return _of_points(sites, q, _exposures)[0]


def site_stress(sites: Sites, q: Array) -> Array:
    """Largest stress of the governing points, (k, s) [Pa]; NaN where no ply has strengths.

    Of a ply the magnitude along the fibre, of an isotropic material von Mises' equivalent stress.
    """
    return _of_points(sites, q, _stresses)[0]


def _weakest_ply(sites: Sites, exposure: Array, point: IntArray) -> IntArray:
    """Row in `plies` of the ply with the largest exposure over the times, (s,); -1 without.

    exposure, point : of the governing point of each site and time (k, s)
    """
    known = np.asarray(np.isfinite(exposure).all(axis=0))
    time = np.argmax(np.nan_to_num(exposure), axis=0)
    return np.where(known, sites.point_ply[point[time, np.arange(len(known))]], -1)


Points = Callable[[Sites, IntArray, Array], Array]  # stresses (k, s, p, 6) of points to (k, s, p)


def _of_points(sites: Sites, q: Array, of_points: Points) -> tuple[Array, IntArray]:
    """Largest value of the governing points of each site, (k, s), and the point that has it."""
    most = np.full((len(q), len(sites.kind)), np.nan)
    which = np.zeros(most.shape, dtype=np.int64)
    for kind in range(len(sites.compliance)):
        own = np.flatnonzero(sites.kind == kind)
        points = np.flatnonzero(sites.point_kind == kind)
        if not len(points):
            continue
        some = max(1, SITES_AT_ONCE // (6 * len(points) * max(len(q), 1)))
        for first in range(0, len(own), some):
            rows = own[first : first + some]
            F = np.einsum("sjm,km->ksj", sites.resultants_E[rows], q, optimize=True)
            stress_M = np.einsum("pij,ksj->kspi", sites.stress_M[points], F, optimize=True)
            values = of_points(sites, points, stress_M)
            most[:, rows] = values.max(axis=2)
            which[:, rows] = points[np.argmax(values, axis=2)]
    return most, which


def _exposures(sites: Sites, points: IntArray, stress_M: Array) -> Array:
    exposures = np.zeros(stress_M.shape[:3])
    for strength, same in _strengths(sites, points):
        some = stress_M[:, :, same]
        each = [criterion.assess(some, strength).exposure for criterion in criteria_of(strength)]
        exposures[:, :, same] = np.max(each, axis=0)
    return exposures


def _stresses(sites: Sites, points: IntArray, stress_M: Array) -> Array:
    stresses = np.abs(stress_M[..., 0])
    for strength, same in _strengths(sites, points):
        if isinstance(strength, YieldStrength):
            stresses[:, :, same] = equivalent_stress(stress_M[:, :, same])
    return stresses


def _strengths(
    sites: Sites, points: IntArray
) -> Iterator[tuple[PlyStrength | YieldStrength, IntArray]]:
    """Yield each strength with the places in `points` of the points that have it."""
    tables = [sites.plies[ply]["strength"] for ply in sites.point_ply[points].tolist()]
    for k, table in enumerate(tables):
        if table in tables[:k]:
            continue
        kind = YieldStrength if "yield_stress" in table else PlyStrength
        yield kind(**table), np.array([j for j, each in enumerate(tables) if each == table])


# Times of the animation, and the ranges of its colours over all output times.

MOST, FEWEST = 400, 60  # times of the animation of a run
NUMBERS = 250_000  # of the animations of a page
HALF = 32767  # steps on both sides of zero, of two bytes
AT_ONCE = 4_000_000  # numbers in memory at a time


def frame_rows(t: Array, peaks: list[float], width: int, share: int) -> IntArray:
    """Rows of evenly spaced output times, with the first, the last and those of peaks.

    Parameters
    ----------
    t : output times (k,) [s]
    peaks : times that are kept [s]
    width : numbers of one time
    share : numbers that this run may take
    """
    most = min(max(share // max(width, 1), FEWEST), MOST, len(t))
    even = np.linspace(0, len(t) - 1, most).round().astype(int)
    nearest = [int(np.argmin(np.abs(t - peak))) for peak in peaks]
    return np.unique(np.concatenate([even, np.array(nearest, dtype=int)]))


def one_sign(parameters: Array) -> Array:
    """Euler parameters (k, 4) with the sign of their neighbours, so that they interpolate."""
    same = (parameters[1:] * parameters[:-1]).sum(axis=1) >= 0
    signs = np.cumprod(np.concatenate([[1.0], np.where(same, 1.0, -1.0)]))
    return np.asarray(parameters * signs[:, None])


def largest_energy(view: BodyView, q: Array) -> float:
    """Largest strain energy for unit length or area of all sites and times.

    q : (k, m) modal coordinates at all output times
    """
    sites = view.sites
    if sites is None or not q.shape[1]:
        return 0.0
    C, R = sites.compliance[sites.kind], sites.resultants_E
    G = 0.5 * np.einsum("sim,sij,sjl->sml", R, C, R, optimize=True)
    one, two = np.triu_indices(q.shape[1])
    pairs = G[:, one, two] * np.where(one == two, 1.0, 2.0)
    step = max(1, AT_ONCE // max(len(pairs), len(one), 1))
    largest = 0.0
    for first in range(0, len(q), step):
        some = q[first : first + step]
        largest = max(largest, float((pairs @ (some[:, one] * some[:, two]).T).max(initial=0.0)))
    return largest


def largest_displacement(view: BodyView, q: Array) -> float:
    """Largest elastic displacement of all nodes and times [m]; q as above."""
    m = q.shape[1]
    if not m:  # taken as rigid
        return 0.0
    U = view.shapes_B[:, :, :3].reshape(m, 3 * view.shapes_B.shape[1])
    step = max(1, AT_ONCE // max(U.shape[1], 1))
    largest = 0.0
    for first in range(0, len(q), step):
        displacements = (q[first : first + step] @ U).reshape(-1, 3)
        largest = max(
            largest, float(np.einsum("ni,ni->n", displacements, displacements).max(initial=0.0))
        )
    return float(np.sqrt(largest))


# Shapes of joints.

WIDTH = 0.012  # of a glyph, over the size of the scene
MOST_WIDTH = 0.04  # the same, of the joint of a thick beam
OUTSIDE = 1.1  # width of a joint, over the radius of its beam
SHIFTS = ("x", "y", "z")


def glyph(free: tuple[str, ...], width: float) -> tuple[Array, IntArray]:
    """Return points (p, 3) of a joint, in its axes, and triangles (f, 3); none of a fixed one.

    What turns about an axis is a cylinder along it, what slides a bar, what does both a longer
    cylinder, what moves in a plane a disc, what turns about all axes a ball (on a line with it).

    Parameters
    ----------
    free : free directions of the joint: x, y, z, about x, about y, about z (results/run_result.py)
    width : of the joint [m]
    """
    turns = [each for each in free if each not in SHIFTS]
    shifts = len(free) - len(turns)
    ball, cells = unit_sphere()
    if not free:
        return np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64)
    if free == ("about z",):
        return prism(20, 0.9 * width, 1.3 * width)
    if shifts == 2:
        return prism(20, 2.0 * width, 0.3 * width)
    if shifts != 1:
        return width * ball, halved(cells)
    if len(turns) == 3:
        line, sides = prism(8, 0.3 * width, 2.5 * width)
        faces = np.concatenate([sides, halved(cells) + len(line)])
        return np.concatenate([line, width * ball]), faces
    return prism(20 if turns else 4, 0.7 * width, 2.5 * width)


def joint_width(body: BodyGeometry, view: BodyView, side: Side, size: float) -> float:
    """Width of a joint [m], enough to be seen outside the beam that carries it.

    Parameters
    ----------
    body : the body that carries the joint
    view : its surface
    side : place of the joint on the body
    size : size of the scene [m]
    """
    least = WIDTH * size
    if not view.provenance:  # a box, not a package
        return 1.5 * least
    node = int(np.argmin(np.linalg.norm(body.nodes_B - side.position_B, axis=1)))
    around = np.linalg.norm(view.surface.offset_B[view.surface.node == node], axis=1)
    return min(max(least, OUTSIDE * float(around.max(initial=0.0))), MOST_WIDTH * size)


# The ground: places on it are drawn as a body without motion, which has no surface of its own.
STILL = np.array([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0])
_NO, _NONE = np.zeros(0), np.zeros(0, dtype=np.int64)
_NOTHING = Surface(_NONE, np.zeros((0, 3)), _NONE.reshape(0, 3), _NONE, _NONE.reshape(0, 3))
_VIEW = BodyView(
    0, np.zeros((0, 0, 6)), np.zeros((0, 0)), _NO, (), 0.0, np.zeros(3), lambda: _NOTHING
)
GROUND = BodyGeometry("ground", np.zeros((0, 3)), _NONE, _NONE, _NONE, _VIEW)

TRIANGLES = 60_000  # of a body; of more, every n-th is shown


def scene(blob: Blob, story: Story, share: int) -> dict[str, object] | None:
    """Add the bodies and joints of a run; None if the result is older than views.

    Parameters
    ----------
    blob : arrays of the page, added to
    story : a run, with results and summary
    share : numbers that its animation may take
    """
    result = story.result
    if not result.bodies or any(body.view is None for body in result.bodies):
        return None
    t = np.asarray(result.t)
    width = sum(7 + len(body.view.shapes_B) for body in result.bodies if body.view is not None)
    known = [body.view.sites for body in result.bodies if body.view is not None]
    sites = sum(len(each.kind) for each in known if each is not None)
    rows = frame_rows(t, _peaks(story), width, share)
    field_rows = frame_rows(t, _peaks(story), sites, share)
    points = np.asarray(result.node_positions_G[rows])
    usable = points.reshape(-1, 3)[np.isfinite(points).all(axis=2).ravel()]
    own = list(result.links)
    ground = [side.position_B[None] for link in own for side in link.sides if side.body < 0]
    usable = np.concatenate([usable, *ground])
    low, high = usable.min(axis=0), usable.max(axis=0)
    origin, size = 0.5 * (low + high), float(np.linalg.norm(high - low)) or 1.0
    drawn = [*enumerate(result.bodies), *([(-1, GROUND)] if ground else [])]
    bodies = [
        _body(blob, result, i, body, body.view, rows, field_rows, origin, own, size)
        | {"exposure": _largest_exposure(story, body.name)}
        for i, body in drawn
        if body.view is not None
    ]
    return {
        "t": blob.add(t[rows], "<f8"),
        "field_t": blob.add(t[field_rows], "<f8"),  # times of the fields of sites
        "origin": origin,
        "size": size,
        "extent": high - low,
        "up": _up(story.inputs.get("gravity")),
        "bodies": bodies,
        "joints": _pairs(own, result.bodies),
        "loads": _loads(blob, result.loads, origin, share),
    }


def _up(gravity: object) -> int:
    """Return the axis against gravity, 1 or 2; 0: there is none, or it is along x or changes."""
    if not isinstance(gravity, list) or not all(isinstance(v, int | float) for v in gravity):
        return 0
    axis = int(np.argmax(np.abs(gravity)))
    return axis if gravity[axis] < 0.0 else 0


def _loads(blob: Blob, loads: Loads | None, origin: Array, share: int) -> dict[str, object] | None:
    """Add forces and moments of joints and force elements, and where they act."""
    if loads is None:
        return None
    rows = slice(None, None, max(1, -(-9 * len(loads.t) * len(loads.names) // max(share // 4, 1))))
    arrays = {
        "place": loads.place_G - origin,
        "force": loads.load_G[..., :3],
        "moment": loads.load_G[..., 3:],
    }
    table: dict[str, object] = {"names": loads.names, "t": blob.add(loads.t[rows], "<f8")}
    for name, values in arrays.items():  # (r, n, 3) in steps of the largest, enough for a picture
        top = float(np.abs(values).max(initial=0.0)) or 1.0
        steps = blob.add(np.round(HALF + HALF * (values[rows] / top)), "<u2")
        length = float(np.linalg.norm(values, axis=2).max(initial=0.0))
        table[name] = {"top": top, "steps": steps, "longest": length}
    return table


def _peaks(story: Story) -> list[float]:
    """Times that the page jumps to: peaks of signals, of plies, and of findings."""
    summary = story.summary
    times = [s.get(key) for s in summary.get("signals", {}).values() for key in ("t_min", "t_max")]
    for body in summary.get("strength", {}).values():
        times += [body.get("time"), *(ply.get("time") for ply in body.get("plies", [])[:5])]
    times += [finding.t for finding in findings(summary)]
    return [float(value) for value in times if value is not None]


def _largest_exposure(story: Story, body: str) -> float:
    """Largest exposure 1/R of a body over the run, at most 1; 0 without strengths."""
    ratio = story.summary.get("strength", {}).get(body, {}).get("ratio")
    return min(1.0, 1.0 / ratio) if ratio else 0.0


def _body(
    blob: Blob,
    result: RunResult,
    number: int,
    body: BodyGeometry,
    view: BodyView,
    rows: IntArray,
    field_rows: IntArray,
    origin: Array,
    links: list[Link],
    size: float,
) -> dict[str, object]:
    m, first = len(view.shapes_B), view.first_position
    q = np.asarray(result.q[:, first + 7 : first + 7 + m])
    motion, still = np.tile(STILL, (len(rows), 1)), origin
    if number >= 0:
        motion, still = np.array(result.q[rows, first : first + 7]), np.zeros(3)
        motion[:, :3] -= origin
        motion[:, 3:] = one_sign(motion[:, 3:])
    surface, nodes, shapes = view.surface, [body.nodes_B], [np.moveaxis(view.shapes_B, 0, 1)]
    count = len(body.nodes_B)
    node, offset = [surface.node], [surface.offset_B]
    every = max(1, -(-len(surface.triangles) // TRIANGLES))
    triangles, edges = [surface.triangles[::every]], [surface.edges[::every]]
    site, kind = [surface.site[::every]], [np.zeros(len(triangles[0]), dtype=np.int64)]
    for link in links:
        for side in link.sides:
            if side.body != number:
                continue
            if number < 0:
                points, faces = prism(4, 0.8 * WIDTH * size, 0.8 * WIDTH * size)
            else:
                points, faces = glyph(link.free, joint_width(body, view, side, size))
            triangles.append(faces + sum(len(part) for part in node))
            node.append(np.full(len(points), count))
            offset.append(points @ side.A_BM.T)
            nodes.append(side.position_B[None] - still)
            shapes.append(np.concatenate([side.phi_B, side.psi_B]).T[None])
            edges.append(np.zeros(len(faces), dtype=np.int64))
            site.append(np.full(faces.shape, -1))
            kind.append(np.ones(len(faces), dtype=np.int64))
            count += 1
    q_rows = q[rows]
    return {
        "name": body.name,
        "modes": m,
        "labels": view.labels,
        "motion": blob.add(motion),
        "q": blob.add(q_rows),
        "nodes": blob.add(np.concatenate(nodes)),
        "shapes": blob.add(np.concatenate(shapes)),  # (n, m, 6)
        "node": blob.add(np.concatenate(node), "<u4"),
        "offset": blob.add(np.concatenate(offset)),
        "triangles": blob.add(np.concatenate(triangles), "<u4"),
        "edges": blob.add(np.concatenate(edges), "|u1"),
        "site": blob.add(np.concatenate(site) + 1, "<u4"),  # 0: none
        "kind": blob.add(np.concatenate(kind), "|u1"),  # 1: joint
        "left_out": every,
        "displacement": largest_displacement(view, q),
        "energy": largest_energy(view, q),
        "sites": None if view.sites is None or not m else _sites(blob, view.sites, q[field_rows]),
    }


STEPS = 255  # of the colours of a field: one byte


def _sites(blob: Blob, sites: Sites, q: Array) -> dict[str, object]:
    """Fields of the sites at the times of `q` (k, m), and of each mode alone.

    A field is stored in steps of 1/255 of its largest value, which is what colours can show. The
    energy of one mode is the square of its coordinate times that at 1. Exposures and stresses are
    proportional to the coordinate, so those of one mode follow from those at 1 and at -1.
    """
    unit = np.eye(q.shape[1])
    both = np.concatenate([unit, -unit])
    fields = {"energy": (site_energy(sites, q), site_energy(sites, unit))}
    table: dict[str, object] = {"dimension": sites.dimension}
    if len(sites.stress_M):
        exposure, point = _of_points(sites, q, _exposures)
        fields["exposure"] = exposure, site_exposure(sites, both)
        fields["stress"] = site_stress(sites, q), site_stress(sites, both)
        used, ply = np.unique(_weakest_ply(sites, exposure, point), return_inverse=True)
        table["ply"] = blob.add(ply, "|u1" if len(used) < STEPS else "<u4")
        table["plies"] = [_ply_name(sites, row) for row in used.tolist()]
    for name, (found, alone) in fields.items():
        values = np.nan_to_num(found)
        top = float(values.max(initial=0.0)) or 1.0
        table[name] = {
            "top": top,
            "steps": blob.add(np.round(STEPS / top * values), "|u1"),  # (k, s)
            "alone": blob.add(np.nan_to_num(alone)),  # (m or 2m, s)
        }
    return table


def _ply_name(sites: Sites, row: int) -> str:
    ply = sites.plies[row]
    angle = f", {ply['angle_deg']:g} deg" if "yield_stress" not in (ply["strength"] or {}) else ""
    return f"{ply['region']} ply {ply['index']}: {ply['material']}{angle}" if row >= 0 else "none"


def _pairs(links: list[Link], bodies: tuple[BodyGeometry, ...]) -> list[dict[str, object]]:
    """Both sides of each joint: body and row of its nodes; of the ground a position."""
    counts = {number: len(body.nodes_B) for number, body in enumerate(bodies)}
    pairs = []
    for link in links:
        sides = []
        for side in link.sides:
            sides.append({"body": side.body, "node": counts.get(side.body, -1)})
            if side.body < 0:
                sides[-1]["at"] = side.position_B.tolist()
            elif side.body in counts:
                counts[side.body] += 1
        coil = link.kind in FORCES
        pairs.append({"name": link.name, "kind": link.kind, "sides": sides, "coil": coil})
    return pairs
