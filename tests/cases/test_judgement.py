"""Each finding about a run, provoked by a real run, alike in single runs and sweeps."""

import dataclasses

import numpy as np
import pytest
from samples.beam_samples import CHORD, CLAMPED, reduced, straight_line
from samples.case_samples import rigid
from samples.judged_samples import judged, judged_case
from samples.recovery_samples import (
    PLY,
    PLY_STRENGTH,
    mode_resultants,
    plies_of,
    rectangle_recovery,
)
from samples.segment_samples import cantilever, run_of
from samples.stiffening_samples import rectangle
from scipy.optimize import brentq

from plymotion.preprocess.beam.beam_body import mode_warnings
from plymotion.solver.checks.judge import checked
from plymotion.solver.checks.modes import mode_findings
from plymotion.solver.checks.stiffening import undisturbed_findings
from plymotion.solver.run.execution import execute, read_run
from plymotion.solver.run.preparation import integrated, prepare

PENDULUM = (
    "gravity = [0.0, -9.81, 0.0]\n"
    + rigid("bob", 1.0, 0.1, {"pin": (-1, 0, 0)}, position=[1.0, 0.0, 0.0])
    + """
[ground.o]
position = [0.0, 0.0, 0.0]
[joints.hinge]
kind = "revolute"
between = ["ground.o", "bob.pin"]
"""
)
LOOSE = {"rtol": 1e-4, "atol_position": 1e-4, "atol_velocity": 1e-4}
K, MASS = rectangle(70e9, 0.3, 2700.0, 0.004, 0.02)
LENGTH = 0.5
EULER = np.pi**2 * K[5, 5] / (4.0 * LENGTH**2)
BEND = 0.3 * K[5, 5] / LENGTH**3  # tip force that bends by a tenth of the length
RADAU = {"integrator": "radau", "rtol": 1e-6, "atol_position": 1e-9, "atol_velocity": 1e-7}


def column(count=3, *, tip=True, elements=4):
    """A clamped beam with bending modes, and the static ones of a force at its tip."""
    modes = [{"kind": "bending-xy", "count": count}]
    if tip:
        modes.append({"kind": "attachment", "at": "tip", "directions": ["x", "y"]})
    return reduced(CLAMPED, modes, K=K, mass=MASS, length=LENGTH, elements=elements)


def pushed(direction, size):
    """The column fixed at its root, with a force at its tip that grows for half a second."""
    return f"""
[bodies.column]
kind = "package"
package = "column.vtkhdf"
[ground.foot]
position = [0.0, 0.0, 0.0]
[joints.foot]
kind = "fixed"
between = ["ground.foot", "column.root"]
[forces.load]
kind = "force"
at = "column.tip"
direction = {direction}
law = {{ smooth_step = {{ value = {size}, duration = 0.5 }} }}
"""


@pytest.mark.provokes("constraint-drift", "energy-drift")
def test_constraints_without_feedback_drift_apart(tmp_path):
    found = judged(
        tmp_path, PENDULUM, t_end=20.0, step=0.1, integrator="rk5", constraints="index1", **LOOSE
    )
    assert {"constraint-drift", "energy-drift"} <= set(found.codes)
    entry = found.finding("constraint-drift")
    assert entry["value"] == found.summary["checks"]["constraint_position_max"] > entry["limit"]
    assert found.finding("energy-drift")["value"] > 1e-3
    tight = judged(tmp_path, PENDULUM, t_end=2.0, step=0.1)
    assert tight.codes == []


@pytest.mark.provokes("energy-jump")
def test_a_torque_that_jumps_within_a_long_step(tmp_path):
    jump = "times = [0.0, 0.5, 0.5001, 1.0], values = [0.0, 0.0, 200.0, 200.0]"
    knock = f"""
[forces.knock]
kind = "torque"
at = "bob.pin"
direction = [0.0, 0.0, 1.0]
law = {{ table = {{ {jump}, interpolation = "linear" }} }}
"""
    loose = dict.fromkeys(LOOSE, 1e-2) | {"rtol": 0.03}
    found = judged(tmp_path, PENDULUM + knock, integrator="rk5", max_step=1.0, **loose)
    entry = found.finding("energy-jump")
    assert "energy-jump" in found.codes
    assert entry["t"] > 0.5
    assert entry["value"] > entry["limit"] == 1e-3


@pytest.mark.provokes("momentum-balance")
def test_multipliers_that_do_not_converge(tmp_path):
    """A penalty far below the mass of the body: the reactions of the last iteration are wrong."""
    good = judged(tmp_path, PENDULUM, constraints="augmented-lagrangian")
    assert "momentum-balance" not in good.codes
    found = judged(tmp_path, PENDULUM, constraints="augmented-lagrangian", penalty=1e-3)
    assert "momentum-balance" in found.codes
    assert found.finding("momentum-balance")["value"] > 0.1


@pytest.mark.provokes("feedback-limits-steps")
def test_feedback_that_keeps_the_steps_short(tmp_path):
    found = judged(
        tmp_path, PENDULUM, constraints="baumgarte", integrator="gear", alpha=500.0, beta=500.0
    )
    assert found.codes == ["feedback-limits-steps"]
    assert found.finding("feedback-limits-steps")["level"] == "note"
    assert any(hint.startswith("feedback: ") for hint in found.summary["hints"])


@pytest.mark.provokes("stiffening-matters")
def test_a_linear_column_in_tension(tmp_path):
    found = judged(
        tmp_path, pushed([1.0, 0, 0], 0.2 * EULER), {"column": column().package}, **RADAU
    )
    assert "stiffening-matters" in found.codes
    entry = found.finding("stiffening-matters")
    assert entry["body"] == "column"
    assert entry["value"] == pytest.approx(0.2, abs=0.02)
    assert entry["limit"] == 0.05


def reaches(load, size):
    """Time at which the force of `pushed` reaches a load: smooth step, 6 x^5 - 15 x^4 + 10 x^3."""
    x = brentq(lambda x: size * x**3 * (10 + x * (6 * x - 15)) - load, 0.0, 1.0)
    return 0.5 * x


@pytest.mark.provokes("buckling-by-motion")
def test_a_run_ends_where_a_stiffened_column_buckles(tmp_path):
    found = judged(
        tmp_path,
        pushed([-1.0, 0, 0], 1.3 * EULER),
        {"column": column().package},
        geometric_stiffening=True,
        **RADAU,
    )
    assert found.codes == ["buckling-by-motion"]
    assert found.summary["status"] == "stopped"
    entry = found.finding("buckling-by-motion")
    assert entry["t"] == pytest.approx(reaches(EULER, 1.3 * EULER), abs=1e-3)
    assert found.summary["t_end"] == pytest.approx(entry["t"], abs=1e-9)


@pytest.mark.provokes("buckling-load")
def test_a_linear_column_is_told_of_its_buckling_load_at_the_instant(tmp_path, caplog):
    found = judged(
        tmp_path, pushed([-1.0, 0, 0], 1.3 * EULER), {"column": column().package}, **RADAU
    )
    assert {"buckling-load", "stiffening-matters"} == set(found.codes)
    assert found.summary["completed"]
    entry = found.finding("buckling-load")
    assert entry["level"] == "error"
    assert entry["t"] == pytest.approx(reaches(EULER, 1.3 * EULER), abs=1e-3)
    with caplog.at_level("INFO", "plymotion"):
        execute(read_run(tmp_path / "build/runs/base.json"), progress=True)
    assert "buckling load" in caplog.text


@pytest.mark.provokes("stiffened-mass-indefinite", "elastic-rotation-large")
@pytest.mark.parametrize(("reference", "times"), [(CLAMPED, 1.0), (CHORD, 4.0)])
def test_a_stiffened_beam_bends_too_far(tmp_path, reference, times):
    """A chord frame is no advice for a body that has one."""
    bent = [{"kind": "attachment", "at": at, "directions": ["rz"]} for at in ("root", "tip")]
    chord = [{"kind": "bending-xy", "count": 2}, {"kind": "torsion", "count": 1}, *bent]
    clamped = [{"kind": "bending-xy", "count": 3}, {"kind": "attachment", "at": "tip"}]
    modes = clamped if reference is CLAMPED else chord
    package = reduced(reference, modes, K=K, mass=MASS, length=LENGTH, elements=4).package
    load = pushed([0, 1.0, 0], times * BEND)
    found = judged(tmp_path, load, {"column": package}, geometric_stiffening=True, **RADAU)
    both = {"stiffened-mass-indefinite", "elastic-rotation-large"}
    assert both <= set(found.codes)
    for code in both:
        message = found.finding(code)["message"]
        assert "model the part as several bodies" in message
        assert ("chord" in message) == (reference is CLAMPED)


@pytest.mark.provokes("unstable-undisturbed")
@pytest.mark.parametrize(
    ("factor", "across", "expected"),
    [(0.98, 0.0, False), (1.1, 0.0, True), (1.1, 1e-3, False)],
)
def test_a_column_of_segments_needs_an_imperfection(factor, across, expected):
    """The advice clears it; the finding comes while the column would have grown a thousandfold."""
    table = cantilever(4, LENGTH)
    law = {"smooth_step": {"value": factor * EULER, "duration": 0.1}}
    load = {"kind": "force", "at": "beam.tip", "direction": [-1.0, across, 0.0], "law": law}
    table["solver"] |= {"output_step": 0.02, **RADAU}
    spec = run_of(table | {"forces": {"load": load}}, (K, MASS))
    run = integrated(prepare(spec.mechanism, spec.packages))
    found = {f.code: f for f in checked(run)}
    assert ("unstable-undisturbed" in found) == expected
    broken = dataclasses.replace(run.solution, status="failed")  # its last state is no position
    assert not list(undisturbed_findings(dataclasses.replace(run, solution=broken)))
    if expected:
        assert found["unstable-undisturbed"].body == "beam"
        assert found["unstable-undisturbed"].t < 0.5


@pytest.mark.provokes("stiffening-without-data")
def test_stiffening_of_a_package_without_data(tmp_path):
    package = column().package
    bare = tuple(dataclasses.replace(one, H_B=None, H_psi_B=None) for one in package.interfaces)
    plain = dataclasses.replace(package, second_order=None, interfaces=bare)
    found = judged(
        tmp_path,
        pushed([1.0, 0, 0], 1e-3),
        {"column": plain},
        t_end=0.01,
        geometric_stiffening=True,
        **RADAU,
    )
    assert "stiffening-without-data" in found.codes


def without_compliance(beam):
    """As a package of an earlier version."""
    return dataclasses.replace(beam.package, compliance=None)


@pytest.mark.provokes("modes-cut-early")
def test_two_vibration_modes_for_a_force_at_the_tip(tmp_path):
    """Without a compliance the series of modes is judged: 0.5 % are missing, the second has 2.5."""
    load = pushed([0, 1.0, 0], 0.2 * BEND)
    two = without_compliance(column(2, tip=False))
    found = judged(tmp_path, load, {"column": two}, **RADAU)
    assert "modes-cut-early" in found.codes
    assert 0.02 < found.finding("modes-cut-early")["value"] < 0.05
    for enough in (without_compliance(column(4, tip=False)), column(2, tip=False).package):
        four = judged(tmp_path, load, {"column": enough}, **RADAU)
        assert not {"modes-too-few", "modes-cut-early"} & set(four.codes)
        told = any(hint.startswith("not judged: ") for hint in four.summary["hints"])
        assert told == (enough.compliance is None)


@pytest.mark.provokes("modes-too-few")
def test_one_vibration_mode_for_a_moment_at_the_tip(tmp_path):
    load = pushed([0, 0, 1.0], 0.1).replace('"force"', '"torque"')
    found = judged(tmp_path, load, {"column": column(1, tip=False).package}, **RADAU)
    assert 0.35 < found.finding("modes-too-few")["value"] < 0.4


def test_modes_of_a_planned_run_are_judged_by_its_estimate(tmp_path):
    """`[fidelity]` chooses the modes: to take more of them is no advice there."""
    load = pushed([0, 1.0, 0], 0.2 * BEND)
    judged(tmp_path, load, {"column": without_compliance(column(2, tip=False))}, **RADAU)
    spec = read_run(tmp_path / "build/runs/judged.json")
    plain = integrated(prepare(spec.mechanism, spec.packages))
    assert len(list(mode_findings(plain))) == 1
    asked = spec.changed({"fidelity": {"accuracy": 0.1}}).mechanism
    assert not list(mode_findings(dataclasses.replace(plain, mechanism=asked)))


def test_static_shapes_where_the_force_acts_complete_two_vibration_modes(tmp_path):
    """The advice of the warning clears it; one that vibrates is not cleared by static shapes."""
    load = pushed([0, 1.0, 0], 0.2 * BEND)
    slow = judged(tmp_path, load, {"column": column(2).package}, **RADAU)
    assert not {"modes-too-few", "modes-cut-early"} & set(slow.codes)
    blow = "times = [0.0, 5e-4, 1e-3, 1.0], values = [0.0, 1.0, 0.0, 0.0]"
    law = f'law = {{ table = {{ {blow}, interpolation = "linear" }} }}'
    struck = load[: load.index("law = ")] + law + load.split(" } }")[-1]
    fast = judged(tmp_path, struck, {"column": column(2).package}, t_end=0.1, **RADAU)
    assert "bending-xy vibration modes carries" in fast.finding("modes-cut-early")["message"]
    assert fast.finding("modes-cut-early")["message"].endswith("take more modes")


def test_families_are_judged_one_by_one(tmp_path):
    """Two bending modes in one plane are too few; one in the other plane, not loaded, is enough."""
    modes = [{"kind": "bending-xy", "count": 2}, {"kind": "bending-xz", "count": 1}]
    both = without_compliance(reduced(CLAMPED, modes, K=K, mass=MASS, length=LENGTH, elements=4))
    found = judged(tmp_path, pushed([0, 1.0, 0], 0.2 * BEND), {"column": both}, **RADAU)
    message = found.finding("modes-cut-early")["message"]
    assert "the highest of 2 bending-xy vibration modes" in message
    assert 'modes of kind "attachment" at tip' in message

    labels = ("first", "second", "third")  # of a test: families are those of the motion
    measured = dataclasses.replace(both, mode_kinds=("experimental",) * 3, mode_labels=labels)
    found = judged(tmp_path, pushed([0, 1.0, 0], 0.2 * BEND), {"column": measured}, **RADAU)
    message = found.finding("modes-cut-early")["message"]
    assert "the highest of 2 y-direction vibration modes" in message
    assert message.endswith("take more modes")


WEIGHT = "gravity = [0.0, -9.81, 0.0]\n" + pushed([0, 1.0, 0], 1e-6)
SHOULDER = WEIGHT.replace('"fixed"', '"revolute"\ndrive = { polynomial = [0.0, 0.0, 100.0] }')


@pytest.mark.provokes("loads-begin-suddenly")
def test_weight_that_begins_suddenly(tmp_path):
    """A quarter: the largest deflection is twice the static one. In equilibrium it is none."""
    bodies = {"column": column().package}
    entry = judged(tmp_path, WEIGHT, bodies, **RADAU).finding("loads-begin-suddenly")
    assert entry["value"] == pytest.approx(0.25, rel=0.02)
    assert 'set solver.start = "equilibrium"' in entry["message"]
    still = judged(tmp_path, WEIGHT, bodies, start="equilibrium", **RADAU)
    assert "loads-begin-suddenly" not in still.codes


def test_a_drive_that_begins_with_an_acceleration(tmp_path):
    bodies = {"column": column().package}
    entry = judged(tmp_path, SHOULDER, bodies, t_end=0.1, start="equilibrium", **RADAU).finding(
        "loads-begin-suddenly"
    )
    assert "joints.foot: its law begins with an acceleration" in entry["message"]
    gentle = SHOULDER.replace(
        "polynomial = [0.0, 0.0, 100.0]", "smooth_step = { value = 1.0, duration = 0.1 }"
    )
    found = judged(tmp_path, gentle, bodies, t_end=0.1, start="equilibrium", **RADAU)
    assert "loads-begin-suddenly" not in found.codes


@pytest.mark.provokes("mesh-coarse-for-modes")
def test_warnings_of_a_package_come_with_the_run(tmp_path):
    beam = column(4, tip=False, elements=2)
    warnings = mode_warnings(beam.model, beam.modes)
    package = dataclasses.replace(beam.package, provenance={"warnings": warnings})
    found = judged(tmp_path, pushed([1.0, 0, 0], 1e-3), {"column": package}, t_end=0.01, **RADAU)
    assert "mesh-coarse-for-modes" in found.codes
    entry = found.finding("mesh-coarse-for-modes")
    assert entry["message"] == f"column: {warnings[0]['message']}"


def test_a_code_of_another_preprocessor_is_kept(tmp_path):
    own = {"warnings": [{"code": "house-rule-7", "message": "no mass of rivets"}]}
    package = dataclasses.replace(column().package, provenance=own)
    found = judged(tmp_path, pushed([1.0, 0, 0], 1e-3), {"column": package}, t_end=0.01, **RADAU)
    assert "house-rule-7" in found.codes


@pytest.mark.provokes("ply-failure")
def test_a_ply_fails(tmp_path):
    package = column().package
    (section,) = package.sections
    recovery = rectangle_recovery(
        0.004, 0.02, plies_of(("cfrp", 90.0)), {"cfrp": {**PLY, "strength": PLY_STRENGTH}}
    )
    line = straight_line(package.nodes_B[:, 0], section.K, section.M, np.eye(3))
    columns = np.moveaxis(package.shapes_B, 0, 2).reshape(6 * line.n_node, -1)
    form = package.invariants.mass_form
    strong = dataclasses.replace(
        package,
        sections=(dataclasses.replace(section, recovery=recovery),),
        recovery=mode_resultants(line, columns, np.diag(package.stiffness), form, (0,)),
    )
    found = judged(tmp_path, pushed([0, 1.0, 0], BEND), {"column": strong}, **RADAU)
    assert "ply-failure" in found.codes
    entry = found.finding("ply-failure")
    assert entry["value"] == found.summary["strength"]["column"]["ratio"] < entry["limit"] == 1.0


@pytest.mark.provokes("singular-passed")
def test_a_singular_position_is_passed(repository, tmp_path):
    found = judged_case(repository, "n-four-bar", "n-2", tmp_path, {"t_end": 1.0})
    assert found.codes == ["singular-passed"]
    assert found.summary["completed"]


@pytest.mark.provokes("singular-position")
def test_a_singular_position_ends_a_run_with_its_own_code(repository, tmp_path):
    solver = {"t_end": 1.0, "constraints": "index1"}
    found = judged_case(repository, "n-four-bar", "n-2", tmp_path, solver)
    assert found.summary["status"] == found.row.status == "stopped"
    assert found.codes[0] == found.row.code == "singular-position"
    assert found.finding("singular-position")["message"] == found.summary["message"]


@pytest.mark.provokes("singular-start")
def test_a_start_with_all_links_on_one_line(tmp_path):
    """Three links between two feet: two branches of motion leave from the start."""
    ends = {"a": (-0.5, 0, 0), "b": (0.5, 0, 0)}
    links = [("one", 0.5), ("two", 1.5), ("back", 1.5)]
    text = (
        "".join(rigid(name, 1.0, 0.1, ends, position=[x, 0.0, 0.0]) for name, x in links)
        + "[ground.o]\nposition = [0.0, 0.0, 0.0]\n[ground.p]\nposition = [1.0, 0.0, 0.0]\n"
    )
    hinges = [
        ("foot", "ground.o", "one.a"),
        ("left", "one.b", "two.a"),
        ("right", "two.b", "back.b"),
        ("far", "back.a", "ground.p"),
    ]
    for name, place, other in hinges:
        text += f'[joints.{name}]\nkind = "revolute"\nbetween = ["{place}", "{other}"]\n'
    found = judged(tmp_path, text, t_end=0.1)
    assert "singular-start" in found.codes


@pytest.mark.provokes("redundant-constraints")
def test_hinges_of_a_plane_mechanism_are_redundant(repository, tmp_path):
    found = judged_case(repository, "n-four-bar", "n-2-hinges", tmp_path, {"t_end": 0.1})
    assert found.codes == ["redundant-constraints"]
    assert found.finding("redundant-constraints")["value"] == 6.0


@pytest.mark.provokes("mechanism-locked")
def test_a_mechanism_without_freedom(repository, tmp_path):
    found = judged_case(repository, "misaligned-four-bar", "rigid", tmp_path, {"t_end": 0.1})
    assert "mechanism-locked" in found.codes


@pytest.mark.provokes("run-failed")
def test_a_force_that_no_step_can_follow(tmp_path):
    burst = """
[forces.burst]
kind = "force"
at = "bob.pin"
direction = [0.0, 1.0, 0.0]
law = { polynomial = [0.0, 0.0, 0.0, 1e300] }
"""
    found = judged(tmp_path, PENDULUM + burst)
    assert found.summary["status"] == found.row.status == "failed"
    assert "run-failed" in found.codes


@pytest.mark.provokes("spin-above-clamped-frequency")
def test_a_body_that_spins_too_fast(repository, tmp_path):
    found = judged_case(
        repository, "spin-up", "linear", tmp_path, {"t_end": 9.0, "on_invalid": "stop"}
    )
    assert found.codes[0] == found.row.code == "spin-above-clamped-frequency"
    assert found.finding("spin-above-clamped-frequency")["t"] == found.row.t_end
