"""Tip error of lumped and consistent inertia over the mesh (docs/adr/0003).

make double-pendulum && .venv/bin/python benchmarks/mass_form.py
"""

import os
import subprocess
import tempfile
import tomllib
from pathlib import Path

import numpy as np

from plymotion.solver.inputs.case.load import load_case
from plymotion.solver.inputs.case.write import write_case
from plymotion.solver.run.execution import execute, read_run

CASE = Path("cases/double-pendulum/case.toml")
REFERENCE = Path("tests/reference/dynamics/double_pendulum.toml")
CHOSEN = "elements = 24"


def main() -> None:
    exact = np.array(tomllib.loads(REFERENCE.read_text())["isotropic"]["tip"])
    print("elements  mass form   tip at 1 s [m]          distance to geometrically exact beams [m]")
    for mass_form in ("lumped", "consistent"):
        for elements in (8, 16, 32):
            text = CASE.read_text().replace(
                CHOSEN, f'elements = {elements}\nmass_form = "{mass_form}"'
            )
            with tempfile.TemporaryDirectory() as folder:
                case, out = Path(folder, "case.toml"), Path(folder, "build")
                case.write_text(text)
                write_case(load_case(case), out)
                specs = " ".join(
                    str(out / "bodies" / f"{b}.isotropic.json") for b in ("arm", "hand")
                )
                command = (
                    '. ./build/fenicsx.env && PYTHONPATH=. "$FENICSX_PYTHON" -m '
                    f"plymotion.preprocess body {specs} --out-dir {out}/bodies"
                )
                done = ["sh", "-c", command]
                subprocess.run(done, check=True, capture_output=True, env=dict(os.environ))
                result, _ = execute(read_run(out / "runs/isotropic.json"), progress=False)
            signal = {s.name: s.values[-1] for s in result.signals}
            tip = np.array([signal["tip_x"], signal["tip_y"]])
            print(
                f"{elements:8d}  {mass_form:10s}  ({tip[0]:.6f}, {tip[1]:.6f})   "
                f"{np.linalg.norm(tip - exact):.1e}"
            )


if __name__ == "__main__":
    main()
