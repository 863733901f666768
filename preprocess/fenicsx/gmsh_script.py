"""Run gmsh: scripts with parameters, and mesh files."""

import inspect
import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from .gmsh_model import MeshError, plain_from_model
from .plain import PlainMesh
from .stack import gmsh

Parameters = Mapping[str, float | Sequence[float]]

_session_depth = 0


@contextmanager
def gmsh_session() -> Iterator[Any]:
    """A gmsh without terminal output and without the user's own option files; may be nested."""
    global _session_depth
    if _session_depth == 0:
        keywords: dict[str, Any] = {"readConfigFiles": False}
        if "interruptible" in inspect.signature(gmsh.initialize).parameters:
            keywords["interruptible"] = False  # Ctrl-C stays Python's
        gmsh.initialize([], **keywords)
        gmsh.option.setNumber("General.Terminal", 0)
    _session_depth += 1
    try:
        yield gmsh
    finally:
        _session_depth -= 1
        if _session_depth == 0:
            gmsh.finalize()


def run_script(path: Path, parameters: Parameters, *, refine: int = 0, gdim: int = 2) -> PlainMesh:
    """Mesh a gmsh script with values for its parameters.

    Parameters
    ----------
    path : a .geo file whose DefineConstant entries are named "Parameters/<key>"
    parameters : value of each <key>, a number or a list of numbers
    refine : how often gmsh halves all edges; new nodes lie on the geometry
    gdim : of the space

    Raises
    ------
    MeshError : missing file, unknown parameter, gmsh error, a model that is no mesh of regions.
    """
    if not path.is_file():
        raise MeshError(f"{path}: no such gmsh script")
    text = path.read_text(encoding="utf-8", errors="replace")
    for key in parameters:
        if f'"Parameters/{key}"' not in text:
            raise MeshError(f"{path}: the script has no parameter {key}")
    with gmsh_session():
        gmsh.clear()
        gmsh.onelab.clear()
        gmsh.onelab.set(_onelab(parameters))
        try:
            _generate(path, refine)
        except Exception as error:  # gmsh raises bare Exception or ValueError
            if "Redefinition of function" not in str(error):
                raise MeshError(f"{path}: gmsh: {error}") from error
        else:
            plain = plain_from_model(str(path), gdim)
            gmsh.clear()
            gmsh.onelab.clear()
            return plain
    return _run_elsewhere(path, parameters, refine, gdim)


def _onelab(parameters: Parameters) -> str:
    """Parameters as gmsh's database takes them."""
    return json.dumps(
        [
            {
                "type": "number",
                "name": f"Parameters/{key}",
                "values": np.atleast_1d(np.asarray(value, dtype=float)).tolist(),
            }
            for key, value in parameters.items()
        ]
    )


def _generate(path: Path, refine: int) -> None:
    gmsh.merge(str(path))
    gmsh.model.mesh.generate(2)
    if refine:
        # gmsh halves edges where it puts the middle nodes of the order that is set
        order = int(gmsh.option.getNumber("Mesh.ElementOrder"))
        for _ in range(refine):
            gmsh.model.mesh.refine()
        gmsh.model.mesh.setOrder(order)


# gmsh reads a script with a Macro once in a process: the name stays taken.
_ELSEWHERE = """
import sys
from pathlib import Path
from plymotion.preprocess.fenicsx import gmsh_script as g
with g.gmsh_session() as gmsh:
    gmsh.onelab.set(sys.argv[2])
    g._generate(Path(sys.argv[1]), int(sys.argv[3]))
    gmsh.option.setNumber("Mesh.SaveAll", 1)
    gmsh.write(sys.argv[4])
"""


def _run_elsewhere(path: Path, parameters: Parameters, refine: int, gdim: int) -> PlainMesh:
    """`run_script` in a process of its own."""
    with tempfile.TemporaryDirectory() as folder:
        target = Path(folder) / "mesh.msh"
        command = [sys.executable, "-c", _ELSEWHERE]
        arguments = [str(path.absolute()), _onelab(parameters), str(refine), str(target)]
        done = subprocess.run(
            command + arguments,
            capture_output=True,
            text=True,
            env={**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))},
        )
        if done.returncode != 0:
            reason = (done.stderr.strip().splitlines() or ["no mesh"])[-1]
            raise MeshError(f"{path}: gmsh: {reason}")
        return open_mesh(target, gdim=gdim, where=str(path))


def open_mesh(path: Path, *, gdim: int = 2, where: str | None = None) -> PlainMesh:
    """Read a mesh file that gmsh knows (.msh of any version); `where` names it in messages.

    Raises
    ------
    MeshError : missing file, gmsh error, a model that is no mesh of regions.
    """
    if not path.is_file():
        raise MeshError(f"{path}: no such mesh file")
    with gmsh_session():
        gmsh.clear()
        try:
            gmsh.open(str(path))
        except Exception as error:  # gmsh raises bare Exception or ValueError
            raise MeshError(f"{path}: gmsh: {error}") from error
        plain = plain_from_model(where or str(path), gdim)
        gmsh.clear()
    return plain
