"""Reactions: by hand at rest, and against the change of momentum along the motion."""

import numpy as np
import pytest
from samples.constraint_runs import joint_reactions, prepared, run
from samples.flexible_samples import body_of, random_marker, random_points, random_state
from samples.mechanism_samples import bricard, chain, four_bars, pendulum

from plymotion.solver.dynamics.analysis.recovery import (
    acting,
    momentum_balance,
    momentum_rates,
)
from plymotion.solver.dynamics.elements.constraints.treatment import TREATMENTS, Treatment
from plymotion.solver.dynamics.evaluation.accelerations import accelerations, assemble
from plymotion.solver.dynamics.evaluation.series import along_solution
from plymotion.solver.math import laws
from plymotion.solver.mechanism.assembly import assemble_model
from plymotion.solver.mechanism.tables import ForceTable, JointTable, MarkerTable, rigid_body

KINDS = ("revolute", "fixed", "spherical", "universal", "cylindrical", "prismatic", "planar")


def test_clamped_bar_by_hand():
    """A bar of 2 kg, its centre 0.5 m from the wall: force and moment of the clamp."""
    body = rigid_body("bar", 2.0, np.array([0.5, 0.0, 0.0]), np.eye(3))
    markers = [MarkerTable(-1, np.zeros(3)), MarkerTable(0, np.zeros(3))]
    joints = [JointTable("clamp", "fixed", 0, 1)]
    model = assemble_model([body], markers, joints, gravity_G=(0.0, -9.81, 0.0))
    y = np.zeros(14)
    y[3] = 1.0
    _, multipliers = accelerations(model, assemble(model, 0.0, y), y)
    wall, bar = joint_reactions(model, np.zeros(1), y[None], multipliers[None])[0, 0]
    np.testing.assert_allclose(bar, [0, 19.62, 0, 0, 0, 9.81], atol=1e-12)
    np.testing.assert_allclose(wall, -bar, atol=1e-12)


def test_swinging_pendulum_by_hand():
    """At the bottom the rod carries weight and centripetal force: 3 m g from the horizontal."""
    sample = pendulum()
    model, _ = prepared(sample, Treatment("baumgarte"))
    y = np.zeros(14)
    y[1], y[3], y[7] = -1.0, 1.0, np.sqrt(2 * 9.81)
    _, multipliers = accelerations(model, assemble(model, 0.0, y), y)
    rod = joint_reactions(model, np.zeros(1), y[None], multipliers[None])[0, 0]
    np.testing.assert_allclose(rod[1], [0, 3 * 9.81, 0, 0, 0, 0], atol=1e-12)


@pytest.mark.parametrize("name", TREATMENTS)
@pytest.mark.parametrize("make", [bricard, lambda: four_bars(2), lambda: chain(3, "spherical")])
def test_momentum_balance_along_the_motion(make, name):
    """Loads and reactions against differences of momentum, body by body, at output times."""
    times = np.linspace(0.0, 0.5, 6)
    done = run(make(), name, times, rtol=1e-5)
    balance = momentum_balance(done.model, done.solution.t, done.solution.y)
    assert balance.linear < 1e-8
    assert balance.angular < 1e-8


@pytest.mark.parametrize("kind", KINDS)
def test_momentum_balance_of_flexible_bodies_with_everything_on_them(kind):
    """Joints of every kind, springs, loads and point masses, at random states."""
    rng = np.random.default_rng(12)
    bodies = [body_of(random_points(rng, m)) for m in (3, 2)]
    markers = [
        MarkerTable(-1, rng.normal(size=3)),
        random_marker(rng, 0, 3),
        random_marker(rng, 0, 3),
        random_marker(rng, 1, 2),
    ]
    law = laws.polynomial([0.4, 1.0])
    joints = [JointTable("a", "revolute", 0, 1), JointTable("b", kind, 2, 3)]
    forces = [
        ForceTable("spring", "spring", 0, 3, (40.0, 2.0, 0.7), law),
        ForceTable("bushing", "bushing", 1, 3, (40.0, 30.0, 20.0, 3.0, 2.0, 1.0, *[0.1] * 6)),
        ForceTable("hinge spring", "rotary_spring", 2, 3, (3.0, 0.4, 0.2), law),
        ForceTable("force", "force", 0, 3, (1.0, -2.0, 0.5), law),
        ForceTable("torque", "torque", 3, 2, (1.0, -2.0, 0.5), law),
    ]
    model = assemble_model(
        bodies, markers, joints, [(3, 0.7), (2, 0.3)], (0.3, -9.81, 0.2), forces=forces
    )
    y = np.array([random_state(rng, model, 0.1) for _ in range(4)])
    balance = momentum_balance(model, np.linspace(0.1, 1.0, 4), y)
    assert balance.linear < 1e-8
    assert balance.angular < 1e-8


def test_a_wrong_multiplier_is_noticed():
    sample = chain(2)
    model, y = prepared(sample, Treatment("baumgarte"))
    t, states = np.zeros(1), y[None]
    along, multipliers = along_solution(model, t, states)
    rates = momentum_rates(model, states, along)
    right, _ = acting(model, t, states, multipliers)
    wrong, _ = acting(model, t, states, multipliers * (1 + 1e-6))
    assert np.abs(rates - right).max() < 1e-10
    assert np.abs(rates - wrong).max() > 1e-7


@pytest.mark.parametrize("speed", [1e-4, 1.0, 1e4])
def test_momentum_balance_in_free_flight_is_that_of_no_load(speed):
    """A body that spins freely has no load to compare with: round-off must not look like one."""
    body = rigid_body("body", 2.0, np.zeros(3), np.diag([1.0, 2.0, 3.0]))
    model = assemble_model([body], [], [], [])
    y = np.concatenate([np.zeros(3), [1.0, 0.0, 0.0, 0.0], speed * np.arange(1.0, 7.0), [0.0]])
    balance = momentum_balance(model, np.zeros(1), y[None])
    assert balance.linear < 1e-6
    assert balance.angular < 1e-6


def test_momentum_balance_of_a_body_that_hangs_at_rest():
    """Its forces have no moment about the hinge but round-off, which has no size of its own."""
    centre = np.array([0.3, 0.4, 0.1])
    body = rigid_body("bar", 2.0, centre, np.eye(3))
    markers = [MarkerTable(-1, np.zeros(3)), MarkerTable(0, np.zeros(3))]
    joints = [JointTable("hinge", "spherical", 0, 1)]
    model = assemble_model([body], markers, joints, gravity_G=(0.0, -9.81, 0.0))
    y = np.zeros(14)
    half = centre / np.linalg.norm(centre) - [0.0, 1.0, 0.0]  # turns the centre to -y
    y[3:7] = [0.0, *half] / np.linalg.norm(half)
    balance = momentum_balance(model, np.zeros(1), y[None])
    assert balance.angular < 1e-8
