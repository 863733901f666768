"""Runs that are right, and got a false alarm; beside them, the same alarm where it is true."""

import json

import numpy as np
import pytest
from samples.beam_samples import CLAMPED, reduced
from samples.case_samples import HEAD, computed_file, rigid
from samples.stiffening_samples import rectangle

from plymotion.solver.package import write_package

K, MASS = rectangle(70e9, 0.3, 2700.0, 0.004, 0.02)
LENGTH = 0.5
EULER = np.pi**2 * K[5, 5] / (4.0 * LENGTH**2)
BEND = 0.3 * K[5, 5] / LENGTH**3  # as in test_judgement.py
GROUND = "[ground.o]\nposition = [0.0, 0.0, 0.0]\n"
WEIGHT = "gravity = [0.0, -9.81, 0.0]\n"
ALPHA = {"integrator": "generalized-alpha", "constraints": "ggl"}


def found(tmp_path, text, packages=None, *, t_end, step, **solver):
    """Summary of a run with the tolerances that follow from its scales."""
    for name, package in (packages or {}).items():
        write_package(tmp_path / f"{name}.vtkhdf", package)
    keys = {"t_end": t_end, "output_step": step} | solver
    lines = "".join(f"{key} = {json.dumps(value)}\n" for key, value in keys.items())
    return computed_file(tmp_path / "case.toml", f"{HEAD}{text}\n[solver]\n{lines}[runs.base]\n")[1]


def codes(summary):
    return {w["code"]: w for w in summary["warnings"]}


def slide(at, stiffness=100.0, more=""):
    return (
        rigid("car", 1.0, 0.1, {"a": (0, 0, 0)}, position=[at, 0, 0])
        + GROUND
        + f"""
[joints.rail]
kind = "prismatic"
between = ["ground.o", "car.a"]
axis = [1.0, 0.0, 0.0]
{more}
[forces.spring]
kind = "spring"
between = ["ground.o", "car.a"]
stiffness = {stiffness}
length = 1.0
"""
    )


def crank(drive=""):
    return (
        rigid("bar", 1.0, 0.1, {"pin": (-1, 0, 0)}, position=[1.0, 0, 0])
        + GROUND
        + f"""
[joints.hinge]
kind = "revolute"
between = ["ground.o", "bar.pin"]
{drive}
"""
    )


def column(length=LENGTH, count=3):
    modes = [
        {"kind": "bending-xy", "count": count},
        {"kind": "attachment", "at": "tip", "directions": ["x", "y"]},
    ]
    return reduced(CLAMPED, modes, K=K, mass=MASS, length=length, elements=4).package


def clamped(force="", law=""):
    load = f'[forces.load]\nkind = "force"\nat = "column.tip"\n{force}\nlaw = {{ {law} }}\n'
    return (
        '[bodies.column]\nkind = "package"\npackage = "column.vtkhdf"\n'
        + GROUND
        + '[joints.foot]\nkind = "fixed"\nbetween = ["ground.o", "column.root"]\n'
        + (load if force else "")
    )


def test_output_times_at_turning_points(tmp_path):
    """No kinetic energy at any output time; the scale comes from all steps."""
    period = 2.0 * np.pi / 10.0
    summary = found(tmp_path, slide(1.3), t_end=10 * period, step=period)
    assert codes(summary) == {}
    assert summary["checks"]["energy_drift_relative"] < 1e-4
    loose = found(
        tmp_path, slide(1.3), t_end=100 * period, step=period, rtol=1e-2, integrator="rk5"
    )
    assert codes(loose)["energy-drift"]["value"] > 1e-3


@pytest.mark.parametrize("integrator", ["radau", "rk8", "gear"])
def test_a_beam_at_rest_has_an_energy_to_compare_with(tmp_path, integrator):
    """The strain energy of its deflection: errors of 1e-8 of it were 0.3 of the kinetic energy."""
    solver = {"start": "equilibrium", "integrator": integrator, "rtol": 1e-6}
    text = WEIGHT + clamped()
    summary = found(tmp_path, text, {"column": column()}, t_end=0.3, step=0.001, **solver)
    assert not {"energy-drift", "energy-jump"} & codes(summary).keys()


@pytest.mark.parametrize("integrator", ["rk8", "rk5"])
def test_a_beam_at_rest_stays_at_rest(tmp_path, integrator):
    """At the default rtol: 8e-5 of the strain energy had become vibration by steps too long."""
    text = WEIGHT + clamped()
    solver = {"start": "equilibrium", "integrator": integrator}
    summary = found(tmp_path, text, {"column": column()}, t_end=0.3, step=0.001, **solver)
    assert summary["checks"]["energy_drift_relative"] < 1e-9
    assert codes(summary) == {}


def test_a_mass_at_rest_on_a_spring(tmp_path):
    """The change of its balance is the rounding of potential energies: a jump "by 1" before."""
    text = WEIGHT.replace("0.0, -9.81", "-9.81, 0.0") + slide(1.0, 10.0)
    solver = {"start": "equilibrium", "integrator": "rk8"}
    summary = found(tmp_path, text, t_end=1.0, step=0.01, **solver)
    assert codes(summary) == {}


def test_sparse_output_of_rigid_bodies_is_no_stall(tmp_path):
    """The cutoff was pi / output_step, below the motion; rigid bodies have nothing to damp."""
    text = WEIGHT + crank()
    summary = found(
        tmp_path, text, t_end=24200.0 / 40, step=24.2 / 40, integrator="radau", rtol=1e-7
    )
    assert summary["cost"]["steps"] > 10_000
    assert not {"vibration-damped", "steps-tiny"} & codes(summary).keys()


def test_the_motion_itself_is_not_damped(tmp_path):
    """A vibration of 10 rad/s with all the energy, and results every 3 s."""
    summary = found(tmp_path, slide(1.3), t_end=3000.0, step=3.0, integrator="radau")
    assert summary["checks"]["damped_energy"] == 0.0
    assert "vibration-damped" not in codes(summary)
    assert "output_step" in codes(summary)["steps-tiny"]["message"]


def test_mass_that_joints_take_away_from_a_body_counts_as_none(tmp_path):
    """The clamped root cannot move in the directions in which the body alone has lost its mass."""
    force = "direction = [0.0, 1.0, 0.0]"
    text = clamped(force, f"constant = {0.3 * BEND}")
    modes = [{"kind": "bending-xy", "count": 3}, {"kind": "attachment", "at": "tip"}]
    package = reduced(CLAMPED, modes, K=K, mass=MASS, length=LENGTH, elements=20).package
    solver = {"start": "equilibrium", "geometric_stiffening": True}
    summary = found(tmp_path, text, {"column": package}, t_end=0.01, step=0.001, **solver)
    assert "stiffened-mass-indefinite" not in codes(summary)
    more = text.replace(str(0.3 * BEND), str(BEND))
    summary = found(tmp_path, more, {"column": package}, t_end=0.01, step=0.001, **solver)
    assert codes(summary)["stiffened-mass-indefinite"]["level"] == "warning"


def test_a_drive_that_is_fast_is_no_unstable_feedback(tmp_path):
    drive = "drive = { polynomial = [0.0, 1.0e5] }"
    summary = found(tmp_path, crank(drive), t_end=0.1, step=0.01, integrator="radau", rtol=1e-3)
    assert summary["completed"]
    assert "motion-grows" not in codes(summary)


def test_a_drive_that_turns_at_a_constant_rate_does_no_work(tmp_path):
    """Errors of Newton's iteration had one sign in all steps: 0.01 of the kinetic energy."""
    drive = "drive = { polynomial = [0.0, 1.0e5] }"
    summary = found(tmp_path, crank(drive), t_end=0.01, step=0.001, integrator="radau")
    assert codes(summary) == {}
    assert abs(summary["checks"]["drive_work"]) < 1e-4 * 5.5e9


@pytest.mark.parametrize(
    ("count", "solver"),
    [(61, {"integrator": "radau"}), (201, {"integrator": "radau"}), (61, ALPHA)],
)
def test_a_spline_with_a_jump_is_no_unstable_feedback(tmp_path, count, solver):
    """Its ripples grow towards the jump as fast as a motion that is unstable.

    The energy balance: generalized-alpha takes the interval of the jump in a step without one
    before, and missed 0.58 of the work there.
    """
    times = np.round(np.linspace(0.0, 1.0, count), 6).tolist()
    values = [0.0] * (count - 1) + [1.0]
    drive = f"drive = {{ table = {{ times = {times}, values = {values} }} }}"
    text = slide(0.0, 1.0, drive).split("[forces")[0]
    summary = found(tmp_path, text, t_end=1.0, step=0.002, **solver)
    assert codes(summary) == {}


def test_the_work_of_a_steep_drive(tmp_path):
    """What a drive prescribes has no error at the ends of steps, however long; its work has."""
    drive = "drive = { smooth_step = { value = 3.0, duration = 0.05 } }"
    summary = found(tmp_path, crank(drive), t_end=0.1, step=0.01, rtol=1e-2, **ALPHA)
    assert codes(summary) == {}


def test_no_impact_is_looked_for_where_nothing_jumps(tmp_path):
    drive = "drive = { smooth_step = { value = 30.0, duration = 0.05 } }"
    summary = found(tmp_path, crank(drive), t_end=0.1, step=0.01, rtol=1e-1, integrator="radau")
    words = codes(summary)["energy-jump"]["message"]
    assert "impact" not in words
    assert "decrease rtol, or set max_step" in words


def test_impacts_hardly_refuse_steps(tmp_path):
    """Steps end where the stop begins; otherwise more than a fifth of the attempts are refused."""
    stop = """
[forces.stop]
kind = "limit_stop"
joint = "hinge"
lower = -2.0
stiffness = 1e6
"""
    summary = found(tmp_path, WEIGHT + crank() + stop, t_end=20.0, step=0.01, integrator="rk8")
    cost = summary["cost"]
    assert 0 < cost["rejected"] < 0.1 * (cost["steps"] + cost["rejected"])
    assert "steps-refused" not in codes(summary)


@pytest.mark.parametrize("integrator", ["rk8", "radau"])
def test_refused_steps_at_one_ramp_are_no_trouble(tmp_path, integrator):
    """A force that grows within a thousandth of a run at rest: steps begin anew there."""
    table = "times = [0.0, 5.0, 5.01, 10.0], values = [0.0, 0.0, 1.0, 1.0]"
    push = f"""
[forces.push]
kind = "force"
at = "car.a"
direction = [1.0, 0.0, 0.0]
law = {{ table = {{ {table}, interpolation = "linear" }} }}
"""
    summary = found(tmp_path, slide(1.0) + push, t_end=10.0, step=0.01, integrator=integrator)
    assert codes(summary) == {}


@pytest.mark.parametrize(("duration", "buckles"), [(1e-4, False), (0.02, True)])
def test_a_load_that_passes_at_once_does_not_buckle(tmp_path, duration, buckles):
    """Three times Euler's load, for a thousandth or a quarter of the period of the column."""
    law = f"times = [0.0, {duration}, {2 * duration}, 1.0], values = [0.0, {-3 * EULER}, 0.0, 0.0]"
    force = "direction = [1.0, 0.0, 0.0]"
    text = clamped(force, f'table = {{ {law}, interpolation = "linear" }}')
    solver = {"geometric_stiffening": True, "max_step": duration / 5}
    summary = found(tmp_path, text, {"column": column()}, t_end=0.03, step=0.001, **solver)
    assert ("buckling-by-motion" in codes(summary)) == buckles


def test_a_planar_loop_of_hinges_starts_in_its_quasi_static_shape(tmp_path):
    """Three of its rows follow from the others: the matrix of the start was singular."""
    rod = {"root": (0, 0, 0), "tip": (LENGTH, 0, 0)}
    angles, at, text, before = (-17.6, -30.6, -22.4), np.zeros(2), GROUND, "ground.o"
    for i, angle in enumerate(angles):
        place = {"position": [*at, 0.0], "rotation_deg": [0.0, 0.0, angle]}
        if i == 1:
            lines = "".join(f"{key} = {list(map(float, v))}\n" for key, v in place.items())
            text += f'[bodies.b1]\nkind = "package"\npackage = "b1.vtkhdf"\n{lines}'
        else:
            text += rigid(f"b{i}", 1.0, 0.02, rod, **place)
        text += f'[joints.j{i}]\nkind = "revolute"\nbetween = ["{before}", "b{i}.root"]\n'
        at, before = (
            at + LENGTH * np.array([np.cos(np.radians(angle)), np.sin(np.radians(angle))]),
            f"b{i}.tip",
        )
    text += f"[ground.e]\nposition = {[*map(float, at), 0.0]}\n"
    text += f'[joints.close]\nkind = "revolute"\nbetween = ["{before}", "ground.e"]\n'
    modes = [{"kind": "bending-xy", "count": 3}, {"kind": "bending-xz", "count": 1}]
    beam = reduced(CLAMPED, modes, K=K, mass=MASS, length=LENGTH, elements=4).package
    summary = found(
        tmp_path, text, {"b1": beam}, t_end=0.01, step=0.001, start="quasi-static", integrator="rk8"
    )
    assert codes(summary).keys() == {"redundant-constraints"}
