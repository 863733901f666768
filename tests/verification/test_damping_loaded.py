"""Damping of a body that carries a mass: zeta f / f_body, as docs/modes.md says."""

import dataclasses
import json

import numpy as np
import pytest
from samples.beam_samples import CLAMPED, reduced
from samples.modes_samples import modes_at, write_case_text
from samples.stiffening_samples import rectangle

from plymotion.solver.__main__ import main
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


def damped_beam(folder, zeta, count=1):
    """Write the package of a damped beam; return its first angular frequency."""
    K, own = rectangle(70e9, 0.3, 2700.0, 0.004, 0.02)
    modes = [{"kind": "bending-xy", "count": count}]
    package = reduced(CLAMPED, modes, K=K, mass=own, length=0.5, elements=8).package
    package = dataclasses.replace(package, damping=np.diag(2.0 * zeta * package.frequencies))
    (folder / "sample").mkdir(exist_ok=True)
    write_package(folder / "sample/beam.vtkhdf", package)
    return float(package.frequencies[0])


def damping(folder, mass, capsys):
    """What a run of the beam with a payload says of its damping, and what it prints."""
    file = write_case_text(folder, TEXT.format(mass=mass))
    main([str(file), "--out", str(folder / "build"), "--no-report", "--quiet", "--force"])
    text = capsys.readouterr().out
    (summary,) = (folder / "build").glob("*/summary.json")
    return json.loads(summary.read_text())["damping"], text


@pytest.mark.parametrize("mass", [1e-6, 0.1, 1.0])
def test_a_payload_lowers_the_damping_ratio(tmp_path, capsys, mass):
    omega = damped_beam(tmp_path, ZETA)
    found = modes_at(tmp_path, TEXT.format(mass=mass), "start", capsys=capsys)
    (mode,) = [m for m in found["modes"] if m["angular_frequency"] > 0.0]
    loaded = mode["angular_frequency"] / np.sqrt(1.0 - mode["damping_ratio"] ** 2)
    assert mode["damping_ratio"] == pytest.approx(ZETA * loaded / omega, rel=1e-6)
    if mass == 1.0:
        assert loaded < 0.3 * omega


def test_a_run_gives_both_ratios_and_the_rule_gives_the_ratio_that_was_asked_for(tmp_path, capsys):
    damped_beam(tmp_path, ZETA)
    (entry,), text = damping(tmp_path, 1e-6, capsys)
    assert entry["damping_ratio"] == pytest.approx(ZETA, rel=1e-3)
    assert "damping of" not in text
    (entry,), text = damping(tmp_path, 1.0, capsys)
    assert entry["body"] == "beam"
    ratio = entry["frequency_hz"] / entry["own_frequency_hz"]
    assert entry["damping_ratio"] == pytest.approx(ZETA * ratio, rel=1e-6)
    assert entry["own_damping_ratio"] == pytest.approx(ZETA, rel=1e-9)
    assert "damping of beam: " in text
    assert f"; damping_ratio = {ZETA / ratio:.2g} gives 1 % there" in text
    damped_beam(tmp_path, ZETA / ratio)
    found = modes_at(tmp_path, TEXT.format(mass=1.0), "start", capsys=capsys)
    (mode,) = [m for m in found["modes"] if m["angular_frequency"] > 0.0]
    assert mode["damping_ratio"] == pytest.approx(ZETA, rel=1e-6)


def test_of_several_modes_the_lowest_vibration_counts(tmp_path, capsys):
    """The entry has the frequency and the ratio that `plymotion modes` prints."""
    damped_beam(tmp_path, ZETA, count=3)
    (entry,), _ = damping(tmp_path, 1.0, capsys)
    found = modes_at(tmp_path, TEXT.format(mass=1.0), "start", capsys=capsys)
    first = min(
        (m for m in found["modes"] if m["angular_frequency"] > 0.0),
        key=lambda m: m["angular_frequency"],
    )
    hertz = first["angular_frequency"] / (2.0 * np.pi)
    assert entry["frequency_hz"] == pytest.approx(hertz, rel=1e-3)  # of the undamped vibration
    assert entry["damping_ratio"] == pytest.approx(first["damping_ratio"], rel=1e-3)
