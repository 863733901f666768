"""Static deformation that the modes of a body miss: told in numbers, cleared by the advice."""

import numpy as np
import pytest
from samples.beam_samples import CLAMPED, Beam, reduced
from samples.case_samples import rigid
from samples.curved_samples import meshed
from samples.judged_samples import judged
from samples.modes_samples import modes_at, rates
from samples.segment_samples import cantilever, run_of
from samples.stiffening_samples import rectangle

from plymotion.solver.checks.judge import checked
from plymotion.solver.package import write_package
from plymotion.solver.run.preparation import integrated, prepare

K, MASS = rectangle(70e9, 0.3, 2700.0, 0.004, 0.02)
LENGTH, EI = 0.5, K[5, 5]
RADAU = {"integrator": "radau", "rtol": 1e-6}
CHORD = {"kind": "chord", "at": ["root", "tip"]}
MEAN = {"kind": "mean-axis"}
ROOT = [{"kind": "attachment", "at": "root", "directions": ["y", "rz"]}]
FOOT = """
[bodies.column]
kind = "package"
package = "column.vtkhdf"
[ground.foot]
position = [0.0, 0.0, 0.0]
[joints.foot]
kind = "fixed"
between = ["ground.foot", "column.root"]
"""


def column(count, more=(), reference=CLAMPED) -> Beam:
    modes = [{"kind": "bending-xy", "count": count}, *more]
    return reduced(reference, modes, K=K, mass=MASS, length=LENGTH, elements=12)


def static(place, *directions):
    return {"kind": "attachment", "at": place, "directions": list(directions)}


def load(kind, place, direction, size):
    """A force or torque that acts from t = 0 on."""
    return f"""
[forces.load]
kind = "{kind}"
at = "column.{place}"
direction = {direction}
law = {{ constant = {size} }}
"""


def told(tmp_path, text, beam, **solver):
    """Findings of a third of a second: several periods of the modes that bend."""
    found = judged(tmp_path, text, {"column": beam.package}, t_end=0.3, **RADAU | solver)
    return [w for w in found.summary["warnings"] if w["code"] == "modes-too-few"]


def compliance(beam, place, component):
    """Deflection at a place under a unit load there."""
    row = beam.motion(place)[component, 6:]
    return float(row @ np.linalg.solve(beam.package.stiffness, row))


@pytest.mark.parametrize("place", ["mid", "tip"])
@pytest.mark.parametrize("count", [1, 2])
def test_the_share_of_a_moment_that_few_modes_miss(tmp_path, place, count):
    """The number is that of the compliances; the rotation M L / EI is that of beam theory."""
    beam, text = column(count), FOOT + load("torque", place, [0.0, 0.0, 1.0], 0.05 * EI / LENGTH)
    whole = compliance(column(count, [static(place, "rz")]), place, 5)
    true = 1.0 - compliance(beam, place, 5) / whole
    (entry,) = told(tmp_path, text, beam)
    assert 0.1 < true < 0.4
    assert entry["value"] == pytest.approx(true, rel=0.05)
    assert entry["body"] == "column"
    assert f"miss about {entry['value']:.0%} of the static deformation" in entry["message"]
    assert f'"attachment" at {place} (rz)' in entry["message"]
    if place == "tip":
        turn = 0.05 * compliance(beam, place, 5) * EI / LENGTH
        words = f"(rz) at tip turns it by 0.05 rad in equilibrium and by {turn:.3g} rad with"
        assert words in entry["message"]
    assert told(tmp_path, text, column(count, [static(place, "rz")])) == []


@pytest.mark.parametrize(
    ("kind", "direction", "advised"),
    [("force", [0.0, 0.0, 1.0], "(z)"), ("torque", [1.0, 0.0, 0.0], "(rx)")],
)
def test_loads_of_families_without_a_mode(tmp_path, kind, direction, advised):
    (entry,) = told(tmp_path, FOOT + load(kind, "tip", direction, 0.01), column(2))
    assert entry["value"] == pytest.approx(1.0)
    assert entry["message"].endswith(f'Take modes of kind "attachment" at tip {advised}')


def test_weight_across_a_beam_with_modes_of_the_other_plane(tmp_path):
    """A load without a place: vibration modes carry it."""
    other = reduced(CLAMPED, [{"kind": "bending-xz", "count": 1}], K=K, mass=MASS, length=LENGTH)
    (entry,) = told(tmp_path, "gravity = [0.0, -9.81, 0.0]\n" + FOOT, other)
    assert entry["value"] == pytest.approx(1.0)
    assert entry["message"].endswith("Take more vibration modes (bending-xy)")
    sag = MASS[0, 0] * 9.81 * LENGTH**4 / (20.0 * EI)  # mean of the deflection of a cantilever
    assert f"along y, in the mean, by {-sag:.3g} m in equilibrium and by 0 m" in entry["message"]


@pytest.mark.parametrize("text", ["gravity = [0.0, -9.81, 0.0]\n" + FOOT, FOOT])
def test_loads_that_one_mode_carries_and_no_loads(tmp_path, text):
    """Weight misses 1 %, a force at the tip 3 %, a beam without load nothing."""
    assert told(tmp_path, text, column(1)) == []
    assert told(tmp_path, text + load("force", "tip", [0.0, -1.0, 0.0], 0.5), column(1)) == []


@pytest.mark.parametrize("reference", [CHORD, MEAN])
@pytest.mark.parametrize("start", ["positions", "equilibrium"])
def test_frames_that_are_not_clamped_need_the_shape_of_the_load(tmp_path, reference, start):
    """The static shapes of a joint vibrate fast: what they leave is not taken for a static load."""
    text = FOOT + load("torque", "tip", [0.0, 0.0, 1.0], 0.05 * EI / LENGTH)
    full = column(2, [*ROOT, static("tip", "rz")], reference)
    assert told(tmp_path, text, full, start=start) == []
    bare = column(1, [{"kind": "bending-xz", "count": 1}], reference)
    (entry,) = told(tmp_path, text, bare, start=start)
    assert "tip (rz)" in entry["message"]


def arch(modes) -> Beam:
    """A quarter of a circle of 0.5 m, clamped at its start."""
    line = meshed(24, length=0.25 * np.pi, line={"arc_deg": 90.0, "axis": [0.0, 0.0, 1.0]})
    places = {"root": {"at": "start"}, "tip": {"at": "end"}}
    entries = {"K": K, "mass": MASS, "interfaces": places, **line}
    return reduced(CLAMPED, modes, **entries)


@pytest.mark.parametrize(
    ("kind", "direction", "mode", "whole"),
    [
        ("force", "x", "bending-xy", np.pi / 4.0 * 0.5**3),
        ("torque", "rz", "axial", np.pi / 2.0 * 0.5),  # its first mode in the plane moves along x
    ],
)
def test_a_curved_beam_with_one_mode(tmp_path, kind, direction, mode, whole):
    """Of a thin arch of radius R: u_x = pi / 4 F R^3 / EI, and it turns by pi / 2 M R / EI."""
    axis, row = ([1.0, 0.0, 0.0], 0) if kind == "force" else ([0.0, 0.0, 1.0], 5)
    beam = arch([{"kind": mode, "count": 1}])
    text = FOOT + load(kind, "tip", axis, 0.01 * EI)
    (entry,) = told(tmp_path, text, beam)
    true = 1.0 - compliance(beam, "tip", row) * EI / whole
    assert entry["value"] == pytest.approx(true, rel=0.01)
    found = float(entry["message"].split("s it by ")[1].split()[0])
    assert found == pytest.approx(0.01 * whole, rel=2e-3)
    assert entry["message"].endswith(f'Take modes of kind "attachment" at tip ({direction})')
    more = arch([{"kind": mode, "count": 1}, static("tip", direction)])
    assert told(tmp_path, text, more) == []


COUPLER = """
gravity = [0.0, 0.0, 0.0]
[ground.left]
position = [0.0, 0.0, 0.0]
[ground.right]
position = [0.5, -0.3, 0.0]
[bodies.column]
kind = "package"
package = "column.vtkhdf"
position = [0.0, 0.1, 0.0]
[joints.crank]
kind = "revolute"
between = ["ground.left", "one.low"]
axis = [0.0, 0.0, 1.0]
drive = { polynomial = [0.0, 0.5] }
[joints.one]
kind = "revolute"
between = ["one.high", "column.root"]
axis = [0.0, 0.0, 1.0]
[joints.two]
kind = "revolute"
between = ["column.tip", "two.high"]
axis = [0.0, 0.0, 1.0]
[joints.rocker]
kind = "revolute"
between = ["ground.right", "two.low"]
axis = [0.0, 0.0, 1.0]
[forces.brake]
kind = "torque"
at = "column.tip"
direction = [0.0, 0.0, 1.0]
law = { table = { times = [0.0, 0.5, 1.0], values = [0.0, 0.5, 0.5] } }
[signals.bent]
kind = "rotation"
at = "column.tip"
component = "z"
"""


@pytest.mark.parametrize(
    ("reference", "turn"), [(CLAMPED, 1.0 / 2.0), (CHORD, 1.0 / 3.0), (MEAN, None)]
)
def test_a_coupler_of_one_mode_in_a_closed_loop(tmp_path, reference, turn):
    """A moment M at a beam between hinges turns its end by M L / 3 EI from the chord.

    It turns by M L / 2 EI from the other end. With ten modes and the shapes of the loads, the
    signal ends at 0.0168, 0.0112 and 0.0118 rad, with one mode at 0.0057, 0.0068 and 0.0057 rad.
    """
    high = {"low": (0, 0, 0), "high": (0, 0.4, 0)}
    text = COUPLER + rigid("one", 0.1, 1e-4, {"low": (0, 0, 0), "high": (0, 0.1, 0)})
    text += rigid("two", 0.1, 1e-4, high, position=(0.5, -0.3, 0))
    found = judged(tmp_path, text, {"column": column(1, reference=reference).package}, **RADAU)
    entry, few = found.finding("modes-too-few"), found.summary["signals"]["bent"]["final"]
    words = entry["message"].split("turns it by ")[1].split()
    whole, carried = float(words[0]), float(words[words.index("by") + 1])
    assert carried == pytest.approx(few, rel=0.03)
    if turn:
        assert whole == pytest.approx(turn * 0.5 * LENGTH / EI, rel=0.01)
    assert entry["message"].endswith('"attachment" at tip (rz)')
    full = column(1, [static("tip", "rz"), *([] if reference == CLAMPED else ROOT)], reference)
    cleared = judged(tmp_path, text, {"column": full.package}, t_end=0.1, **RADAU)
    assert "modes-too-few" not in cleared.codes


def test_a_load_that_the_start_releases(tmp_path):
    """In equilibrium under a moment, which ends at once: nothing else loads the beam."""
    law = "law = { table = { times = [0.0, 1e-3, 2e-3, 2.0], values = [1.0, 1.0, 0.0, 0.0] } }"
    text = FOOT + load("torque", "tip", [0.0, 0.0, 1.0], 1.0)
    text = text.replace("law = { constant = 1.0 }", law)
    (entry,) = told(tmp_path, text, column(1), start="equilibrium")
    assert entry["value"] == pytest.approx(0.387, abs=0.01)
    assert entry["t"] == 0.0
    full = column(1, [static("tip", "rz")])
    assert told(tmp_path, text, full, start="equilibrium") == []


def round_shaft(more=()):
    K, mass = rectangle(70e9, 0.3, 2700.0, 0.01, 0.01)
    modes = [{"kind": f"bending-{plane}", "count": 3} for plane in ("xy", "xz")]
    places = {"root": {"at": "start"}, "mid": {"at": 0.5}, "tip": {"at": "end"}}
    return reduced(
        CHORD, [*modes, *more], K=K, mass=mass, length=LENGTH, elements=12, interfaces=places
    )


DISC = """
[bodies.shaft]
kind = "package"
package = "shaft.vtkhdf"
[ground.foot]
position = [0.0, 0.0, 0.0]
[ground.end]
position = [0.5, 0.0, 0.0]
[joints.disc]
kind = "fixed"
between = ["shaft.mid", "disc.c"]
[joints.tip]
kind = "point_on_line"
between = ["ground.end", "shaft.tip"]
axis = [1.0, 0.0, 0.0]
""" + rigid("disc", 2.0, 1e-3, {"c": (0, 0, 0)}, position=(0.25, 0, 0))
HINGE = """
[joints.foot]
kind = "revolute"
between = ["ground.foot", "shaft.root"]
axis = [1.0, 0.0, 0.0]
drive = { speed = 200.0 }
"""
HELD = """
[joints.foot]
kind = "fixed"
between = ["ground.foot", "shaft.root"]
"""


def test_weight_on_a_shaft_that_turns(tmp_path):
    """The inertia of the spin along the body is large, and strains it little."""
    text, found = "gravity = [0.0, -9.81, 0.0]\n" + DISC + HINGE, []
    for more in ((), [static("root", "ry", "rz")]):
        options = {"t_end": 0.1, "output_step": 1e-3, "start": "quasi-static"}
        shaft = {"shaft": round_shaft(more).package}
        done = judged(tmp_path, text, shaft, geometric_stiffening=True, **options, **RADAU)
        found.append([w for w in done.summary["warnings"] if w["code"] == "modes-too-few"])
    ((entry,), cleared) = found
    assert entry["value"] > 0.25
    assert {"ry", "rz"} == set(entry["message"].split('"attachment" at root (')[1][:-1].split())
    assert cleared == []


def test_modes_of_a_mechanism_whose_body_lacks_a_shape(tmp_path, capsys):
    """The first frequency of a clamped and pinned shaft is 16 % too high without its shape."""
    folder, lowest, notes = tmp_path / "sample", [], []
    folder.mkdir()
    for more in ((), [static(at, "ry", "rz") for at in ("root", "mid")]):
        write_package(folder / "shaft.vtkhdf", round_shaft(more).package)
        found = modes_at(tmp_path, DISC + HELD, "start", capsys=capsys)
        lowest.append(rates(found)[0])
        notes.append([note for note in found["notes"] if "frequencies too high" in note])
    (note,), none = notes
    assert none == []
    assert 'attachment" at root (r' in note
    assert lowest[0] / lowest[1] == pytest.approx(1.16, abs=0.04)


def test_rounding_beside_a_load_along_beams_is_no_load():
    """A straight beam is not judged for loads along it, nor for what they leave across it."""
    table = cantilever(1, LENGTH)
    beam = table["bodies"]["beam"] | {"modes": [{"kind": "bending-xy", "count": 1}]}
    table["bodies"] = {"beam": beam, "next": beam | {"position": [LENGTH, 0.0, 0.0]}}
    table["joints"]["middle"] = {"kind": "fixed", "between": ["beam.tip", "next.root"]}
    law = {"smooth_step": {"value": 1.0, "duration": 0.2}}
    push = {"kind": "force", "at": "next.tip", "direction": [-1.0, 1e-12, 0.0], "law": law}
    table["solver"] |= {"output_step": 0.005, **RADAU}
    spec = run_of(table | {"forces": {"push": push}}, (K, MASS))
    found = checked(integrated(prepare(spec.mechanism, spec.packages)))
    assert "modes-too-few" not in {finding.code for finding in found}
