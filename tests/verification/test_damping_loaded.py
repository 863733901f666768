"""Damping of a body that carries a mass: zeta f / f_body, as docs/modes.md says."""

import dataclasses

import numpy as np
import pytest
from beam_samples import CLAMPED, reduced
from modes_samples import modes_at
from stiffening_samples import rectangle

from plymotion.solver.package import write_package

ZETA = 0.01
TEXT = """
[bodies.beam]
kind = "package"
package = "beam.vtkhdf"
[ground.foot]
position = [0.0, 0.0, 0.0]
[joints.foot]
kind = "fixed"
between = ["ground.foot", "beam.root"]
[masses.payload]
mass = {mass}
at = "beam.tip"
"""


@pytest.mark.parametrize("mass", [1e-6, 0.1, 1.0])
def test_a_payload_lowers_the_damping_ratio(tmp_path, capsys, mass):
    K, own = rectangle(70e9, 0.3, 2700.0, 0.004, 0.02)
    modes = [{"kind": "bending-xy", "count": 1}]
    package = reduced(CLAMPED, modes, K=K, mass=own, length=0.5, elements=8).package
    omega = float(package.frequencies[0])
    package = dataclasses.replace(package, damping=np.diag([2.0 * ZETA * omega]))
    (tmp_path / "sample").mkdir()
    write_package(tmp_path / "sample/beam.vtkhdf", package)
    found = modes_at(tmp_path, TEXT.format(mass=mass), "start", capsys=capsys)
    (mode,) = [m for m in found["modes"] if m["angular_frequency"] > 0.0]
    loaded = mode["angular_frequency"] / np.sqrt(1.0 - mode["damping_ratio"] ** 2)
    assert mode["damping_ratio"] == pytest.approx(ZETA * loaded / omega, rel=1e-6)
    if mass == 1.0:
        assert loaded < 0.3 * omega
