"""One station of a blade: its mesh and its section description."""

import itertools
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.interpolate import PchipInterpolator

from ...errors import InputError, nearest
from ...math.arrays import Array
from ...math.laws import lengths_along
from ...package.common.files import write_text
from ...package.common.plain_data import toml_text
from .layers import (
    THINNEST,
    Band,
    StationMesh,
    WebLayers,
    add_web,
    breaks,
    crossing,
    enclosed,
    feet_of,
    fitted,
    foot_without_room,
    joined,
    level_under,
    material_of,
    rows_of,
    thickness,
    wall_of_edge,
    with_face,
)
from .materials import GLUE, is_soft
from .shape import Layer, contour, edge_angle
from .windio import Blade, region_name

# Mesh of a station: quadrilaterals in columns and rows, webs between inner nodes of the shell.

COLUMNS = 160  # along the contour, without those at ends of layers
ROOM = 0.9  # share of the room between the two sides that walls may fill
MITRE = np.radians(165.0)  # angle of the trailing edge from which the walls meet in a mitre
BLUNT = np.radians(90.0)  # the same if both walls fit into the edge
ROUND = 3.0  # height of an edge over the thickness of a wall, for both walls with room between them
EDGE_GAP = 0.7  # distance of both sides over the thickness of a wall, where a sharp edge is cut
NEXT = 0.9  # of the spacing of columns: those nearer do not limit the wall
LEAST = 0.2  # of the length of a cell outside, its length inside
PASSES = 6  # at most, until feet of webs are as wide as their layers
FITTED = 5e-3  # change of a width that is small enough
CLOSE = 0.15  # columns nearer than this share of the spacing are one


def station_mesh(
    points: Array, bands: list[Band], webs: list[WebLayers], edge: Band
) -> StationMesh:
    """Mesh the shell of a contour and its webs.

    Parameters
    ----------
    points : (n, 2) contour from the trailing edge over suction side and leading edge back [m]
    bands : layers of the shell, from outside inwards
    webs : in any order; they must not cross
    edge : material that closes a trailing edge too sharp for a mitre; its thickness is a length

    Raises
    ------
    InputError : feet of webs that overlap, or webs that cross; the message begins with the key.
    """
    mesh = StationMesh()
    points, corners = with_face(points, bands)
    mitred, (low, high) = _edge(points, wall_of_edge(bands))
    if mitred:
        points = _closed(points)
    s = lengths_along(points)
    perimeter = float(s[-1])
    rows = [joined(row, perimeter) for row in rows_of(bands)]
    nose = float(s[len(points) // 2]) / perimeter
    ends = [low, *corners, high]
    fixed = [*ends, nose] if any(band.angle_deg for band in bands) else ends
    room = corners or (low, high)
    if refused := crossing(webs, nose) or foot_without_room(webs, perimeter, *room):
        raise InputError(refused)
    for last in [False] * PASSES + [True]:
        arcs = _columns(rows, webs, perimeter, fixed)
        outer = _smooth(points, s / perimeter, arcs)
        normals = _normals(points, s / perimeter, arcs, outer, ends, mitred)
        t, lost = _thickness(rows, webs, arcs, outer, normals, perimeter)
        inner = outer + t.sum(axis=0)[:, None] * normals
        wider, change = fitted(webs, arcs, inner, perimeter)
        if change < FITTED or last or foot_without_room(wider, perimeter, *room):
            break
        webs = wider
    mesh.removed = _removed(rows, perimeter, low, high, lost)
    depth = np.vstack([np.zeros(len(arcs)), np.cumsum(t, axis=0)])
    numbers = _grid(mesh, outer, normals, depth, mitred)
    _shell(mesh, rows, arcs, numbers, t, nose)
    for web in webs:
        add_web(mesh, web, arcs, numbers[-1], perimeter, perimeter / COLUMNS)
    if not mitred:
        _trailing_edge(mesh, numbers, edge)
    return mesh


def _thickness(
    rows: list[list[Band]],
    webs: list[WebLayers],
    arcs: Array,
    outer: Array,
    normals: Array,
    perimeter: float,
) -> tuple[Array, float]:
    """Thickness of rows at columns [m], and the area without room over the perimeter [m]."""
    t = np.array([thickness(row, arcs, perimeter) for row in rows])
    full = t.sum(axis=0)
    limit = _uncrossed(_gradual(_room(arcs, outer, normals), outer), full, outer, normals)
    share = np.where(full > limit, limit / np.where(full > 0.0, full, 1.0), 1.0)
    spacing = np.gradient(arcs)
    removed = float(((1.0 - share) * full * spacing).sum())
    t *= share
    for web in webs:
        level_under(web, t, arcs, perimeter)
    t[t < THINNEST] = 0.0
    return t, removed


def _edge(points: Array, wall: float) -> tuple[bool, tuple[float, float]]:
    """Whether the walls meet in a mitre at the trailing edge, and the arcs where they end.

    A flat or round edge that is high beside the wall has walls that go around it; others are cut.
    """
    s = lengths_along(points)
    arcs = _cut(points, s / s[-1], max(EDGE_GAP * wall, 1e-3))
    one, two = _smooth(points, s / s[-1], np.array(arcs))
    angle = edge_angle(points)
    blunt = angle >= BLUNT and float(np.linalg.norm(two - one)) >= ROUND * wall
    return (True, (0.0, 1.0)) if blunt or angle >= MITRE else (False, arcs)


def _closed(points: Array) -> Array:
    """The contour from the middle of a low face and back to it."""
    if np.allclose(points[0], points[-1], rtol=0.0, atol=1e-9):
        return points
    middle = 0.5 * (points[:1] + points[-1:])
    return np.vstack([middle, points, middle])


def _removed(
    rows: list[list[Band]], perimeter: float, low: float, high: float, lost: float
) -> float:
    """Share of the layers' area without room: `lost`, and what lies behind the cut of the edge."""
    arcs = np.linspace(0.0, 1.0, 20 * COLUMNS + 1)
    full = np.array([thickness(row, arcs, perimeter) for row in rows]).sum(axis=0)
    beyond = np.where((arcs < low) | (arcs > high), full, 0.0)
    return (lost + float(np.trapezoid(beyond, arcs))) / float(np.trapezoid(full, arcs))


def _cut(points: Array, arcs: Array, gap: float) -> tuple[float, float]:
    """Arcs at which both sides are `gap` apart, near the trailing edge and not on its face."""
    n = len(points)
    width = np.linalg.norm(points[: n // 2] - points[: n - n // 2 - 1 : -1][: n // 2], axis=1)
    wide = width >= gap
    wide[: _blunt(points)] = False
    k = int(np.argmax(wide)) if wide.any() else n // 4
    if k == 0:
        return 0.0, 1.0
    f = (gap - width[k - 1]) / max(width[k] - width[k - 1], 1e-30)
    f = 1.0 if width[k - 1] >= gap else f  # the end of the face
    one = arcs[k - 1] + f * (arcs[k] - arcs[k - 1])
    two = arcs[n - k] + f * (arcs[n - 1 - k] - arcs[n - k])
    return float(one), float(two)


def _blunt(points: Array) -> int:
    """Number of points at either end whose contour is the face of the trailing edge: across x2."""
    most = len(points) // 20
    one, two = np.diff(points[: most + 1], axis=0), np.diff(points[: -most - 2 : -1], axis=0)
    steep = [np.abs(d[:, 1]) > np.abs(d[:, 0]) for d in (one, two)]
    across = np.flatnonzero(steep[0] | steep[1])
    return int(across[-1]) + 1 if across.size else 0


def _columns(
    rows: list[list[Band]], webs: list[WebLayers], perimeter: float, ends: list[float]
) -> Array:
    """Arcs of the columns: `ends` (of the contour, and its corners), ends of layers and feet of
    webs exactly, others between them."""
    low, high = min(ends), max(ends)
    spacing = 1.0 / COLUMNS
    feet = [feet_of(web, perimeter, spacing) for web in webs]
    wanted = [float(arc) for both in feet for arc in both.ravel()]

    def under(arc: float) -> bool:
        return any(foot.min() < arc < foot.max() for both in feet for foot in both)

    wanted += [arc for arc in ends if not under(arc)]  # the nose may be under a foot
    apart = CLOSE * min(spacing, 0.01 / perimeter)
    for arc in sorted(arc for row in rows for arc in breaks(row, perimeter)):
        near = min(abs(arc - other) for other in wanted) <= apart
        if low < arc < high and not under(arc) and not near:
            wanted.append(arc)
    fixed = sorted(wanted)
    columns = [fixed[0]]
    for one, two in itertools.pairwise(fixed):
        count = max(1, round((two - one) / spacing))
        columns += [one + (two - one) * k / count for k in range(1, count + 1)]
    return np.array(columns)


def _smooth(points: Array, at: Array, arcs: Array) -> Array:
    at, first = np.unique(at, return_index=True)
    return np.asarray(PchipInterpolator(at, points[first])(arcs))


def _normals(
    points: Array, at: Array, arcs: Array, outer: Array, corners: Sequence[float], mitred: bool
) -> Array:
    """Inward normals (n, 2) at arcs; at a corner so long that the walls keep their thickness.

    Chords that reach as far as a column to both sides give the direction. Those between columns
    would not do: beside a foot of a web, one is a millimetre long and the next a hundred.

    Parameters
    ----------
    points, at : the contour and its arcs
    outer : its points at `arcs`
    corners : columns where the contour ends or has a corner
    """
    normals = _mitres(outer, mitred)
    reach = np.abs(arcs[:, None] - np.array(corners)).min(axis=1)
    reach = np.minimum(reach, 1.0 / COLUMNS)
    smooth = reach > 0.0
    chords = _smooth(points, at, arcs + reach) - _smooth(points, at, arcs - reach)
    normal = _sense(outer) * np.column_stack([-chords[:, 1], chords[:, 0]])
    normals[smooth] = normal[smooth] / np.linalg.norm(normal[smooth], axis=1)[:, None]
    return normals


def _sense(outer: Array) -> float:
    """1 if the contour is counter-clockwise, so that inside is to the left of it; -1 if not."""
    return float(np.sign(enclosed(outer)))


def _mitres(outer: Array, mitred: bool) -> Array:
    """Inward normals (n, 2) between the chords of columns."""
    steps = np.diff(outer, axis=0)
    steps /= np.linalg.norm(steps, axis=1)[:, None]
    side = _sense(outer) * np.column_stack([-steps[:, 1], steps[:, 0]])
    before = np.vstack([side[-1] if mitred else side[0], side])
    after = np.vstack([side, side[0] if mitred else side[-1]])
    both = before + after
    return np.asarray(both / np.maximum(0.5 * (both * both).sum(axis=1), 0.2)[:, None])


def _room(arcs: Array, outer: Array, normals: Array) -> Array:
    """How thick the wall may be at each column, so that the two sides do not meet [m].

    Columns nearer than their spacing do not count: beside a foot of a web they are a millimetre
    apart, where small errors of the normal would look like a strong curvature.
    """
    direction = normals / np.linalg.norm(normals, axis=1)[:, None]
    room = np.full(len(outer), np.inf)
    for k in range(len(outer)):
        d = outer - outer[k]
        ahead = d @ direction[k]
        size = (d * d).sum(axis=1)
        # The largest circle that touches the contour here and holds no other point of it.
        usable = (ahead > 1e-9) & (np.abs(arcs - arcs[k]) > NEXT / COLUMNS)
        radius = size[usable] / (2.0 * ahead[usable])
        room[k] = ROOM * float(radius.min(initial=np.inf))
    return room


def _gradual(limit: Array, outer: Array) -> Array:
    """A limit that changes no faster along the contour than by its length."""
    steps = np.linalg.norm(np.diff(outer, axis=0), axis=1)
    limited = limit.copy()
    for k in range(len(steps)):
        limited[k + 1] = min(limited[k + 1], limited[k] + steps[k])
    for k in range(len(steps) - 1, -1, -1):
        limited[k] = min(limited[k], limited[k + 1] + steps[k])
    return limited


def _uncrossed(limit: Array, full: Array, outer: Array, normals: Array) -> Array:
    """A limit with which neighbouring columns do not cross: the inner face keeps its direction."""
    steps = np.diff(outer, axis=0)
    limited = limit.copy()
    for _ in range(60):
        inner = outer + np.minimum(full, limited)[:, None] * normals
        along = (np.diff(inner, axis=0) * steps).sum(axis=1)
        crossed = np.flatnonzero(along < LEAST * (steps * steps).sum(axis=1))
        if not crossed.size:
            break
        at = np.unique(np.concatenate([crossed, crossed + 1]))
        limited[at] = 0.8 * np.minimum(full, limited)[at]
        limited = _gradual(limited, outer)
    return limited


def _grid(
    mesh: StationMesh, outer: Array, normals: Array, depth: Array, mitred: bool
) -> list[list[int]]:
    """Node numbers, row by row: of the outer surface first; rows of no thickness share nodes."""
    n = len(outer)
    last = n - 1 if mitred else n
    numbers: list[list[int]] = []
    for row, level in enumerate(depth):
        line: list[int] = []
        for k in range(last):
            if row and level[k] - depth[row - 1][k] <= 0.0:
                line.append(numbers[-1][k])
            else:
                line.append(mesh.node(outer[k] + level[k] * normals[k]))
        if mitred:
            line.append(line[0])
        numbers.append(line)
    mesh.outer = [(a, b) for a, b in zip(numbers[0][:-1], numbers[0][1:], strict=True)]
    return numbers


def _shell(
    mesh: StationMesh,
    rows: list[list[Band]],
    arcs: Array,
    numbers: list[list[int]],
    t: Array,
    nose: float,
) -> None:
    """Cells of the shell. Angles of the file turn fibres to the leading edge on both sides."""
    middle = 0.5 * (arcs[:-1] + arcs[1:])
    for k, row in enumerate(rows):
        for j, arc in enumerate(middle):
            if max(t[k, j], t[k, j + 1]) <= 0.0:
                continue
            band = material_of(row, float(arc))
            if band.angle_deg and arc > nose:
                band = replace(band, name=f"{band.name}-pressure", angle_deg=-band.angle_deg)
            above, below = numbers[k], numbers[k + 1]
            corners = (above[j], above[j + 1], below[j + 1], below[j])
            mesh.cell(corners, band)


def _trailing_edge(mesh: StationMesh, numbers: list[list[int]], edge: Band) -> None:
    """A plate that closes the cut trailing edge, behind the ends of both walls."""
    down = [line[0] for line in numbers]
    up = [line[-1] for line in reversed(numbers)]
    one, two = (np.array(mesh.nodes[k]) for k in (down[-1], up[0]))
    steps = max(2, len(numbers) - 1)
    between = [mesh.node(one + (two - one) * k / steps) for k in range(1, steps)]
    face = list(dict.fromkeys([*down, *between, *up]))
    across = np.array(mesh.nodes[face[-1]]) - np.array(mesh.nodes[face[0]])
    aft = np.array([across[1], -across[0]]) / np.linalg.norm(across)
    centre = np.array(mesh.nodes).mean(axis=0)
    if aft @ (np.array(mesh.nodes[face[0]]) - centre) < 0.0:
        aft = -aft
    behind = [mesh.node(np.array(mesh.nodes[k]) + edge.thickness * aft) for k in face]
    for k in range(len(face) - 1):
        mesh.cell((face[k], face[k + 1], behind[k + 1], behind[k]), edge)
    mesh.directions[edge.name] = (float(-across[0]), float(-across[1]))


# One station of a blade: its mesh and its section description.

THIN = 1e-4  # [m] layers below are not there: files write them where a layer ends
EDGE = "trailing-edge"  # region of the plate that closes a sharp trailing edge
PLATE = 0.004  # its thickness over the chord


def write_station(blade: Blade, r: float, name: str, folder: Path) -> StationMesh:
    """Write folder/name.msh and folder/name.toml of the station at r of 0 to 1.

    Parameters
    ----------
    blade : blade of the windIO file
    r : place along the span, 0 to 1
    name : name of the files
    folder : folder of the files

    Raises
    ------
    InputError : the station has no layers, an unknown material, or webs whose feet overlap.
    """
    bands = bands_of(blade, r)
    if not bands:
        raise InputError(f"{blade.file}: no layer of the shell at r = {r:g}")
    edge = Band(EDGE, _glue(blade, bands), 0.0, PLATE * blade.chord.at(r), 0.0, 1.0)
    try:
        mesh = station_mesh(contour(blade, r), bands, webs_of(blade, r), edge)
    except InputError as error:
        raise InputError(f"{blade.file}: station r = {r:g}: {error}") from error
    for band in mesh.bands.values():
        if band.material not in blade.materials:
            hint = nearest(band.material, blade.materials)
            raise InputError(
                f"{blade.file}: layer {band.name}: no material {band.material!r}{hint}"
            )
    folder.mkdir(parents=True, exist_ok=True)
    write_text(folder / f"{name}.msh", _msh(mesh))
    write_text(folder / f"{name}.toml", _description(blade, r, name, mesh))
    return mesh


def bands_of(blade: Blade, r: float) -> list[Band]:
    """Return the layers of the shell at r, from outside inwards."""
    shell = [layer for layer in blade.layers if not layer.web and _is_there(layer, r)]
    return [band for layer in shell for band in _parts(layer, r)]


def webs_of(blade: Blade, r: float) -> list[WebLayers]:
    """Return the webs at r that have layers."""
    webs = []
    for web in blade.webs:
        layers = [_band(n, r) for n in blade.layers if n.web == web.name and _is_there(n, r)]
        if layers and web.start.covers(r) and web.end.covers(r):
            webs.append(WebLayers(web.name, web.start.at(r), web.end.at(r), tuple(layers)))
    return webs


def _is_there(layer: Layer, r: float) -> bool:
    """Files give layers that do not reach from root to tip on a part of the grid only."""
    span = layer.end.at(r) - layer.start.at(r) + _wraps(layer, r)
    there = layer.thickness.covers(r) and (
        bool(layer.web) or (layer.start.covers(r) and layer.end.covers(r))
    )
    return there and layer.thickness.at(r) > THIN and (bool(layer.web) or span > 1e-3)


def _wraps(layer: Layer, r: float) -> bool:
    """True if a layer goes around the trailing edge: it begins on the pressure side."""
    return layer.start.at(r) > 0.5 > layer.end.at(r)


def _parts(layer: Layer, r: float) -> list[Band]:
    """A layer of the shell as bands; one around the trailing edge as two."""
    band = _band(layer, r)
    if not _wraps(layer, r):
        return [band]
    both = replace(band, end=1.0), replace(band, name=f"{band.name}-suction", start=0.0)
    return [part for part in both if part.end - part.start > 1e-3]


def _glue(blade: Blade, bands: list[Band]) -> str:
    """Material of the plate: that of the file's adhesive, or of the innermost layer at the edge.

    A "resin" or an adhesive whose stiffness is a placeholder would leave the section open.
    """
    named = [
        name
        for name, material in blade.materials.items()
        if GLUE in name.lower() and not is_soft(material)
    ]
    behind = [band.material for band in bands if band.start <= 0.0]
    return blade.glue or next(iter([*named, *reversed(behind), bands[-1].material]))


def _band(layer: Layer, r: float) -> Band:
    start, end = max(layer.start.at(r), 0.0), min(layer.end.at(r), 1.0)
    return Band(
        region_name(layer.name),
        layer.material,
        layer.angle.at(r),
        layer.thickness.at(r),
        start,
        end,
    )


def _msh(mesh: StationMesh) -> str:
    """The mesh in gmsh's format 2.2."""
    names = list(mesh.bands)
    lines = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$PhysicalNames", str(len(names) + 1)]
    lines.append('1 1 "outer"')
    lines += [f'2 {number + 2} "{name}"' for number, name in enumerate(names)]
    lines += ["$EndPhysicalNames", "$Nodes", str(len(mesh.nodes))]
    lines += [f"{k + 1} {x!r} {y!r} 0" for k, (x, y) in enumerate(mesh.nodes)]
    lines += ["$EndNodes", "$Elements", str(len(mesh.outer) + len(mesh.cells))]
    number = 0
    for edge in mesh.outer:
        number += 1
        lines.append(f"{number} 1 2 1 1 " + " ".join(str(k + 1) for k in edge))
    for cell, region in zip(mesh.cells, mesh.regions, strict=True):
        number += 1
        kind, tag = (2 if len(cell) == 3 else 3), names.index(region) + 2
        lines.append(f"{number} {kind} 2 {tag} {tag} " + " ".join(str(k + 1) for k in cell))
    return "\n".join([*lines, "$EndElements", ""])


def _description(blade: Blade, r: float, name: str, mesh: StationMesh) -> str:
    regions: dict[str, dict[str, object]] = {}
    for region, band in mesh.bands.items():
        regions[region] = {"material": band.material}
        if blade.materials[band.material]["kind"] == "orthotropic":
            vector = mesh.directions.get(region)
            direction = {"curve": "outer"} if vector is None else {"vector": list(vector)}
            regions[region] |= {"angle_deg": band.angle_deg, "direction": direction}
    used = sorted({band.material for band in mesh.bands.values()})
    table = {
        "format": 1,
        "title": f"{blade.file.stem}, r = {r:g}",
        **({"convention": "contour"} if any(b.angle_deg for b in mesh.bands.values()) else {}),
        "mesh": {"file": f"{name}.msh"},
        "materials": {material: blade.materials[material] for material in used},
        "regions": regions,
    }
    remarks = (
        f"# Station r = {r:g}, written by `plymotion blade`.\n"
        "# x2 to the leading edge, x3 to the suction side, origin on the reference axis.\n\n"
    )
    return remarks + toml_text(table)
