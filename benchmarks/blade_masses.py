"""Masses of windIO blades: the file's table, thickness times arc of the outer surface, our meshes.

    PYTHONPATH=.:benchmarks python benchmarks/blade_masses.py FILE.yaml ...

Thin-walled codes count the middle column. 41 stations, integrated along the reference axis; no
FEniCSx needed.
"""

import sys
import tempfile
from pathlib import Path

import numpy as np

from plymotion.solver.extras.blade.analysis import thin_masses
from plymotion.solver.extras.blade.layers import enclosed
from plymotion.solver.extras.blade.station import write_station
from plymotion.solver.extras.blade.windio import Blade, read_blade
from plymotion.solver.math.laws import lengths_along


def meshed(blade: Blade, r: float, folder: Path) -> float:
    """Mass of the cells of a station [kg/m]."""
    mesh = write_station(blade, r, "one", folder)
    nodes = np.array(mesh.nodes)
    return sum(
        0.5 * enclosed(nodes[list(cell)]) * blade.materials[mesh.bands[region].material]["rho"]
        for cell, region in zip(mesh.cells, mesh.regions, strict=True)
    )


def main(files: list[str]) -> None:
    r = np.linspace(0.0, 1.0, 41)
    print(f"{'file':44} {'table':>8} {'outer arcs':>10} {'meshed':>8}  [kg]")
    for file in files:
        blade = read_blade(Path(file))
        axis = (blade.length, blade.prebend, blade.sweep)
        s = lengths_along(np.column_stack([one.smooth(r) for one in axis]))
        given = [blade.given.at(x).get("mass", np.nan) if blade.given else np.nan for x in r]
        with tempfile.TemporaryDirectory() as folder:
            ours = [meshed(blade, x, Path(folder)) for x in r]
        sums = [given, thin_masses(blade, r.tolist()), ours]
        table, thin, mesh = (float(np.trapezoid(row, s)) for row in sums)
        print(f"{Path(file).name:44} {table:8.0f} {thin:10.0f} {mesh:8.0f}", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
