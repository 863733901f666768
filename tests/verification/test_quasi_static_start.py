"""Quasi-static start: bodies begin in the shape that the loads at t = 0 call for."""

import json

import numpy as np
import pytest
from samples.beam_samples import CLAMPED, MEAN_AXIS, clamped_file, reduced
from samples.case_samples import HEAD, computed_file, run_text
from samples.segment_samples import cantilever, run_of
from samples.stiffening_samples import rectangle

from plymotion.solver.errors import InputError
from plymotion.solver.package import write_package
from plymotion.solver.package.body.invariants import inertia_at_rest
from plymotion.solver.run.preparation import prepare

ARM = """
gravity = [0.0, -9.81, 0.0]
[ground.root]
position = [0.0, 0.0, 0.0]
[bodies.beam]
kind = "package"
package = "beam.vtkhdf"
[joints.root]
kind = "{joint}"
between = ["ground.root", "beam.root"]
{more}
[signals.tip]
kind = "deflection"
at = "beam.tip"
component = "y"
[signals.moment]
kind = "reaction"
joint = "root"
quantity = "moment"
component = "z"
"""
ACCELERATION = 0.2  # [rad/s2], too small for a centrifugal effect
DRIVE = f"axis = [0.0, 0.0, 1.0]\ndrive = {{ polynomial = [0.0, 0.0, {0.5 * ACCELERATION}] }}"
QUASI = 'start = "quasi-static"'


@pytest.fixture
def beam(tmp_path):
    return clamped_file(tmp_path, 3)


def test_a_clamped_beam_under_its_weight_is_at_rest(beam, tmp_path):
    """The quasi-static shape of a mechanism at rest is that of static equilibrium."""
    text = ARM.format(joint="fixed", more="")
    _, found, _ = run_text(tmp_path, text, t_end=0.05, step=0.005, more=QUASI)
    p = beam.invariants.S_B[1] * -9.81
    tip = next(place for place in beam.interfaces if place.name == "tip")
    static = float(tip.phi_B[1] @ np.linalg.solve(beam.stiffness, p))
    np.testing.assert_allclose(found["tip"], static, rtol=1e-7)


def test_a_drive_with_acceleration_does_not_ring(beam, tmp_path):
    """The deflection and the moment of a drive that begins with an acceleration stay as they are.

    The moment is that of the rigid body: alpha times its moment of inertia about the root.
    """
    text = ARM.replace("-9.81", "0.0").format(joint="revolute", more=DRIVE)
    t_end = 4.0 * np.pi / float(beam.frequencies[0])
    _, sudden, _ = run_text(tmp_path, text, t_end=t_end, step=t_end / 50)
    _, gentle, _ = run_text(tmp_path, text, t_end=t_end, step=t_end / 50, more=QUASI)
    moment = ACCELERATION * float(inertia_at_rest(beam.invariants)[2, 2])
    np.testing.assert_allclose(np.abs(gentle["moment"][0]), moment, rtol=1e-4)
    assert np.ptp(gentle["tip"][:10]) < 0.05 * np.abs(gentle["tip"]).max()
    assert np.ptp(sudden["tip"]) > 1.5 * np.abs(gentle["tip"][0])


def test_shapes_begin_at_the_rate_of_their_loads(beam, tmp_path):
    """The acceleration of the drive grows in proportion to the time, and so does the deflection.

    Begun at rest, it vibrates by its rate over the frequency.
    """
    more = "axis = [0.0, 0.0, 1.0]\ndrive = { polynomial = [0.0, 0.0, 0.0, 0.01] }"
    text = ARM.replace("-9.81", "0.0").format(joint="revolute", more=more)
    w = float(beam.frequencies[0])
    t, found, _ = run_text(tmp_path, text, t_end=20.0 / w, step=0.2 / w, more=QUASI)
    rate = np.polyfit(t, found["tip"], 1)[0]
    assert np.abs(found["tip"] - rate * t).max() < 0.01 * abs(rate) / w


def test_rates_that_do_not_last_are_not_followed(beam, tmp_path):
    """A load that is there after a thousandth of a period: its rate would be 15 times its size."""
    w = float(beam.frequencies[0])
    law = f"{{ table = {{ times = [0.0, {0.01 / w}, 1.0], values = [0.0, 1.0, 1.0] }} }}"
    push = '[forces.push]\nkind = "force"\nat = "beam.tip"\ndirection = [0.0, 1.0, 0.0]\n'
    text = ARM.replace("-9.81", "0.0").format(joint="fixed", more=f"{push}law = {law}\n")
    _, found, _ = run_text(tmp_path, text, t_end=10.0 / w, step=0.1 / w, more=QUASI)
    tip = next(place for place in beam.interfaces if place.name == "tip")
    static = float(tip.phi_B[1] @ np.linalg.solve(beam.stiffness, tip.phi_B[1]))
    assert found["tip"].max() < 2.1 * static


def test_what_a_body_carries_makes_its_vibrations_slow():
    """A turn within a small part of the period with a rigid body of 2 kg: no rate is followed."""
    table = cantilever(1, 1.0, body={"modes": [{"kind": "bending-xy", "count": 1}]})
    point = {"c": {"position": [0.0, 0.0, 0.0]}}
    bob = {"kind": "rigid", "mass": 2.0, "inertia": np.eye(3).tolist(), "interfaces": point}
    table["bodies"]["bob"] = bob | {"position": [1.0, 0.0, 0.0]}
    turn = {"smooth_step": {"value": 0.5, "duration": 0.1}}
    table["joints"]["clamp"] |= {"kind": "revolute", "axis": [0.0, 0.0, 1.0], "drive": turn}
    table["joints"]["held"] = {"kind": "fixed", "between": ["beam.tip", "bob.c"]}
    table["solver"]["start"] = "quasi-static"
    spec = run_of(table, rectangle(70e9, 0.3, 2700.0, 0.01, 0.02))
    ready = prepare(spec.mechanism, spec.packages)
    assert not ready.y0[ready.model.n_pos :].any()


def long_beam(folder, reference):
    """A beam of 100 m and 810 t: a unit of a mode is 1 mm. Sags by 6 m when clamped."""
    K, mass = rectangle(70e9, 0.3, 2700.0, 3.0, 1.0)
    kept = [{"kind": "bending-xy", "count": 3}, {"kind": "attachment", "at": "root"}]
    package = reduced(reference, kept, K=K, mass=mass, length=100.0, elements=10).package
    write_package(folder / "beam.vtkhdf", package)
    return package


def test_equilibrium_of_a_long_beam(tmp_path):
    """Its modal coordinates are in the thousands: steps are limited by displacements."""
    package = long_beam(tmp_path, CLAMPED)
    text = ARM.format(joint="fixed", more="")
    _, found, _ = run_text(tmp_path, text, t_end=0.01, step=0.01, more='start = "equilibrium"')
    tip = next(place for place in package.interfaces if place.name == "tip")
    static = tip.phi_B[1] @ np.linalg.solve(package.stiffness, package.invariants.S_B[1] * -9.81)
    assert static < -5.0
    np.testing.assert_allclose(found["tip"][0], static, rtol=1e-6)


def test_joints_keep_their_coordinates(tmp_path):
    """A mean axis turns as the root bends: a stiff drive of the hinge would push back.

    Its moment carries the weight, so that the beam rests with the deflection of a clamped one,
    w L^4 / 8 EI (1 + 4 EI / GA L^2).
    """
    long_beam(tmp_path, MEAN_AXIS)
    weight = 2700.0 * 3.0 * 9.81
    text = ARM.replace('component = "y"', 'component = "y"\nseen_from = "beam.root"', 1)
    hinge = 'axis = [0.0, 0.0, 1.0]\n[forces.drive]\nkind = "coordinate_force"\njoint = "root"\n'
    hinge += f'expression = "{0.5 * weight * 100.0**2} - 1e12 * x"'
    more = hinge + '\n[signals.angle]\nkind = "joint"\njoint = "root"'
    text = text.format(joint="revolute", more=more)
    _, found, summary = run_text(tmp_path, text, t_end=0.2, step=0.02, more=QUASI)
    EI, GA = 70e9 * 3.0**3 / 12.0, 5.0 / 6.0 * 70e9 / 2.6 * 3.0
    static = -weight * 100.0**4 / (8.0 * EI) * (1.0 + 4.0 * EI / (GA * 100.0**2))
    np.testing.assert_allclose(found["tip"], static, rtol=2e-3)
    assert np.abs(found["angle"]).max() < 1e-6
    assert "loads-begin-suddenly" not in {w["code"] for w in summary["warnings"]}


def test_frames_that_tilt_keep_their_spins(tmp_path):
    """A beam on a pitch bearing of a turning hub bends: its mean axis tilts, its pitch rests.

    With the given components in the tilted axes the bearing would turn at 0.02 rad/s.
    """
    long_beam(tmp_path, MEAN_AXIS)
    spin = "angular_velocity = [0.0, 0.3, 0.0]\n"
    text = ARM.replace('["ground.root"', '["hub.root"').replace('.vtkhdf"\n', f'.vtkhdf"\n{spin}')
    hub = f'[bodies.hub]\nkind = "rigid"\nmass = 1e5\n{spin}'
    hub += "inertia = [[1e6, 0, 0], [0, 1e6, 0], [0, 0, 1e6]]\n"
    hub += "interfaces = { root = { position = [0.0, 0.0, 0.0] } }\n"
    hub += '[joints.hub]\nkind = "revolute"\nbetween = ["ground.root", "hub.root"]\n'
    hub += "axis = [0.0, 1.0, 0.0]\n"
    damper = 'axis = [1.0, 0.0, 0.0]\n[forces.rate]\nkind = "coordinate_force"\njoint = "root"\n'
    damper += 'expression = "v"\n[signals.rate]\nkind = "force"\nof = "rate"\n'
    text = text.format(joint="revolute", more=damper) + hub
    _, found, _ = run_text(tmp_path, text, t_end=1e-3, step=1e-3, more=QUASI)
    assert found["tip"][0] < -0.3
    assert abs(found["rate"][0]) < 1e-6


def test_loads_that_grow_with_the_deformation_are_told(beam, tmp_path):
    """A spin beyond the first frequency: no shape balances its loads."""
    w = float(beam.frequencies[0])
    more = f"axis = [0.0, 0.0, 1.0]\ndrive = {{ speed = {3.0 * w} }}"
    text = ARM.format(joint="revolute", more=more)
    with pytest.raises(InputError, match="the shape of beam does not converge"):
        run_text(tmp_path, text, t_end=0.01, step=0.001, more=QUASI)


def coupled(share=0.3):
    """A section that twists as it bends in the plane: K_46 over the root of K_44 K_66."""
    K, mass = rectangle(70e9, 0.3, 2700.0, 0.004, 0.02)
    K[3, 5] = K[5, 3] = share * np.sqrt(K[3, 3] * K[5, 5])
    return K, mass


def twisting_loop(folder, modes, drive, **solver):
    """Summary and signals of a four-bar of hinges whose members twist as they bend."""
    K, mass = coupled()
    package = reduced(CLAMPED, modes, K=K, mass=mass, length=0.5, elements=8).package
    write_package(folder / "member.vtkhdf", package)
    x, y = 0.25, 0.5 * np.sin(np.pi / 3)
    text = HEAD + "gravity = [0.0, -9.81, 0.0]\n"
    for name, at, turn in (("crank", (0, 0), 60), ("coupler", (x, y), 0), ("rocker", (0.5, 0), 60)):
        text += (
            f'[bodies.{name}]\nkind = "package"\npackage = "member.vtkhdf"\n'
            f"position = [{at[0]}, {at[1]}, 0.0]\nrotation_deg = [0.0, 0.0, {turn}]\n"
        )
    text += "[ground.A]\nposition = [0.0, 0.0, 0.0]\n[ground.D]\nposition = [0.5, 0.0, 0.0]\n"
    hinges = (
        ("ground.A", "crank.root", f"drive = {{ {drive} }}"),
        ("crank.tip", "coupler.root", ""),
        ("coupler.tip", "rocker.tip", ""),
        ("ground.D", "rocker.root", ""),
    )
    for k, (one, two, key) in enumerate(hinges):
        text += f'[joints.j{k}]\nkind = "revolute"\nbetween = ["{one}", "{two}"]\n{key}\n'
    text += '[signals]\nmoment = { kind = "reaction", joint = "j0", quantity = "moment", '
    text += 'component = "z" }\n[solver]\nt_end = 0.02\noutput_step = 0.0005\n'
    text += "".join(f"{key} = {json.dumps(value)}\n" for key, value in solver.items())
    result, summary = computed_file(folder / "case.toml", f"{text}[runs.base]\n")
    return summary, {s.name: s.values for s in result.signals}


BENDING = {"kind": "bending-xy", "count": 3}
MODE_SETS = (
    [BENDING],
    [BENDING, {"kind": "torsion", "count": 2}],
    [{"kind": "lowest", "count": 8}, {"kind": "attachment", "at": "tip"}],
)


@pytest.mark.parametrize("modes", MODE_SETS, ids=["bending", "torsion", "complete"])
@pytest.mark.parametrize(
    "drive", ["polynomial = [0.0, 0.0, 20.0]", "polynomial = [0.0, 5.0]"], ids=["begins", "speed"]
)
def test_a_loop_of_hinges_whose_members_twist_as_they_bend(tmp_path, modes, drive):
    """Rigid members cannot close it once they have twisted: "cannot be assembled"."""
    summary, _ = twisting_loop(tmp_path, modes, drive, start="quasi-static")
    assert summary["completed"]
    codes = {w["code"] for w in summary["warnings"]}
    assert not {"loads-begin-suddenly", "start-moved", "mechanism-locked"} & codes


def test_the_loop_begins_without_a_vibration(tmp_path):
    """The torque of the drive swings from the undeformed start, and is steady from this one."""
    swings = {}
    for start in ("positions", "quasi-static"):
        folder = tmp_path / start
        folder.mkdir()
        drive = "polynomial = [0.0, 0.0, 20.0]"
        _, signals = twisting_loop(folder, MODE_SETS[2], drive, start=start, rtol=1e-7)
        swings[start] = float(np.ptp(signals["moment"]))
    assert swings["quasi-static"] < 0.02 * swings["positions"]
