"""A body of 200 modes: it runs, and moves like one of a few modes."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from samples.beam_samples import dense
from samples.body_specs import beam_body
from samples.case_samples import HEAD, computed_file
from samples.recovery_samples import STEEL

from plymotion.preprocess.beam.beam_body import beam_model, beam_modes, beam_package
from plymotion.preprocess.beam.beam_specification import read_spec
from plymotion.preprocess.beam.line import LineSection
from plymotion.solver.package import SectionData, write_package

LENGTH, WIDTH, HEIGHT = 0.5, 0.02, 0.05
AREA, I2, I3 = WIDTH * HEIGHT, WIDTH * HEIGHT**3 / 12, HEIGHT * WIDTH**3 / 12
E, G = STEEL["E"], STEEL["E"] / 2.6
STIFFNESS = np.diag([E * AREA, 5 / 6 * G * AREA, 5 / 6 * G * AREA, G * 9.9e-8, E * I2, E * I3])
MASS = STEEL["rho"] * np.diag([AREA, AREA, AREA, I2 + I3, I2, I3])

PENDULUM = """
gravity = [0.0, -9.81, 0.0]
[bodies.arm]
kind = "package"
package = "arm.vtkhdf"
[ground.O]
position = [0.0, 0.0, 0.0]
[joints.hinge]
kind = "revolute"
between = ["ground.O", "arm.root"]
axis = [0, 0, 1]
[signals.tip]
kind = "position"
at = "arm.tip"
component = "y"
[signals.bend]
kind = "deflection"
at = "arm.tip"
component = "y"
"""


def swing(folder: Path, count: int) -> tuple[dict[str, np.ndarray], dict[str, Any]]:
    """The fall of a hinged bar with `count` modes of bending in each of two planes."""
    folder.mkdir()
    modes = [{"kind": kind, "count": count} for kind in ("bending-xy", "bending-xz")]
    spec = beam_body(body="arm", section={}, length=LENGTH, elements=150, modes=modes)
    model = beam_model(read_spec(spec), LineSection(STIFFNESS, MASS))
    section = SectionData("bar", STIFFNESS, MASS, "", None)
    package = beam_package(model, beam_modes(model, dense), [section], {})
    assert package.n_mode == 2 * count
    write_package(folder / "arm.vtkhdf", package)
    solver = "[solver]\nt_end = 0.1\noutput_step = 1e-3\n[runs.base]\n"
    result, summary = computed_file(folder / "case.toml", HEAD + PENDULUM + solver)
    return {s.name: s.values for s in result.signals}, summary


def test_two_hundred_modes(tmp_path: Path) -> None:
    """The bar falls as a rigid one, and bends as with a few modes."""
    many, told = swing(tmp_path / "many", 100)
    few, _ = swing(tmp_path / "few", 3)
    assert told["status"] == "finished"
    assert told["checks"]["modes_used"] == {"arm": 200}
    assert told["cost"]["rejected"] < told["cost"]["steps"]
    # a thin rigid bar: alpha = 3 g / (2 L) at the start
    t = 0.02
    assert many["tip"][20] == pytest.approx(-0.75 * 9.81 * t**2, rel=2e-3)
    assert np.abs(many["tip"] - few["tip"]).max() < 1e-4 * np.abs(many["tip"]).max()
    # within the accuracy of both runs: rtol = 1e-5 of the size (docs/accuracy.md)
    assert np.abs(many["bend"] - few["bend"]).max() < 2.0 * 1e-5 * LENGTH
    assert np.abs(many["bend"]).max() > 1.4e-5
