"""motion.glb: the mechanism in motion for Blender, slides and other programs (glTF 2.0, binary).

Node transforms are the motion of the bodies, morph targets their modes. Blender limits the values
of morph targets to 0 to 1, so a modal coordinate q is written as w = (q - low) / (high - low) with
the range of the run. The base mesh is at q = low, and a target moves its points by high - low. The
base mesh is therefore not the undeformed body, as `asset.extras` of the file says.
"""

import json
import struct
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..math.arrays import Array, IntArray
from ..package.common.temporary import temporary_sibling
from ..results import BodyGeometry, RunResult
from ..results.view import BodyView
from .embed.frames import frame_rows, one_sign
from .style import COLOURS
from .surfaces import viewed_bodies

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
    samplers: list[dict[str, Any]] = []
    channels: list[dict[str, Any]] = []
    nodes, meshes, materials = [], [], []
    for number, (body, view) in enumerate(views):
        base, targets, weights = _mesh(result, rows, body, view)
        attributes = {"POSITION": out.accessor(base, "VEC3", VERTICES, bounds=True)}
        triangles = view.surface.triangles.ravel().astype(np.uint32)
        primitive: dict[str, Any] = {
            "attributes": attributes,
            "indices": out.accessor(triangles, "SCALAR", INDICES),
            "material": number,
        }
        mesh: dict[str, Any] = {"name": body.name, "primitives": [primitive]}
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
    node, offset = view.surface.node, view.surface.offset_B
    shapes = view.shapes_B[:, node]
    moved = shapes[:, :, :3] + np.cross(shapes[:, :, 3:], offset[None])
    base = body.nodes_B[node] + offset + np.einsum("m,mpa->pa", low, moved)
    weights = (q - low) / range_
    targets = range_[:, None, None] * moved
    return base.astype(np.float32), targets.astype(np.float32), weights.astype(np.float32)


def _material(number: int, name: str) -> dict[str, Any]:
    text = COLOURS[number % len(COLOURS)].lstrip("#")
    shade = [(int(text[i : i + 2], 16) / 255.0) ** 2.2 for i in (0, 2, 4)]  # linear light
    surface = {"baseColorFactor": [*shade, 1.0], "metallicFactor": 0.1, "roughnessFactor": 0.6}
    return {"name": name, "doubleSided": True, "pbrMetallicRoughness": surface}


class _File:
    """Buffer, buffer views and accessors of a file."""

    def __init__(self) -> None:
        self._data = bytearray()
        self._views: list[dict[str, Any]] = []
        self._accessors: list[dict[str, Any]] = []

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
        entry: dict[str, Any] = {
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

    def bytes(self, table: dict[str, Any]) -> bytes:
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
