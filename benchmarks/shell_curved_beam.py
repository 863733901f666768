r"""The curved cantilever of MacNeal and Harder: ours and S8R of CalculiX over beam theory.

. build/fenicsx.env && PYTHONPATH=.:tests "$FENICSX_PYTHON" benchmarks/shell_curved_beam.py

A quarter ring of radii 4.12 and 4.32, thickness 0.1, clamped at x = 0, with unit forces in its
plane and out of it, spread along the tip. CalculiX is left out where `ccx` is not installed.
"""

import os

os.environ |= {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}

import shutil

import numpy as np
from samples.shell_model import SCRIPTS, isotropic
from shell_calculix import ABSENT, Array, Model, Wall, grid, run, simpson

from plymotion.preprocess.shell.analyses.shell_analysis import analyse

EXACT = np.array([0.08734, 0.5022])  # in plane, out of plane
INNER, OUTER, THICKNESS = 4.12, 4.32, 0.1
E, NU = 1e7, 0.25
MESHES = [(6, 1), (12, 1), (24, 1), (24, 2), (48, 4), (96, 8)]


def ours(n: tuple[int, int]) -> Array:
    """Displacement of the tip along both forces."""
    stack, materials = isotropic(E, NU, THICKNESS)
    size = {"n_length": n[0], "n_width": n[1]}
    forces = {"in": [1.0, 0.0, 0.0], "out": [0.0, 0.0, 1.0]}
    spec = {
        "mesh": {
            "file": str(SCRIPTS / "curved-beam.py"),
            "parameters": size,
            "element": "quadrilateral",
        },
        "materials": materials,
        "laminates": {"wall": stack},
        "regions": {"all": {"laminate": "wall"}},
        "supports": {"root": {"at": "root", "fixed": "all"}},
        "loads": {k: {"tip": {"at": "tip", "force": force}} for k, force in forces.items()},
        "probes": {"tip": {"at": "tip", "what": ["ux", "uz"]}},
    }
    return np.diag(analyse(spec).probes.values)


def calculix(n: tuple[int, int]) -> Array:
    """The same by S8R, nodes in the middle of sides on the arcs."""
    angle = 0.5 * np.pi * np.linspace(0.0, 1.0, 2 * n[0] + 1)
    radius = np.linspace(INNER, OUTER, 2 * n[1] + 1)
    index: dict[tuple[float, ...], int] = {}
    places = [[(r * np.sin(a), r * np.cos(a), 0.0) for r in radius] for a in angle]
    wall = Wall(grid(index, places, "S8R"), (0.0, 1.0, 0.0), [0.0])
    G = E / (2.0 * (1.0 + NU))
    material = {name: E for name in ("E1", "E2", "E3")}
    material |= {name: NU for name in ("nu12", "nu13", "nu23")}
    material |= {name: G for name in ("G12", "G13", "G23")} | {"rho": 1.0}
    tip = [index[tuple(np.round(place, 9))] for place in places[-1]]
    weight = dict(zip(tip, simpson(n[1]) / n[1], strict=True))
    loads = {k: {p: w * np.eye(3)[k] for p, w in weight.items()} for k in (0, 2)}
    named = {"in": loads[0], "out": loads[2]}
    points = np.array(list(index))
    found = run(Model(points, [wall], material, THICKNESS, "S8R", named, named), 0).displacements
    return np.array([
        sum(w * found[case][p, k] for p, w in weight.items()) for case, k in (("in", 0), ("out", 2))
    ])  # fmt: skip


def main() -> None:
    peer = shutil.which("ccx") is not None
    if not peer:
        print(ABSENT)
    for n in MESHES:
        line = f"{n[0]:3d} x {n[1]}  ours {ours(n) / EXACT}"
        print(line + (f"  S8R {calculix(n) / EXACT}" if peer else ""))


if __name__ == "__main__":
    np.set_printoptions(precision=4, suppress=True)
    main()
