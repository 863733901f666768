"""motion.vtkhdf: the surfaces of a run in motion for ParaView, with results in their cells.

Beams have the outline of their sections, shells their mesh, rigid bodies their box. Points move:
no filter is needed. Each time has the elastic displacement of the points, and in the cells the
strain energy and the lowest strength ratio of the plies, computed from modal coordinates.
"""

import json
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from ..math.arrays import Array, IntArray
from ..math.digests import file_sha256
from ..math.rotations import rotation_matrices
from ..package.common.container import new_file, set_text
from ..package.common.identity import write_file_checksum
from ..package.shell.cells import TRIANGLE
from ..results import BodyGeometry, read_result
from ..results.summary import plain
from ..results.view import BodyView
from ..results.writer import frames
from .sites import site_energy, site_exposure
from .surfaces import viewed_bodies

FORMAT, FORMAT_VERSION = "plymotion animation", (1, 0)
MOST_FRAMES = 200
LARGEST_RATIO = 1e6  # in place of infinity, which spoils the colour scale of a picture
# Name of each array: unit, meaning.
POINT_DATA = {"displacement": ("m", "elastic displacement, in the axes of the body")}
CELL_DATA = {
    "strain_energy": ("J/m, J/m2", "for unit length of a beam, for unit area of a shell"),
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
        set_text(file, "provenance", json.dumps(plain(result.provenance)))
        set_text(file, "result_sha256", file_sha256(result_file))
        grid = file.create_group("VTKHDF")
        points, cells = _write_grid(grid, bodies, np.asarray(result.t[rows]))
        for k, row in enumerate(rows.tolist()):
            found = _frame(bodies, np.asarray(result.q[row]))
            for name, values in found.items():
                count = cells if name.startswith("CellData") else points
                grid[name][k * count : (k + 1) * count] = values
        write_file_checksum(file)
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
    grid.attrs["Version"] = np.array([2, 2], dtype=np.int64)
    grid.attrs.create("Type", np.bytes_("UnstructuredGrid"), dtype="S16")
    grid["Connectivity"] = triangles.ravel().astype(np.int64)
    grid["Offsets"] = 3 * np.arange(c + 1, dtype=np.int64)
    grid["Types"] = np.full(c, TRIANGLE, dtype=np.uint8)
    # One part: of each time, its points are further down, its cells are those of the first.
    for name, count in (("Points", n), ("Cells", c), ("ConnectivityIds", 3 * c)):
        grid[f"NumberOf{name}"] = np.array([count], dtype=np.int64)
    grid["CellData/body_id"] = np.repeat(np.arange(len(bodies)), cells).astype(np.int64)
    set_text(grid["CellData/body_id"], "names", json.dumps([body.name for body, _ in bodies]))
    steps = grid.create_group("Steps")
    steps.attrs["NSteps"] = np.int64(k)
    steps["Values"] = t
    set_text(steps["Values"], "unit", "s")
    each = np.arange(k, dtype=np.int64)
    steps["NumberOfParts"] = np.ones(k, dtype=np.int64)
    steps["PartOffsets"] = np.zeros(k, dtype=np.int64)
    steps["PointOffsets"] = each * n
    for name in ("CellOffsets", "ConnectivityIdOffsets"):
        steps[name] = np.zeros((k, 1), dtype=np.int64)
    steps["CellDataOffsets/body_id"] = np.zeros(k, dtype=np.int64)
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
    pieces: dict[str, Any] = {"chunks": (max(rows, 1), *shape[1:])} if shape[0] else {}
    squeeze = {"compression": "gzip", "compression_opts": 1, "shuffle": True} if pieces else {}
    dataset = grid.create_dataset(name, shape, np.float32, **pieces, **squeeze)
    set_text(dataset, "unit", unit)
    set_text(dataset, "description", text)


def _frame(bodies: list[tuple[BodyGeometry, BodyView]], state: Array) -> dict[str, Array]:
    """Return all arrays of one time by their names; `state` is a row of the result's q."""
    names = (
        "Points",
        *(f"PointData/{n}" for n in POINT_DATA),
        *(f"CellData/{n}" for n in CELL_DATA),
    )
    parts: list[tuple[Array, ...]] = []
    for body, view in bodies:
        first, surface = view.first_position, view.surface
        frame = state[first : first + 7]
        q = state[first + 7 : first + 7 + len(view.shapes_B)]
        moved = np.einsum("m,mna->na", q, view.shapes_B)
        u = moved[surface.node, :3] + np.cross(moved[surface.node, 3:], surface.offset_B)
        local = body.nodes_B[surface.node] + surface.offset_B + u
        turn = rotation_matrices((frame[3:] / np.linalg.norm(frame[3:]))[None])[0]
        parts.append((frame[:3] + local @ turn.T, u, *_of_cells(view, q)))
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
