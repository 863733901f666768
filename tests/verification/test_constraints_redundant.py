"""Redundant constraints: counted, named, without effect on the motion; contradictions refused."""

from itertools import pairwise

import numpy as np
import pytest
from samples.constraint_runs import joint_reactions, prepared, run
from samples.mechanism_samples import GROUND, Rods, bricard, chain, four_bars

from plymotion.solver.dynamics.elements.constraints.treatment import TREATMENTS, Treatment
from plymotion.solver.dynamics.evaluation.accelerations import accelerations, assemble
from plymotion.solver.errors import InputError
from plymotion.solver.math import laws
from plymotion.solver.mechanism.assembly import assemble_model
from plymotion.solver.mechanism.consistent import consistent_state, redundancy
from plymotion.solver.mechanism.tables import JointTable, MarkerTable, rigid_body


def _found(sample):
    y = consistent_state(sample.model, sample.start, sample.names)
    return redundancy(sample.model, y, sample.names), y


@pytest.mark.parametrize(
    ("sample", "count"),
    [(bricard, 1), (lambda: four_bars(1), 3), (lambda: four_bars(4), 12), (lambda: chain(4), 0)],
)
def test_count(sample, count):
    found, _ = _found(sample())
    assert (found.count, found.singular_start) == (count, False)


def test_message_names_the_joints_of_the_loop_only():
    rods = Rods()
    frame = [rods.rod((0, 0, 0), (0, 1, 0)), rods.rod((1, 0, 0), (1, 1, 0))]
    top = rods.rod((0, 1, 0), (1, 1, 0))
    tail = rods.rod((1, 1, 0), (2, 1, 0))
    for name, body, at in (("a", frame[0], (0, 0, 0)), ("b", frame[1], (1, 0, 0))):
        rods.joint(name, "revolute", GROUND, body, at)
    for name, body, at in (("c", frame[0], (0, 1, 0)), ("d", frame[1], (1, 1, 0))):
        rods.joint(name, "revolute", body, top, at)
    rods.joint("tail", "revolute", frame[1], tail, (1, 1, 0))
    found, _ = _found(rods.sample((tail, (2, 1, 0))))
    assert found.count == 3
    assert found.joints == ["a", "b", "c", "d"]
    assert (
        "3 constraint equations follow from the others, among a, b, c, d"
        in found.findings()[0].text
    )


def test_units_do_not_change_the_count():
    """The same loop in a thousandth of the size and a millionth of the mass."""
    counts = []
    for size in (1.0, 1e-3):
        rods = Rods(side=0.1 * size)
        points = [(0, 0, 0), (0, size, 0), (size, size, 0), (size, 0, 0)]
        links = [GROUND]
        for a, b in pairwise(points):
            links.append(rods.rod(a, b, mass=size**2))
        for i, point in enumerate(points):
            rods.joint(f"{i}", "revolute", links[i], links[(i + 1) % 4], point)
        counts.append(_found(rods.sample((links[1], (0, 0, 0))))[0].count)
    assert counts == [3, 3]


def test_a_start_in_a_singular_position_is_told_from_redundancy():
    """All links on one line at the start: four equations less there, three less in general."""
    rods = Rods()
    one, two = rods.rod((0, 0, 0), (1, 0, 0)), rods.rod((1, 0, 0), (2, 0, 0))
    back = rods.rod((2, 0, 0), (1, 0, 0))
    links = [GROUND, one, two, back, GROUND]
    for i, point in enumerate([(0, 0, 0), (1, 0, 0), (2, 0, 0), (1, 0, 0)]):
        rods.joint(f"{i}", "revolute", links[i], links[i + 1], point)
    found, _ = _found(rods.sample((one, (1, 0, 0))))
    assert (found.count, found.singular_start) == (3, True)


@pytest.mark.parametrize("name", TREATMENTS)
def test_every_treatment_gives_the_motion_of_independent_joints(name):
    """A parallelogram of hinges, and the same with the surplus rows left out."""
    surplus, y = prepared(four_bars(1), Treatment(name))
    rods = Rods()
    left, right = rods.rod((0, 0, 0), (0, 1, 0)), rods.rod((1, 0, 0), (1, 1, 0))
    top = rods.rod((0, 1, 0), (1, 1, 0))
    rods.joint("foot 0", "revolute", GROUND, left, (0, 0, 0))
    rods.joint("foot 1", "revolute", GROUND, right, (1, 0, 0))
    rods.joint("left 0", "revolute", left, top, (0, 1, 0))
    rods.joint("right 0", "point_on_line", right, top, (1, 1, 0))
    sample = rods.sample((left, (0, 1, 0)), {left: (0, 0, -1.0)}, gravity_G=(0.0, -9.81, 0.0))
    just, same = prepared(sample, Treatment(name))
    assert (surplus.redundant, just.redundant) == (3, 0)
    np.testing.assert_allclose(y, same, atol=1e-12)
    a, _ = accelerations(surplus, assemble(surplus, 0.0, y), y)
    b, _ = accelerations(just, assemble(just, 0.0, y), y)
    np.testing.assert_allclose(a, b, atol=1e-9)


def test_forces_are_shared_evenly_by_symmetric_joints():
    """A bar on two feet that each could carry it alone: half of its weight on each."""
    body = rigid_body("bar", 2.0, np.zeros(3), np.eye(3))
    markers, joints = [], []
    for i, x in enumerate((-1.0, 1.0)):
        at = np.array([x, 0.0, 0.0])
        markers += [MarkerTable(GROUND, at), MarkerTable(0, at)]
        joints.append(JointTable(f"foot {i}", "fixed", 2 * i, 2 * i + 1))
    model = assemble_model([body], markers, joints, gravity_G=(0.0, -9.81, 0.0))
    y = np.zeros(14)
    y[3] = 1.0
    found = redundancy(model, y, ["foot 0", "foot 1"])
    assert (found.count, found.joints) == (6, ["foot 0", "foot 1"])
    for penalty in (0.0, 1e7):
        ready = model._replace(
            redundant=6, penalty=penalty, multiplier_tolerance=1e-12, multiplier_iterations=20
        )
        _, multipliers = accelerations(ready, assemble(ready, 0.0, y), y)
        forces = joint_reactions(ready, np.zeros(1), y[None], multipliers[None])[0]
        np.testing.assert_allclose(forces[:, 1, 1], [9.81, 9.81], atol=1e-9)


def test_drives_that_contradict_each_other_are_refused():
    """Two drives on one hinge with the same angle and speed at the start, not later."""
    body = rigid_body("bar", 1.0, np.array([0.5, 0.0, 0.0]), 0.1 * np.eye(3))
    markers = [MarkerTable(GROUND, np.zeros(3)), MarkerTable(0, np.zeros(3))]
    joints = [
        JointTable("hinge", "revolute", 0, 1),
        JointTable("slow drive", "rotation_drive", 0, 1, laws.polynomial([0.0, 1.0])),
        JointTable("fast drive", "rotation_drive", 0, 1, laws.polynomial([0.0, 1.0, 0.5])),
    ]
    model = assemble_model([body], markers, joints)
    y = np.zeros(14)
    y[3], y[12] = 1.0, 1.0
    with pytest.raises(InputError, match="contradict each other in their accelerations") as error:
        redundancy(model, y, [j.name for j in joints])
    assert "fast drive" in str(error.value)


@pytest.mark.parametrize(
    ("name", "integrator", "rtol"),
    [
        ("index1", "rk8", 1e-8),
        ("baumgarte", "rk8", 1e-8),
        ("baumgarte", "gear", 1e-7),
        ("augmented-lagrangian", "rk8", 1e-7),
        ("projection", "rk8", 1e-7),
        ("projection", "gear", 1e-7),
    ],
)
def test_bricard_for_ten_seconds(name, integrator, rtol, published):
    reference = published("a04_bricard")
    points = reference["positions"]
    sample = bricard()
    done = run(sample, name, [0.0] + [p["t"] for p in points], integrator, rtol)
    assert done.solution.status == "finished", done.solution.message
    expected = np.array([p["x"] for p in points])
    error = np.linalg.norm(sample.place(done.solution.y)[1:] - expected, axis=1)
    assert error.max() < reference["tolerance"]
    assert np.ptp(done.energy) < 1e-3
    assert not done.monitor.passes


@pytest.mark.parametrize("name", ["ggl", "index3"])
def test_bricard_by_generalized_alpha(name, published):
    """Second order: 1e-4 m needs small steps, here for the first second."""
    first = published("a04_bricard")["positions"][0]
    sample = bricard()
    done = run(sample, name, [0.0, first["t"]], rtol=2e-6)
    place = sample.place(done.solution.y)[-1]
    assert np.linalg.norm(place - first["x"]) < 1e-4
