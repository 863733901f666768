"""Whirl speeds of rotors, by the command `plymotion modes`."""

import numpy as np
import pytest
from samples.beam_samples import CHORD, reduced
from samples.modes_samples import modes_at, rates

from plymotion.preprocess.beam.line import SectionMass
from plymotion.solver.package import write_package


@pytest.fixture(scope="module")
def rotor(published):
    return published("modes")["two-disc-rotor"]


def shaft(e):
    """A circular Timoshenko shaft between its ends, with static shapes where the discs are."""
    A, I2 = np.pi * e["diameter"] ** 2 / 4, np.pi * e["diameter"] ** 4 / 64
    nu = e["E"] / (2 * e["G"]) - 1
    shear = 6 * (1 + nu) / (7 + 6 * nu) * e["G"] * A
    K = np.diag([e["E"] * A, shear, shear, e["G"] * 2 * I2, e["E"] * I2, e["E"] * I2])
    J = e["density"] * I2 * np.diag([2.0, 1.0, 1.0])
    places = {"root": "start", "one": 1 / 3, "two": 2 / 3, "tip": "end"}
    modes = [{"kind": f"bending-{plane}", "count": 4} for plane in ("xy", "xz")]
    turns = ["y", "z", "ry", "rz"]
    modes += [{"kind": "attachment", "at": at, "directions": turns} for at in ("one", "two")]
    return reduced(
        CHORD, modes, elements=12, K=K,
        mass=SectionMass(e["density"] * A, np.zeros(3), J).matrix(),
        length=e["length"], interfaces={name: {"at": at} for name, at in places.items()},
    ).package  # fmt: skip


def case_text(e, stiffness):
    text = '[bodies.shaft]\nkind = "package"\npackage = "shaft.vtkhdf"\n'
    for name, D, x in zip(("one", "two"), e["disc_diameters"], (1 / 3, 2 / 3), strict=True):
        R, r, w = D / 2, e["diameter"] / 2, e["disc_width"]
        m = e["density"] * np.pi * (R**2 - r**2) * w
        polar, across = m / 2 * (R**2 + r**2), m / 12 * (3 * (R**2 + r**2) + w**2)
        text += (
            f'[bodies.{name}]\nkind = "rigid"\nmass = {m}\n'
            f"inertia = [[{polar}, 0, 0], [0, {across}, 0], [0, 0, {across}]]\n"
            f"position = [{x * e['length']}, 0.0, 0.0]\n"
            "interfaces = { c = { position = [0.0, 0.0, 0.0] } }\n"
            f'[joints.{name}]\nkind = "fixed"\nbetween = ["shaft.{name}", "{name}.c"]\n'
        )
    for name, x in (("root", 0.0), ("tip", e["length"])):
        text += (
            f"[ground.{name}]\nposition = [{x}, 0.0, 0.0]\n"
            f'[forces.{name}]\nkind = "bushing"\nbetween = ["ground.{name}", "shaft.{name}"]\n'
            f"stiffness = {stiffness}\n"
        )
    return text


def test_flexible_shaft_with_two_discs(rotor, tmp_path, capsys):
    e = rotor
    (tmp_path / "sample").mkdir()
    write_package(tmp_path / "sample" / "shaft.vtkhdf", shaft(e))
    text = case_text(e, [0.0, e["bearing"], e["bearing"]])
    options = ("--axis", "1,0,0")
    stiffened = "geometric_stiffening = true\n"
    still = modes_at(tmp_path, text, "equilibrium", capsys=capsys, more=stiffened)
    known = sorted(e["still"] * 2)
    assert rates(still)[:6] == pytest.approx(known, rel=e["tolerance"])
    found = modes_at(tmp_path, text, f"spin={e['rpm']}rpm", *options, capsys=capsys, more=stiffened)
    whirl = [m["fixed_axes_angular_frequency"] for m in found["modes"]]
    sizes = sorted(abs(w) for w in whirl if w is not None)
    assert sizes[:6] == pytest.approx(e["whirl"], rel=e["tolerance"])
    forward = [w > 0 for w in sorted((w for w in whirl if w is not None), key=abs)[:6]]
    assert forward == [False, True] * 3


def test_supports_that_differ_are_refused_in_turning_axes(rotor, tmp_path, capsys):
    from plymotion.solver.__main__ import main

    (tmp_path / "sample").mkdir()
    write_package(tmp_path / "sample" / "shaft.vtkhdf", shaft(rotor))
    text = case_text(rotor, [0.0, rotor["bearing"], 0.8 * rotor["bearing"]])
    modes_at(tmp_path, text, "equilibrium", capsys=capsys)
    file = tmp_path / "sample" / "case.toml"
    assert main(["modes", str(file), "--at", "spin=100", "--axis", "1,0,0"]) == 2
    assert "not constant in axes that turn" in capsys.readouterr().err
