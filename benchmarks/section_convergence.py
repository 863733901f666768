"""Error of K against time and unknowns, for degrees and meshes of three sections.

. build/fenicsx.env && PYTHONPATH=.:tests "$FENICSX_PYTHON" benchmarks/section_convergence.py JSON

The error is the worst entry of K, scaled by sqrt(Kii Kjj), against the same section with degree 3
on a mesh finer than all others: our own value. Times are seconds of processor from a mesh in
memory to K, medians of five.
"""

import os

os.environ |= {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}

import json
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
from samples.section_cases import section

from plymotion.preprocess import fenicsx
from plymotion.preprocess.section.section_problem import SectionProblem
from plymotion.preprocess.section.space.layers import layup
from plymotion.preprocess.section.space.section_mesh import SectionMesh, section_mesh
from plymotion.preprocess.section.timoshenko import scaled

SECTIONS = {
    "square, isotropic": "02",
    "strip, 30° ply": "15",
    "box, lay-up 2": "21",
}
DENSITIES = {1: (1, 2, 4), 2: (0.4, 0.7, 1, 2, 3), 3: (0.4, 0.7, 1, 1.5)}
CONVERGED = 4.0  # density of the mesh of the value to compare with
REPEATS = 5


def linear(spec: dict[str, Any], folder: Path) -> dict[str, Any]:
    """The same section on the corners of its cells only: bilinear quadrilaterals."""
    mesh = section_mesh(spec["mesh"], "benchmark")
    file = folder / "linear.npz"
    np.savez(
        file,
        points=mesh.cells.points,
        cells=mesh.cells.nodes[:, :4],
        cell_type="quad",
        region=mesh.cells.region,
        region_names=np.array(mesh.cells.regions),
    )
    return {**spec, "mesh": {"arrays": str(file), "degree": 1}}


def solved(spec: dict[str, Any], mesh: SectionMesh, degree: int) -> tuple[Any, int]:
    """K and the number of unknowns; nothing is kept from an earlier call."""
    problem = SectionProblem(mesh, degree)
    lay = layup(spec, mesh, problem.space, "benchmark")
    return problem.solve(lay.stiffness).K, problem.space.n_dof


def timed(spec: dict[str, Any], degree: int) -> dict[str, Any]:
    mesh = section_mesh(spec["mesh"], "benchmark")
    seconds = []
    for _ in range(REPEATS):
        start = time.process_time()
        K, dofs = solved(spec, mesh, degree)
        seconds.append(time.process_time() - start)
    return {"K": K, "dofs": dofs, "seconds": float(np.median(seconds))}


def main() -> None:
    found: dict[str, Any] = {"versions": fenicsx.versions(), "curves": []}
    with tempfile.TemporaryDirectory() as folder:
        for title, name in SECTIONS.items():
            spec = section(name, CONVERGED, degree=3)
            exact, dofs = solved(spec, section_mesh(spec["mesh"], "benchmark"), 3)
            print(f"{title}: compared with {dofs} unknowns of degree 3")
            for degree, densities in DENSITIES.items():
                points = []
                for density in densities:
                    spec = section(name, density, degree=max(degree, 2))
                    point = timed(linear(spec, Path(folder)) if degree == 1 else spec, degree)
                    point["error"] = float(scaled(point.pop("K") - exact, exact).max())
                    points.append({"density": density, **point})
                    print(
                        f"  degree {degree}  {point['dofs']:7d} unknowns  "
                        f"{1e3 * point['seconds']:7.1f} ms  error {point['error']:.1e}",
                        flush=True,
                    )
                found["curves"].append({"section": title, "degree": degree, "points": points})
    Path(sys.argv[1]).parent.mkdir(parents=True, exist_ok=True)
    Path(sys.argv[1]).write_text(json.dumps(found, indent=1), encoding="utf-8")


if __name__ == "__main__":
    main()
