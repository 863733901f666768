r"""Load factors of laminated plates: triangles, quadrilaterals and CalculiX's *BUCKLE (S8R).

. build/fenicsx.env && PYTHONPATH=.:tests "$FENICSX_PYTHON" benchmarks/shell_buckling.py

Cantilever plates of PLATES (tests/samples/shell_layups.py), clamped at x = 0 and pushed by 1 N
along x at the other edge, in both codes with the same supports. CalculiX misses a factor below 1
without a word, and its composite S8R shears its layers apart in thick laminates: the load here is
far below the critical one and the plates are thin. It is left out where `ccx` is not installed.
"""

import os

os.environ |= {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}

import re
import shutil
import subprocess
import tempfile
import time
from pathlib import Path

import numpy as np
import shell_calculix
from samples.shell_cantilevers import cantilever
from samples.shell_layups import PLATES

from plymotion.preprocess.shell.analyses.shell_analysis import analyse

COUNT = 3
MESHES = ((12, 4), (24, 8), (48, 16))


def ours(layup: str, n: tuple[int, int], cells: dict[str, str]) -> tuple[np.ndarray, float]:
    """Load factors per newton, and seconds of processor."""
    model, _ = cantilever(n, layup)
    model.loads = {"N": {"tip": {"at": "right", "force": [-1.0, 0.0, 0.0]}}}
    model.frequencies = {}
    spec = model.spec(cells=cells)
    start = time.process_time()
    found = analyse({**spec, "buckling": {"count": COUNT}}).buckling
    assert found is not None
    return found.factors, time.process_time() - start


def peer(layup: str, n: tuple[int, int]) -> np.ndarray:
    """Load factors of S8R."""
    model = shell_calculix.plate(layup, n)
    x = np.array([-1.0, 0.0, 0.0])
    push = {point: abs(force[2]) * x for point, force in model.loads["Fz"].items()}
    model.loads = {"Fz": push}
    text = shell_calculix.deck(model, 0, False)
    text += f"*STEP\n*BUCKLE\n{COUNT}, 1e-6\n*CLOAD\n"
    for point, force in push.items():
        text += f"{point + 1}, 1, {force[0]:.12g}\n"
    text += "*END STEP\n"
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "model.inp").write_text(text)
        subprocess.run(["ccx", "model"], cwd=folder, capture_output=True, check=False)
        lines = Path(folder, "model.dat").read_text().splitlines()
    rows = [line.split() for line in lines if re.match(r"^\s+\d+\s+-?\d\.\d+E", line)]
    return np.array([float(row[1]) for row in rows])


def main() -> None:
    for layup in PLATES:
        print(layup)
        if shutil.which("ccx"):
            for n in ((12, 4), (24, 8)):
                print(f"  CalculiX S8R {n!s:9s}", np.array2string(peer(layup, n), precision=5))
        for name, cells in (("triangles", {}), ("quadrilaterals", {"element": "quadrilateral"})):
            for n in MESHES:
                factors, seconds = ours(layup, n, cells)
                shown = np.array2string(factors, precision=5)
                print(f"  {name:14s} {n!s:9s} {shown}  {1e3 * seconds:.0f} ms")


if __name__ == "__main__":
    main()
