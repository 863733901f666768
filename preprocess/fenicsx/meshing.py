"""Meshes by gmsh: from a script or the current model to DOLFINx."""

import inspect
import json
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .stack import MPI, gmsh, gmsh_bridge, quiet


class MeshError(Exception):
    """A gmsh model that cannot become a finite-element mesh."""


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


@dataclass(frozen=True)
class LabelledMesh:
    """A DOLFINx mesh whose cells know their physical group."""

    mesh: Any
    cell_labels: NDArray[np.int32]  # (n_cell,), in DOLFINx's cell order
    names: dict[str, int]  # physical name -> label

    @property
    def n_cell(self) -> int:
        """Number of cells."""
        return int(self.cell_labels.size)


def mesh_from_geo(
    path: Path, parameters: Mapping[str, float], *, dimension: int = 2, gdim: int = 2
) -> LabelledMesh:
    """Mesh a gmsh script with values for its parameters.

    Parameters
    ----------
    path : a .geo file whose DefineConstant entries are named "Parameters/<key>"
    parameters : value of each <key>; a key that the script does not define is an error
    dimension, gdim : of the cells, of the space

    Raises
    ------
    MeshError : missing file, unknown parameter, gmsh error, cells without physical group.
    """
    if not path.is_file():
        raise MeshError(f"{path}: no such gmsh script")
    text = path.read_text(encoding="utf-8")
    for key in parameters:
        if f'"Parameters/{key}"' not in text:
            raise MeshError(f"{path}: the script has no parameter {key}")
    with gmsh_session():
        gmsh.clear()
        gmsh.onelab.clear()
        gmsh.onelab.set(
            json.dumps(
                [
                    {"type": "number", "name": f"Parameters/{key}", "values": [float(value)]}
                    for key, value in parameters.items()
                ]
            )
        )
        try:
            gmsh.merge(str(path))
            gmsh.model.mesh.generate(dimension)
        except Exception as error:  # gmsh raises bare Exception or ValueError
            raise MeshError(f"{path}: gmsh: {error}") from error
        labelled = mesh_from_model(dimension, gdim, str(path))
        gmsh.clear()
        gmsh.onelab.clear()
    return labelled


def mesh_from_model(dimension: int = 2, gdim: int = 2, where: str = "gmsh model") -> LabelledMesh:
    """Convert the current gmsh model; every entity of the dimension needs one physical group."""
    for _, tag in gmsh.model.getEntities(dimension):
        groups = gmsh.model.getPhysicalGroupsForEntity(dimension, tag)
        if len(groups) != 1:
            raise MeshError(
                f"{where}: entity {tag} of dimension {dimension} is in {len(groups)} physical "
                "groups, expected exactly one"
            )
    names = {
        gmsh.model.getPhysicalName(dimension, tag): int(tag)
        for _, tag in gmsh.model.getPhysicalGroups(dimension)
    }
    if not names:
        raise MeshError(f"{where}: no physical group of dimension {dimension}")
    with quiet():
        converted = gmsh_bridge.model_to_mesh(gmsh.model, MPI.COMM_SELF, 0, gdim=gdim)
    mesh, tags = converted[0], converted[1]
    labels = np.full(mesh.topology.index_map(mesh.topology.dim).size_local, -1, dtype=np.int32)
    labels[tags.indices] = tags.values
    return LabelledMesh(mesh, labels, names)
