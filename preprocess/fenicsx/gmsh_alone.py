"""Mesh a gmsh script with gmsh and NumPy only, so that a separate process can run this file.

    python gmsh_alone.py SCRIPT PARAMETERS REFINE MESH NODES

PARAMETERS is JSON, MESH the .msh to write, NODES the .npy of the nodes on curves after REFINE
refinements.
"""

import json
import sys
from collections.abc import Mapping, Sequence

import gmsh
import numpy as np
from numpy.typing import NDArray

Parameters = Mapping[str, float | Sequence[float]]


def generate(script: str, parameters: Parameters) -> None:
    """Mesh a script with values for its "Parameters/<key>" in the current model."""
    numbers = [
        {
            "type": "number",
            "name": f"Parameters/{key}",
            "values": np.atleast_1d(np.asarray(value, dtype=float)).tolist(),
        }
        for key, value in parameters.items()
    ]
    gmsh.onelab.clear()
    gmsh.onelab.set(json.dumps(numbers))
    gmsh.merge(script)
    gmsh.model.mesh.generate(2)
    gmsh.onelab.clear()


def refined_curve_nodes(times: int) -> NDArray[np.float64]:
    """Halve every edge `refine` times; returns the nodes on the curves of the geometry, (n, 3)."""
    order = int(gmsh.option.getNumber("Mesh.ElementOrder"))
    for _ in range(times):
        gmsh.model.mesh.refine()
    gmsh.model.mesh.setOrder(order)
    coordinates = gmsh.model.mesh.getNodes(1, -1, True)[1]
    return np.array(coordinates, dtype=np.float64).reshape(-1, 3)


def main(script: str, parameters: str, refine: str, mesh: str, nodes: str) -> None:
    """Write mesh and nodes."""
    gmsh.initialize([], readConfigFiles=False)
    gmsh.option.setNumber("General.Terminal", 0)
    generate(script, json.loads(parameters))
    gmsh.option.setNumber("Mesh.SaveAll", 1)
    gmsh.write(mesh)
    np.save(nodes, refined_curve_nodes(int(refine)))
    gmsh.finalize()


if __name__ == "__main__":
    main(*sys.argv[1:])
