"""Beams in segments in a case: what the user sees is one body."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from samples.segment_samples import cantilever, run_of

from plymotion.preprocess.beam.line import SectionMass
from plymotion.solver.errors import InputError
from plymotion.solver.inputs.case.bodies.specifications import BodySpecs
from plymotion.solver.inputs.case.checks import in_parts
from plymotion.solver.inputs.case.load import load_case
from plymotion.solver.inputs.case.tables.schema import Mechanism
from plymotion.solver.inputs.case.write import write_case
from plymotion.solver.run.execution import execute
from plymotion.solver.studies.sweep.sweep_members import read_sweep_spec

CASE = """
format = 1
title = "A beam in segments"
[materials.steel]
kind = "isotropic"
E = 210e9
nu = 0.3
rho = 7800.0
[sections.strip]
shape = "rectangle"
width = 0.02
height = 0.001
[bodies.arm]
kind = "beam"
length = 1.0
section = "strip"
material = "steel"
elements = 12
segments = 4
rotation_deg = [0.0, 0.0, 90.0]
position = [1.0, 0.0, 0.0]
velocity = [0.0, 0.0, 0.0]
angular_velocity = [0.0, 0.0, 2.0]
interfaces.root = { at = "start" }
interfaces.tip = { at = "end" }
interfaces.third = { at = 0.3 }
interfaces.mid = { at = 0.5 }
EXTRA
[ground.hub]
position = [1.0, 0.0, 0.0]
[joints.hub]
kind = "revolute"
between = ["ground.hub", "arm.root"]
axis = [0.0, 0.0, 1.0]
[forces.pull]
kind = "spring"
between = ["ground.hub", "arm.third"]
stiffness = 1.0
length = 0.3
[masses.tip]
mass = 0.1
at = "arm.tip"
[signals.tip]
kind = "position"
at = "arm.tip"
component = "y"
[signals.bend]
kind = "deflection"
at = "arm.tip"
component = "y"
[signals.moment]
kind = "resultant"
body = "arm"
x = 0.6
component = "M3"
[solver]
t_end = 0.1
output_step = 0.05
geometric_stiffening = true
[runs.base]
"""


def case_file(folder: Path, extra: str = "", **swaps: str) -> Path:
    text = CASE.replace("EXTRA", extra)
    for old, new in swaps.items():
        text = text.replace(old, new)
    file = folder / "segments" / "case.toml"
    file.parent.mkdir()
    file.write_text(text)
    return file


def test_places_become_those_of_the_segments(tmp_path: Path) -> None:
    case = load_case(case_file(tmp_path))
    mechanism = case.runs["base"]
    assert list(mechanism.bodies) == ["arm-1", "arm-2", "arm-3", "arm-4"]
    assert list(mechanism.joints) == ["arm-1-2", "arm-2-3", "arm-3-4", "hub"]
    assert mechanism.joints["arm-2-3"].between == ["arm-2.end", "arm-3.start"]
    assert mechanism.joints["hub"].between == ["ground.hub", "arm-1.start"]
    assert mechanism.forces["pull"].between == ["ground.hub", "arm-2.at-third"]
    assert mechanism.masses["tip"].at == "arm-4.end"
    assert mechanism.signals["tip"].at == "arm-4.end"
    moment = mechanism.signals["moment"]
    assert (moment.body, moment.x) == ("arm-3", pytest.approx(0.1))


def test_segments_start_like_the_body(tmp_path: Path) -> None:
    bodies = load_case(case_file(tmp_path)).runs["base"].bodies
    for k, body in enumerate(bodies.values()):
        np.testing.assert_allclose(body.position, [1.0, 0.25 * k, 0.0], atol=1e-15)
        np.testing.assert_allclose(body.rotation_deg, [0.0, 0.0, 90.0], atol=1e-13)
        np.testing.assert_allclose(body.velocity, [-0.5 * k, 0.0, 0.0], atol=1e-15)
        assert body.angular_velocity == pytest.approx([0.0, 0.0, 2.0])


def test_equal_segments_share_a_package(tmp_path: Path) -> None:
    case = load_case(case_file(tmp_path))
    specs = case.bodies["base"]
    hashes = [specs[f"arm-{k}"].inputs_sha256 for k in (1, 2, 3, 4)]
    assert hashes[0] == hashes[2] == hashes[3] != hashes[1]  # the second has an interface inside
    out = tmp_path / "build"
    write_case(case, out)
    assert sorted(f.name for f in (out / "bodies").glob("*.json")) == [
        "arm-1.base.json",
        "arm-2.base.json",
    ]
    packages = json.loads((out / "runs/base.json").read_text())["packages"]
    assert packages["arm-4"]["file"] == packages["arm-1"]["file"]
    spec = json.loads((out / "bodies/arm-1.base.json").read_text())
    assert (spec["length"], spec["elements"], spec["reference"]["kind"]) == (0.25, 3, "mean-axis")


def test_equal_arcs_share_a_package() -> None:
    """Segments of an arc are the same in their own frames, on the places of the whole arc."""
    table = cantilever(5, 2.0, body={"line": {"arc_deg": 100.0}, "elements": 15})
    table = {"materials": {}, "sections": {}, **table}
    table["materials"]["m"] = {"kind": "isotropic", "E": 1.0, "nu": 0.0, "rho": 1.0}
    table["sections"]["s"] = {"shape": "rectangle", "width": 0.1, "height": 0.1}
    mechanism, specs, problems = in_parts(Mechanism.model_validate(table), BodySpecs(Path()))
    assert problems == []
    assert len({spec.inputs_sha256 for spec in specs.values()}) == 1
    radius = 2.0 / np.radians(100.0)
    for k, body in enumerate(mechanism.bodies.values()):
        angle = np.radians(20.0 * k)
        place = radius * np.array([np.sin(angle), 1.0 - np.cos(angle), 0.0])
        np.testing.assert_allclose(body.position, place, atol=1e-12)
        np.testing.assert_allclose(body.rotation_deg, [0.0, 0.0, 20.0 * k + 10.0], atol=1e-9)


@pytest.mark.parametrize(
    ("extra", "message"),
    [
        ('reference = { kind = "mean-axis" }', r"bodies.arm.reference.kind = .mean-axis.*segments"),
        ('[bodies.arm-3]\nkind = "rigid"\nmass = 1.0\n'
         "inertia = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]",
         r"bodies.arm-3: expected another name.*part of body arm"),
        ("[ground.arm]\nposition = [0.0, 0.0, 0.0]\n[joints.arm-1-2]\nkind = \"spherical\"\n"
         'between = ["ground.arm", "arm.mid"]', r"joints.arm-1-2: expected another name"),
    ],
)  # fmt: skip
def test_errors_name_the_body_of_the_user(tmp_path: Path, extra: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        load_case(case_file(tmp_path, extra))


def test_too_few_elements_for_the_segments(tmp_path: Path) -> None:
    file = case_file(tmp_path, **{"elements = 12": "elements = 3"})
    with pytest.raises(InputError, match=r"bodies.arm.elements = 3: expected at least 4"):
        load_case(file)


def test_modes_are_required_without_segments(tmp_path: Path) -> None:
    file = case_file(tmp_path, **{"segments = 4": "segments = 1"})
    with pytest.raises(InputError, match=r"bodies.arm.modes: missing; expected at least one"):
        load_case(file)


def test_members_of_a_sweep_vary_the_whole_body(tmp_path: Path) -> None:
    """The file keeps the body of the user; each member is divided when it is built."""
    sweep = (
        '[sweeps.length]\nrun = "base"\nsignals = ["tip"]\n'
        '[sweeps.length.vary]\n"bodies.arm.length" = { values = [1.0, 2.0] }\n'
    )
    case = load_case(case_file(tmp_path, **{"[runs.base]": f"[runs.base]\n{sweep}"}))
    out = tmp_path / "build"
    write_case(case, out)
    table = json.loads((out / "sweeps/length.json").read_text())
    assert list(table["mechanism"]["bodies"]) == ["arm"]
    for spec in json.loads((out / "sweeps/length.json").read_text())["packages"]:
        (out / spec["file"]).write_bytes(b"")  # only their names matter here
    plan = read_sweep_spec(out / "sweeps/length.json")
    for number, length in enumerate((1.0, 2.0)):
        bodies = plan.mechanism_of(number).bodies
        assert list(bodies) == ["arm-1", "arm-2", "arm-3", "arm-4"]
        assert bodies["arm-2"].length == length / 4
        assert set(plan.members[number].packages) == set(bodies)


def spinning(segments: int, **changes: Any) -> tuple[list[np.ndarray], dict[str, Any]]:
    """A hinged beam under its weight; the same signals for any number of segments."""
    K = np.diag([1e5, 1e5, 1e5, 50.0, 200.0, 30.0])
    mass = SectionMass(1.0, np.zeros(3), 1e-4 * np.diag([2.0, 1.0, 1.0])).matrix()
    modes = [{"kind": "bending-xy", "count": 3}]
    modes += [{"kind": "attachment", "at": at, "directions": ["rz"]} for at in ("root", "tip")]
    modes += [{"kind": "static-axial"}]
    interfaces = {"root": {"at": "start"}, "mid": {"at": 0.5}, "tip": {"at": "end"}}
    body = {
        "elements": 16,
        "interfaces": interfaces,
        "reference": {"kind": "chord", "at": ["root", "tip"]},
        "rotation_deg": [0.0, 0.0, 30.0],
        **({"modes": modes} if segments == 1 else {}),
    }
    table = cantilever(segments, 1.0, body=body, gravity=[0.0, -9.81, 0.0])
    table["joints"]["clamp"] |= {"kind": "revolute", "axis": [0.0, 0.0, 1.0]}
    table["signals"] = {
        "deflection": {"kind": "deflection", "at": "beam.mid", "component": "y"},
        "seen": {
            "kind": "deflection", "at": "beam.tip", "seen_from": "beam.root", "component": "y"
        },
        "rotation": {"kind": "rotation", "at": "beam.tip", "component": "z"},
        "place": {"kind": "position", "at": "beam.tip", "component": "x"},
        "moment": {"kind": "resultant", "body": "beam", "x": 0.5, "component": "M3"},
    }  # fmt: skip
    table["solver"] = {"t_end": 0.4, "output_step": 0.1, "geometric_stiffening": True}
    result, summary = execute(run_of(table | changes, (K, mass)), progress=False)
    assert summary["completed"]
    return [signal.values for signal in result.signals], summary


def test_signals_are_those_of_one_body() -> None:
    """Deflections in the frame of the whole body, resultants at places along it."""
    one, _ = spinning(1)
    four, _ = spinning(4)
    for a, b in zip(one, four, strict=True):
        # the high vibrations are not the same
        np.testing.assert_allclose(b, a, atol=0.04 * np.abs(a).max())
        assert np.abs(a).max() > 1e-3


def test_resultants_of_an_arc_are_found_along_it() -> None:
    """Up to its full length, though its elements are chords: in one body and in segments."""
    K = np.diag([1e5, 1e5, 1e5, 50.0, 200.0, 30.0])
    mass = SectionMass(1.0, np.zeros(3), 1e-4 * np.diag([2.0, 1.0, 1.0])).matrix()
    found = []
    for segments in (1, 3):
        modes = {"modes": [{"kind": "attachment", "at": "tip"}]} if segments == 1 else {}
        body = {"elements": 12, "line": {"arc_deg": 90.0}, "damping_ratio": 0.3, **modes}
        table = cantilever(segments, 1.5, body=body)
        law = {"smooth_step": {"value": 0.1, "duration": 20.0}}
        load = {"kind": "force", "at": "beam.tip", "direction": [0.0, 0.0, 1.0], "law": law}
        table["forces"] = {"load": load}
        table["signals"] = {
            f"{name}_{number}": {"kind": "resultant", "body": "beam", "x": x, "component": name}
            for number, x in enumerate((0.0, 0.4, 1.5))
            for name in ("F3", "M1")
        }
        table["solver"] |= {"t_end": 25.0, "output_step": 5.0}
        result, summary = execute(run_of(table, (K, mass)), progress=False)
        assert summary["completed"]
        found.append([signal.values[-1] for signal in result.signals])
    one, three = found
    np.testing.assert_allclose(three, one, atol=3e-3)
    np.testing.assert_allclose(np.array(three)[::2], 0.1, rtol=0.03)
    # about the tangent at the root, the force has the radius as its arm
    radius = 1.5 / (np.pi / 2)
    assert abs(three[1]) == pytest.approx(0.1 * radius, rel=0.1)
    assert abs(three[-1]) < 0.01 * radius
