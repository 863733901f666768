"""Specifications of small shells, as `plymotion shell` writes them."""

from pathlib import Path
from typing import Any

import numpy as np

from plymotion.preprocess import fenicsx
from plymotion.preprocess.shell.shell_cells import ShellMesh
from plymotion.preprocess.shell.shell_mesh import mesh_of

SCRIPTS = Path(__file__).resolve().parents[2] / "meshes" / "shells"
METAL = {"kind": "isotropic", "E": 70e9, "nu": 0.3, "rho": 2700.0}
CFRP = {
    "kind": "orthotropic",
    **{"E1": 129.2e9, "E2": 9.4e9, "E3": 9.4e9},
    **{"G12": 5.2e9, "G13": 4.3e9, "G23": 2.5e9},
    **{"nu12": 0.3, "nu13": 0.3, "nu23": 0.22},
    "rho": 1550.0,
}
EDGES = ("left", "right", "bottom", "top")
HARD = {  # hard simple support of a plate in z = 0, and no motion in its plane
    name: {"at": name, "fixed": ["ux", "uy", "uz", turn, "rz"]}
    for name, turn in (("left", "rx"), ("right", "rx"), ("bottom", "ry"), ("top", "ry"))
}


def plate(
    n: int | tuple[int, int], h: float, length: float = 1.0, width: float = 1.0, **tables: Any
) -> dict[str, Any]:
    """An isotropic plate of thickness h on n x n cells, each cut into two triangles."""
    nx, ny = (n, n) if isinstance(n, int) else n
    size = {"length": length, "width": width, "n_length": nx, "n_width": ny}
    return {
        "name": "plate",
        "mesh": {"file": str(SCRIPTS / "plate.py"), "parameters": size},
        "materials": {"metal": METAL},
        "regions": {"all": {"material": "metal", "thickness": h}},
        **tables,
    }


def box(n: tuple[int, int, int] = (10, 2, 2), **tables: Any) -> dict[str, Any]:
    """A box beam of CFRP, regions top, right, bottom, left, each wall its own laminate."""
    size = dict(zip(("n_length", "n_width", "n_height"), n, strict=True))
    angles = {"top": [15, -20], "right": [30, 0], "bottom": [-15, 40], "left": [0, 90]}
    laminates = {
        name: {
            "plies": [{"material": "cfrp", "angle_deg": float(a), "thickness": 3.8e-4} for a in two]
        }
        for name, two in angles.items()
    }
    regions = {name: {"laminate": name, "axis": [1.0, 0.0, 0.0]} for name in angles}
    return {
        "name": "box",
        "mesh": {"file": str(SCRIPTS / "box-beam.py"), "parameters": size},
        "materials": {"cfrp": CFRP},
        "laminates": laminates,
        "regions": regions,
        "supports": {"root": {"at": "root", "fixed": "all"}},
        **tables,
    }


def mesh_from(points: Any, cells: Any, region: Any = None, **curves: Any) -> ShellMesh:
    """A mesh of arrays; curves are lists of node pairs."""
    points, cells = np.array(points, dtype=float), np.array(cells, dtype=np.int64)
    rows = np.zeros(len(cells), dtype=np.int64) if region is None else np.array(region)
    names = tuple(f"s{row + 1}" for row in range(rows.max() + 1))
    tags = np.arange(1, len(points) + 1)
    pairs = {name: np.array(lines, dtype=np.int64) for name, lines in curves.items()}
    named = fenicsx.NamedNodes(tags, pairs, {})
    return mesh_of(fenicsx.PlainMesh(points, cells, "triangle", 1, rows, names, {}, named))
