"""Meshes of meshes/shells as plain arrays, and of a few cells as files of gmsh."""

import runpy
from collections.abc import Mapping, Sequence
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


def gmsh_file(
    path: Path,
    points: Sequence[Sequence[float]],
    cells: Sequence[Sequence[int]],
    region: str,
    curves: Mapping[str, Sequence[Sequence[int]]] | None = None,
) -> str:
    """Write cells (3 or 4 rows of points each) of one region, and sides of curves; the path."""
    groups = [(2, region, cells), *((1, name, ends) for name, ends in (curves or {}).items())]
    names = [f'{d} {tag} "{name}"' for tag, (d, name, _) in enumerate(groups, 1)]
    kinds = {2: 1, 3: 2, 4: 3}
    elements = [
        f"{kinds[len(nodes)]} 2 {tag} {tag} " + " ".join(str(node + 1) for node in nodes)
        for tag, (_, _, rows) in enumerate(groups, 1)
        for nodes in rows
    ]
    nodes = [" ".join(map(repr, map(float, point))) for point in points]
    lines = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat"]
    lines += ["$PhysicalNames", str(len(names)), *names, "$EndPhysicalNames"]
    for title, rows in (("Nodes", nodes), ("Elements", elements)):
        numbered = [f"{i} {row}" for i, row in enumerate(rows, 1)]
        lines += [f"${title}", str(len(rows)), *numbered, f"$End{title}"]
    path.write_text("\n".join(lines) + "\n")
    return str(path)
