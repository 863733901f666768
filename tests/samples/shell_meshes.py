"""Meshes of meshes/shells as plain arrays."""

import runpy
from pathlib import Path
from typing import Any

from plymotion.preprocess import fenicsx

FOLDER = Path(__file__).resolve().parents[2] / "meshes" / "shells"


def shell_mesh(name: str, **parameters: float) -> Any:
    """The `fenicsx.PlainMesh` of a script of meshes/shells."""
    path = FOLDER / f"{name}.py"
    with fenicsx.gmsh_session() as gmsh:
        gmsh.clear()
        runpy.run_path(str(path))["build"](gmsh, parameters)
        return fenicsx.plain_from_model(str(path), 3)
