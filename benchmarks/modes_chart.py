"""Figures of docs/modes-about-a-state.md, drawn by `plymotion modes` on cases of the repository.

python benchmarks/modes_chart.py NAME OUT.png    NAME: shapes, campbell, rotor, response
"""

import shutil
import sys
import tempfile
from pathlib import Path

from plymotion.solver.__main__ import main

CALLS = {
    "shapes": ("double-pendulum", "modes.png", ["--at", "equilibrium", "--shapes", "6"]),
    "campbell": ("rotating-blade", "campbell.png", ["--at", "spin=0:200:10", "--count", "7"]),
    "rotor": ("rotor", "campbell.png", ["--at", "spin=0:1000:25", "--harmonics", "2"]),
    "response": (
        "actuated-beam",
        "response.png",
        ["--response", "1:1000", "--output", "tip_deflection", "--output", "torque"],
    ),
}


def draw(name: str, out: Path) -> None:
    case, picture, options = CALLS[name]
    packages = Path("tests/packages") / case
    options = [*options, "--packages", str(packages)] if packages.is_dir() else options
    with tempfile.TemporaryDirectory() as folder:
        file = f"cases/{case}/case.toml"
        assert main(["modes", file, *options, "--out", folder]) == 0
        shutil.copyfile(Path(folder) / picture, out)


if __name__ == "__main__":
    draw(sys.argv[1], Path(sys.argv[2]))
