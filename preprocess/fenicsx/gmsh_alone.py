"""Mesh a gmsh script with gmsh and NumPy only, so that a separate process can run this file.

    python gmsh_alone.py SCRIPT PARAMETERS MESH

PARAMETERS is JSON, MESH the .msh to write.
"""

import json
import sys
from collections.abc import Mapping, Sequence

import gmsh
import numpy as np

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


def main(script: str, parameters: str, mesh: str) -> None:
    """Write the mesh."""
    gmsh.initialize([], readConfigFiles=False)
    gmsh.option.setNumber("General.Terminal", 0)
    generate(script, json.loads(parameters))
    gmsh.option.setNumber("Mesh.SaveAll", 1)
    gmsh.write(mesh)
    gmsh.finalize()


if __name__ == "__main__":
    main(*sys.argv[1:])
