"""Bodies of cases/exchange from other codes: decks, real runs, imports, packages.

PYTHONPATH=.:tests .venv/bin/python benchmarks/exchange_bodies.py

writes cases/exchange/*.vtkhdf and prints their lowest frequencies. Needs CalculiX and MYSTRAN
(`make test-exchange` installs them).
"""

import sys
import tempfile
from pathlib import Path

import numpy as np
from samples.exchange_decks import MASS, write_mystran, write_shell, write_solid
from samples.exchange_routes import ccx, import_file, mystran, run_program

from plymotion.preprocess.exchange.import_file import imported, read_table
from plymotion.solver.__main__ import main as plymotion
from plymotion.solver.package import read_package, write_package

FOLDER = Path(__file__).resolve().parent.parent / "cases" / "exchange"
ENDS = {
    "root": "box = [[-1e-6, -1, -1], [1e-6, 1, 1]]",
    "tip": "box = [[0.499999, -1, -1], [0.500001, 1, 1]]",
}

SHELL = """\
format = 1
body = "arm"
from = "calculix-modes"
units = { length = "m", mass = "kg", time = "s" }
total_mass = 0.31
reference = { kind = "clamped", at = "root" }
modes = [{ kind = "lowest", count = 12 }]

[files]
deck = "shell.inp"

[interfaces]
root = { set = "NROOT", link = "average" }
tip = { set = "NTIP", link = "average" }
"""


def main() -> int:
    """Make all packages; returns the exit code."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        write_solid(folder / "solid.inp", (20, 2))
        run_program(ccx(), ["solid"], folder, folder / "solid.sti")
        write_mystran(folder / "mystran.dat", (40, 4))
        run_program(mystran(), ["mystran.dat"], folder, folder / "mystran.OU1")
        files = {
            "calculix-solid": import_file(folder, "calculix", {"deck": "solid.inp"}, MASS),
            "mystran": import_file(
                folder,
                "nastran",
                {"bulk": "mystran.dat", "matrices": "mystran.OU1"},
                MASS,
                name="mystran.toml",
                **ENDS,
            ),
        }
        for body, file in files.items():
            package = imported(read_table(file), folder, str(file))
            write_package(FOLDER / f"{body}.vtkhdf", package)
        write_shell(folder / "shell.inp", (20, 2), 12)
        run_program(ccx(), ["shell"], folder, folder / "shell.dat")
        (folder / "shell.toml").write_text(SHELL)
        out = FOLDER / "calculix-shell.vtkhdf"
        if code := plymotion(["import", str(folder / "shell.toml"), "-o", str(out), "--quiet"]):
            return code
        for body in (*files, "calculix-shell"):
            package = read_package(FOLDER / f"{body}.vtkhdf")
            hertz = package.frequencies[:6] / (2.0 * np.pi)
            print(f"{body:16s}", *(f"{f:9.3f}" for f in hertz))
    return 0


if __name__ == "__main__":
    sys.exit(main())
