"""Static deformation that the modes of a body miss: told in numbers, cleared by the advice."""

import numpy as np
import pytest
from beam_samples import CLAMPED, Beam, reduced
from judged_samples import judged
from stiffening_samples import rectangle

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
    found = judged(tmp_path, text, {"column": beam.package}, **RADAU | solver)
    return [w for w in found.summary["warnings"] if w["code"] == "modes-too-few"]


def compliance(beam, place, component):
    """Deflection at a place under a unit load there."""
    row = beam.motion(place)[component, 6:]
    return float(row @ np.linalg.solve(beam.package.stiffness, row))


@pytest.mark.parametrize("place", ["mid", "tip"])
@pytest.mark.parametrize("count", [1, 2])
def test_the_share_of_a_moment_that_few_modes_miss(tmp_path, place, count):
    """The number is that of the compliances; at the place the modes have no or half the moment."""
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
        assert (
            "M3 at x = 0.5 m is 0.747 N m by equilibrium and 0 N m by the modes"
            in (entry["message"])
        )
    cleared = told(tmp_path, text, column(count, [static(place, "rz")]))
    assert not any("static" in w["message"].split(":")[1] for w in cleared)


@pytest.mark.parametrize(
    ("kind", "direction", "row", "advised"),
    [("force", [0.0, 0.0, 1.0], "M2", "(z)"), ("torque", [1.0, 0.0, 0.0], "M1", "(rx)")],
)
def test_loads_of_families_without_a_mode(tmp_path, kind, direction, row, advised):
    (entry,) = told(tmp_path, FOOT + load(kind, "tip", direction, 0.01), column(2))
    assert entry["value"] == pytest.approx(1.0)
    assert f"{row} at x = " in entry["message"]
    assert advised in entry["message"]


def test_weight_across_a_beam_with_modes_of_the_other_plane(tmp_path):
    """A load without a place: vibration modes carry it."""
    other = reduced(CLAMPED, [{"kind": "bending-xz", "count": 1}], K=K, mass=MASS, length=LENGTH)
    (entry,) = told(tmp_path, "gravity = [0.0, -9.81, 0.0]\n" + FOOT, other)
    assert entry["value"] == pytest.approx(1.0)
    assert entry["message"].endswith("Take more vibration modes (bending-xy)")


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
    assert not any("static" in w["message"] for w in told(tmp_path, text, full, start=start))
    bare = column(1, [{"kind": "bending-xz", "count": 1}], reference)
    (entry,) = [w for w in told(tmp_path, text, bare, start=start) if "miss" in w["message"]]
    assert "tip (rz)" in entry["message"]
