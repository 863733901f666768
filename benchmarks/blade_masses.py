"""Masses of windIO blades: the file's table, thickness times arc of the outer surface, our meshes.

    PYTHONPATH=.:benchmarks python benchmarks/blade_masses.py FILE.yaml ...

Thin-walled codes count the middle column. 41 stations, integrated along the reference axis; no
FEniCSx needed.
"""

import sys
import tempfile
from pathlib import Path

import numpy as np

from plymotion.solver.extras.blade.layers import enclosed, with_face
from plymotion.solver.extras.blade.shape import contour
from plymotion.solver.extras.blade.station import bands_of, webs_of, write_station
from plymotion.solver.extras.blade.windio import Blade, read_blade
from plymotion.solver.math.laws import lengths_along


def outer(blade: Blade, r: float) -> float:
    """Thickness times arc of the outer surface, and webs between its points [kg/m]."""
    bands = bands_of(blade, r)
    points, _ = with_face(contour(blade, r), bands)
    s = lengths_along(points)
    rho = {name: material["rho"] for name, material in blade.materials.items()}
    mass = sum(rho[b.material] * b.thickness * (b.end - b.start) * s[-1] for b in bands)
    for web in webs_of(blade, r):
        ends = [[np.interp(arc, s / s[-1], x) for x in points.T] for arc in (web.start, web.end)]
        height = np.linalg.norm(np.subtract(*ends))
        mass += sum(rho[b.material] * b.thickness * height for b in web.layers)
    return float(mass)


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
        sums = [given, [outer(blade, x) for x in r], ours]
        table, thin, mesh = (float(np.trapezoid(row, s)) for row in sums)
        print(f"{Path(file).name:44} {table:8.0f} {thin:10.0f} {mesh:8.0f}", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
