"""motion.glb and motion.vtkhdf: the mechanism in motion for other programs."""

import json
import struct
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..math.arrays import Array, IntArray
from ..math.disk_cache import file_sha256
from ..package.common.cells import TRIANGLE
from ..package.common.container import new_file, set_text
from ..package.common.files import temporary_sibling
from ..package.common.plain_data import plain
from ..results import BodyGeometry, RunResult, read_result
from ..results.file import frames, write_grid
from ..results.run_result import BodyView
from ..results.surfaces import node_positions
from .scene import frame_rows, one_sign, site_energy, site_exposure
from .style import COLOURS

# The bodies of a result with the surfaces that files of the animation show.


def viewed_bodies(result: RunResult, file: Path) -> list[tuple[BodyGeometry, BodyView]]:
    """Return all bodies of a result with their views; `file` names it in the message.

    Raises
    ------
    InputError
        A body has no view.
    """
    viewed = [(body, body.view) for body in result.bodies if body.view is not None]
    if not viewed or len(viewed) < len(result.bodies):
        raise InputError(
            f"{file}: has no surfaces of bodies; expected a result of format 1.2 or later: "
            "run the case again"
        )
    return viewed


def drawn_points(body: BodyGeometry, view: BodyView) -> tuple[Array, Array]:
    """Rest positions (p, 3) of the points of a surface [m], and their motion per unit mode."""
    node, offset = view.surface.node, view.surface.offset_B
    shapes = view.shapes_B[:, node]
    moved = shapes[..., :3] + np.cross(shapes[..., 3:], offset)
    return body.nodes_B[node] + offset, moved


# motion.glb: the mechanism in motion for Blender, slides and other programs (glTF 2.0, binary).
#
# Node transforms are the motion of the bodies, morph targets their modes. Blender limits the
# values of morph targets to 0 to 1, so a modal coordinate q is written as w = (q - low) / (high -
# low) with the range of the run. The base mesh is at q = low, and a target moves its points by
# high - low. The base mesh is therefore not the undeformed body, as `asset.extras` of the file
# says.

FLOAT, UNSIGNED = 5126, 5125  # component types
VERTICES, INDICES = 34962, 34963  # targets of buffer views
NOTE = (
    "The base mesh of a body is at the lowest value of each modal coordinate, not undeformed; "
    "morph weights go from 0 to 1 between the lowest and the highest value of the run."
)


def write_glb(path: Path, result: RunResult) -> Path:
    """Write motion.glb of a run; return its path. Raises InputError for a result without views."""
    views = viewed_bodies(result, path.parent / "result.vtkhdf")
    t = np.asarray(result.t)
    rows = frame_rows(t, [], 1, len(t))
    out = _File()
    times = out.accessor((t[rows] - t[0]).astype(np.float32), "SCALAR", bounds=True)
    samplers: list[Mapping[str, object]] = []
    channels: list[Mapping[str, object]] = []
    nodes, meshes, materials = [], [], []
    for number, (body, view) in enumerate(views):
        base, targets, weights = _mesh(result, rows, body, view)
        attributes = {"POSITION": out.accessor(base, "VEC3", VERTICES, bounds=True)}
        triangles = view.surface.triangles.ravel().astype(np.uint32)
        primitive: dict[str, object] = {
            "attributes": attributes,
            "indices": out.accessor(triangles, "SCALAR", INDICES),
            "material": number,
        }
        mesh: dict[str, object] = {"name": body.name, "primitives": [primitive]}
        if len(targets):
            moves = [out.accessor(each, "VEC3", VERTICES, bounds=True) for each in targets]
            primitive["targets"] = [{"POSITION": move} for move in moves]
            mesh["weights"] = weights[0].tolist()
            mesh["extras"] = {"targetNames": list(view.labels)}
        meshes.append(mesh)
        materials.append(_material(number, body.name))
        nodes.append({"name": body.name, "mesh": number})
        first = view.first_position
        frame = np.asarray(result.q[rows, first : first + 7])
        turn = one_sign(frame[:, 3:] / np.linalg.norm(frame[:, 3:], axis=1)[:, None])
        histories = {
            "translation": ("VEC3", frame[:, :3]),
            "rotation": ("VEC4", turn[:, [1, 2, 3, 0]]),
        }
        if len(targets):
            histories["weights"] = ("SCALAR", weights.reshape(-1))
        for name, (kind, values) in histories.items():
            output = out.accessor(values.astype(np.float32), kind)
            channels.append({"sampler": len(samplers), "target": {"node": number, "path": name}})
            samplers.append({"input": times, "output": output, "interpolation": "LINEAR"})
    table = {
        "asset": {"version": "2.0", "generator": "Plymotion", "extras": {"note": NOTE}},
        "scene": 0,
        "scenes": [{"name": result.run, "nodes": list(range(len(nodes)))}],
        "nodes": nodes,
        "meshes": meshes,
        "materials": materials,
        "animations": [{"name": result.run, "samplers": samplers, "channels": channels}],
    }
    with temporary_sibling(path) as temporary:
        temporary.write_bytes(out.bytes(table))
    return path


def _mesh(
    result: RunResult, rows: IntArray, body: BodyGeometry, view: BodyView
) -> tuple[Array, Array, Array]:
    """Base mesh (p, 3), targets (m, p, 3) and their weights (k, m), single precision."""
    m, first = len(view.shapes_B), view.first_position
    q = np.asarray(result.q[rows, first + 7 : first + 7 + m])
    low, high = (q.min(axis=0), q.max(axis=0)) if m else (np.zeros(0), np.zeros(0))
    range_ = np.where(high > low, high - low, 1.0)
    rest, moved = drawn_points(body, view)
    base = rest + np.einsum("m,mpa->pa", low, moved)
    weights = (q - low) / range_
    targets = range_[:, None, None] * moved
    return base.astype(np.float32), targets.astype(np.float32), weights.astype(np.float32)


def _material(number: int, name: str) -> dict[str, object]:
    text = COLOURS[number % len(COLOURS)].lstrip("#")
    shade = [(int(text[i : i + 2], 16) / 255.0) ** 2.2 for i in (0, 2, 4)]  # linear light
    surface = {"baseColorFactor": [*shade, 1.0], "metallicFactor": 0.1, "roughnessFactor": 0.6}
    return {"name": name, "doubleSided": True, "pbrMetallicRoughness": surface}


class _File:
    """Buffer, buffer views and accessors of a file."""

    def __init__(self) -> None:
        self._data = bytearray()
        self._views: list[Mapping[str, object]] = []
        self._accessors: list[Mapping[str, object]] = []

    def accessor(
        self,
        values: NDArray[Any],
        kind: str,
        target: int | None = None,
        *,
        bounds: bool = False,
    ) -> int:
        """Add an array (float32 or uint32); return its number. `bounds`: with min and max."""
        view = {"buffer": 0, "byteOffset": len(self._data), "byteLength": values.nbytes}
        self._views.append(view | ({"target": target} if target else {}))
        self._data += np.ascontiguousarray(values).tobytes()
        entry: dict[str, object] = {
            "bufferView": len(self._views) - 1,
            "componentType": UNSIGNED if values.dtype == np.uint32 else FLOAT,
            "count": len(values),
            "type": kind,
        }
        if bounds:
            rows = values.reshape(len(values), -1)
            entry |= {"min": rows.min(axis=0).tolist(), "max": rows.max(axis=0).tolist()}
        self._accessors.append(entry)
        return len(self._accessors) - 1

    def bytes(self, table: dict[str, object]) -> bytes:
        """Return the file: header, JSON and binary chunk, each padded to four bytes."""
        whole = table | {
            "accessors": self._accessors,
            "bufferViews": self._views,
            "buffers": [{"byteLength": len(self._data)}],
        }
        text = json.dumps(whole, separators=(",", ":")).encode("utf-8")
        text += b" " * (-len(text) % 4)
        data = bytes(self._data) + bytes(-len(self._data) % 4)
        size = 12 + 8 + len(text) + 8 + len(data)
        head = struct.pack("<4sII", b"glTF", 2, size)
        json_chunk = struct.pack("<I4s", len(text), b"JSON") + text
        return head + json_chunk + struct.pack("<I4s", len(data), b"BIN\0") + data


# motion.vtkhdf: the surfaces of a run in motion for ParaView, with results in their cells.
#
# Beams have the outline of their sections, shells their mesh, rigid bodies their box. Points move:
# no filter is needed. Each time has the elastic displacement of the points, and in the cells the
# strain energy and the lowest strength ratio of the plies, computed from modal coordinates.

FORMAT, FORMAT_VERSION = "plymotion animation", (1, 0)
MOST_FRAMES = 200
LARGEST_RATIO = 1e6  # in place of infinity, which spoils the colour scale of a picture
# Name of each array: unit, meaning.
POINT_DATA = {"displacement": ("m", "elastic displacement, in the axes of the body")}
CELL_DATA = {
    "strain_energy": (
        "J/m, J/m2, J/m3",
        "for unit length of a beam, area of a shell, volume of a solid at its surface",
    ),
    "strength_ratio": (
        "-",
        "lowest strength ratio R of the plies, at most 1e6; NaN without strengths",
    ),
}


def write_vtk(path: Path, result_file: Path) -> Path:
    """Write motion.vtkhdf of a result; return its path.

    Raises
    ------
    ResultError
        The result cannot be read.
    InputError
        It has no views of its bodies.
    """
    result = read_result(result_file)
    bodies = viewed_bodies(result, result_file)
    rows = frames(len(result.t), MOST_FRAMES)
    with new_file(path) as file:
        set_text(file, "format", FORMAT)
        file.attrs["format_version"] = np.array(FORMAT_VERSION, dtype=np.int64)
        for name, text in (("case", result.case), ("run", result.run), ("units", "SI")):
            set_text(file, name, text)
        set_text(file, "provenance", json.dumps(plain(result.provenance, finite=True)))
        set_text(file, "result_sha256", file_sha256(result_file))
        grid = file.create_group("VTKHDF")
        points, cells = _write_grid(grid, bodies, np.asarray(result.t[rows]))
        drawn = [(view, *drawn_points(body, view)) for body, view in bodies]
        for k, row in enumerate(rows.tolist()):
            frame = _frame(drawn, np.asarray(result.q[row]))
            for name, values in frame.items():
                count = cells if name.startswith("CellData") else points
                grid[name][k * count : (k + 1) * count] = values
    return path


def _write_grid(
    grid: h5py.Group, bodies: list[tuple[BodyGeometry, BodyView]], t: Array
) -> tuple[int, int]:
    """Write what does not move, and room for what does; return numbers of points and cells."""
    surfaces = [view.surface for _, view in bodies]
    points = [len(surface.node) for surface in surfaces]
    cells = [len(surface.triangles) for surface in surfaces]
    starts = np.cumsum([0, *points])
    triangles = np.concatenate(
        [each.triangles + start for each, start in zip(surfaces, starts[:-1], strict=True)]
    )
    n, c, k = sum(points), sum(cells), len(t)
    counts = {body.name: count for (body, _), count in zip(bodies, cells, strict=True)}
    # One part: of each time, its points are further down, its cells are those of the first.
    offsets, types = 3 * np.arange(c + 1), np.full(c, TRIANGLE)
    steps = write_grid(grid, n, triangles.ravel().astype(np.int64), offsets, types, counts, t, n)
    each = np.arange(k, dtype=np.int64)
    _room(grid, "Points", (k * n, 3), n, "m", "global positions")
    for name, (unit, text) in POINT_DATA.items():
        _room(grid, f"PointData/{name}", (k * n, 3), n, unit, text)
        steps[f"PointDataOffsets/{name}"] = each * n
    for name, (unit, text) in CELL_DATA.items():
        _room(grid, f"CellData/{name}", (k * c,), c, unit, text)
        steps[f"CellDataOffsets/{name}"] = each * c
    return n, c


def _room(
    grid: h5py.Group, name: str, shape: tuple[int, ...], rows: int, unit: str, text: str
) -> None:
    """Add a dataset of single precision that is filled by `rows` rows at a time."""
    pieces: dict[str, object] = {"chunks": (max(rows, 1), *shape[1:])} if shape[0] else {}
    squeeze = {"compression": "gzip", "compression_opts": 1, "shuffle": True} if pieces else {}
    dataset = grid.create_dataset(name, shape, np.float32, **pieces, **squeeze)
    set_text(dataset, "unit", unit)
    set_text(dataset, "description", text)


def _frame(drawn: list[tuple[BodyView, Array, Array]], state: Array) -> dict[str, Array]:
    """Return all arrays of one time by their names; `state` is a row of the result's q.

    drawn : view of each body, with its `drawn_points`
    """
    names = (
        "Points",
        *(f"PointData/{n}" for n in POINT_DATA),
        *(f"CellData/{n}" for n in CELL_DATA),
    )
    parts: list[tuple[Array, ...]] = []
    for view, rest, shapes in drawn:
        first = view.first_position
        q = state[first + 7 : first + 7 + len(shapes)]
        (places,) = node_positions(state[None], first, rest, shapes)
        parts.append((places, np.einsum("m,mpa->pa", q, shapes), *_of_cells(view, q)))
    return {
        name: np.concatenate(each)
        for name, each in zip(names, zip(*parts, strict=True), strict=True)
    }


def _of_cells(view: BodyView, q: Array) -> tuple[Array, Array]:
    """Strain energy and strength ratio (f,) of the triangles: the worst of the sites at corners."""
    site = view.surface.site
    if view.sites is None or not len(q):
        return np.zeros(len(site)), np.full(len(site), np.nan)
    energy = _worst(site_energy(view.sites, q[None])[0], site)
    exposure = _worst(site_exposure(view.sites, q[None])[0], site)
    return np.nan_to_num(energy), 1.0 / np.maximum(exposure, 1.0 / LARGEST_RATIO)


def _worst(values: Array, site: IntArray) -> Array:
    """Largest value at the corners of triangles; NaN where none is known."""
    at_corners = np.append(values, np.nan)[site]  # site -1 is the last: NaN
    return np.asarray(np.fmax.reduce(at_corners, axis=1))
