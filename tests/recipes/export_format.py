"""The export format of the recipe, by the command; argument: a folder to write to."""

import csv
import sys
from pathlib import Path

import numpy as np
from samples.package_samples import cantilever

from plymotion.solver.__main__ import main
from plymotion.solver.package import write_package

folder, package = Path(sys.argv[1]), cantilever()
write_package(folder / "arm.vtkhdf", package)
assert main(["export", str(folder / "arm.vtkhdf"), "--to", "modal_table"]) == 0
with (folder / "arm_modal_table.csv").open(newline="", encoding="utf-8") as file:
    rows = list(csv.DictReader(file))
assert [row["label"] for row in rows] == [*(package.mode_labels or package.mode_kinds)]
np.testing.assert_array_equal([float(row["frequency"]) for row in rows], package.frequencies)
ratios = np.diag(package.damping) / (2.0 * package.frequencies * np.diag(package.mass))
np.testing.assert_allclose([float(row["damping_ratio"]) for row in rows], ratios, rtol=1e-15)
