r"""Our sections beside those of others, in one go.

. build/fenicsx.env && PYTHONPATH=.:tests "$FENICSX_PYTHON" \
    benchmarks/section_peers.py [PEER_PYTHON]

PEER_PYTHON is an interpreter with `sectionproperties` (python3 -m venv build/peers;
build/peers/bin/pip install sectionproperties); without it that table is left out. The other tables
compare with the published values of tests/reference/sections. Prints Markdown.
"""

import os

os.environ |= {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}

import json
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
from section_cases import reference, section

from plymotion.preprocess import fenicsx
from plymotion.preprocess.section import analyse
from plymotion.preprocess.section.mesh import section_mesh

HERE = Path(__file__).resolve().parent
REPEATS = 5

POUND, INCH = 4.448222, 0.0254
DIAGONAL = {"EA": 0, "GA2": 1, "GA3": 2, "GJ": 3, "EI2": 4, "EI3": 5}


def solved(name: str) -> tuple[Any, int, float]:
    """K, unknowns, and the median time from mesh in memory to K, all of the analysis."""
    spec = section(name)
    section_mesh(spec["mesh"], "benchmark")
    seconds = []
    for _ in range(REPEATS):
        start = time.perf_counter()
        found = analyse(spec, estimate=False)
        seconds.append(time.perf_counter() - start)
    return found, found.provenance["dofs"], float(np.median(seconds))


def row(*cells: object) -> None:
    print("| " + " | ".join(str(cell) for cell in cells) + " |")


def header(*cells: str) -> None:
    row(*cells)
    row(*["---"] * len(cells))


def boxes() -> None:
    """Popescu and Hodges 2000: NABSA and VABS, three digits, in lb and in."""
    print("\n### Composite boxes of the paper, against NABSA and VABS (Popescu and Hodges 2000)\n")
    header("lay-up", "entry", "Plymotion", "NABSA", "VABS 2000", "Plymotion / NABSA - 1")
    unit = np.array([POUND] * 3 + [POUND * INCH] * 3)
    for name in ("20", "21", "22"):
        published = reference(name)["published"]
        found, dofs, seconds = solved(name)
        for entry, value in published["nabsa"].items():
            i, j = [DIAGONAL[entry]] * 2 if entry in DIAGONAL else [int(n) - 1 for n in entry[1:]]
            ours = abs(found.K[i, j]) * POUND / (unit[i] * unit[j])
            row(
                name,
                entry,
                f"{ours:.4g}",
                f"{value:.3g}",
                f"{published['vabs_2000'][entry]:.3g}",
                f"{100 * (ours / abs(value) - 1):+.1f} %",
            )
        print(f"\nlay-up {name}: {dofs} unknowns, {1e3 * seconds:.0f} ms\n")


def becas() -> None:
    """BECAS user guide, by way of GXBeam.jl: diagonals."""
    print("\n### Sections of the BECAS guide (as printed; its meshes are coarse)\n")
    names = tuple(DIAGONAL)
    header("section", *names, "unknowns", "ms")
    for name in ("06", "07", "08", "09a", "09b", "09c"):
        found, dofs, seconds = solved(name)
        published = reference(name)["published"]["diag_order_EA_GA2_GA3_GJ_EI2_EI3"]
        ours = np.diag(found.K)
        cells = [
            f"{a:.4g} ({100 * (a / b - 1):+.1f} %)" for a, b in zip(ours, published, strict=True)
        ]
        row(name, *cells, dofs, f"{1e3 * seconds:.0f}")


def sectionproperties(python: str) -> None:
    """Isotropic sections: torsion constant, shear areas, shear centre, and times."""
    done = subprocess.run(
        [python, str(HERE / "section_peer_sectionproperties.py")],
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode != 0:
        print(f"sectionproperties did not run: {done.stderr.strip().splitlines()[-1]}")
        return
    theirs = json.loads(done.stdout)
    print(f"\n### sectionproperties {theirs['version']}, isotropic sections\n")
    header("section", "code", "J", "A2 / A", "A3 / A", "shear centre", "unknowns", "ms")
    for name, peer in theirs["sections"].items():
        material = reference(name)["material"]
        found, dofs, seconds = solved(name)
        G = 0.5 * material["E"] / (1.0 + material["nu"])
        S = np.linalg.inv(found.K)
        area = found.K[0, 0] / material["E"]
        # about the shear centre, where shear and torsion part
        Z = S[1:3, 1:3] - np.outer(S[1:3, 3], S[3, 1:3]) / S[3, 3]
        shear = 1.0 / np.diag(Z) / (G * area)
        centre = ", ".join(f"{value:.5g}" for value in found.shear_centre)
        ours = f"{1 / S[3, 3] / G:.6g}"
        row(
            name,
            "Plymotion",
            ours,
            *(f"{v:.5f}" for v in shear),
            centre,
            dofs,
            f"{1e3 * seconds:.0f}",
        )
        centre = ", ".join(f"{value:.5g}" for value in peer["shear_centre"])
        row(
            "",
            "sectionproperties",
            f"{peer['J']:.6g}",
            *(f"{v:.5f}" for v in peer["shear"]),
            centre,
            peer["unknowns"],
            f"{1e3 * peer['seconds']:.0f}",
        )


def main() -> None:
    print(f"DOLFINx {fenicsx.versions()['dolfinx']}, one core; times: median of {REPEATS}")
    boxes()
    becas()
    if len(sys.argv) > 1:
        sectionproperties(sys.argv[1])


if __name__ == "__main__":
    main()
