"""Bodies without inertia of their own: what is added and taken away again changes nothing."""

import numpy as np
import pytest
from samples.constraint_runs import new_run, prepared
from samples.flexible_samples import Points, body_of, random_points
from samples.mechanism_samples import GRAVITY, GROUND, Sample, four_bars

import plymotion as pm
from plymotion.solver.dynamics.elements.added_inertia import missing_inertia, undetermined_body
from plymotion.solver.dynamics.elements.constraints.treatment import Treatment
from plymotion.solver.dynamics.evaluation.accelerations import (
    accelerations,
    assemble,
    by_blocks,
    dense_derivative_into,
    derivative_into,
)
from plymotion.solver.dynamics.model.model import new_workspace
from plymotion.solver.errors import InputError
from plymotion.solver.integrators.generic.drive import integrate
from plymotion.solver.mechanism.assembly import assemble_model
from plymotion.solver.mechanism.built_mechanism import Start
from plymotion.solver.mechanism.consistent import consistent_state
from plymotion.solver.mechanism.start import starting_state
from plymotion.solver.mechanism.tables import JointTable, MarkerTable, rigid_body

NONE, NOTHING = np.zeros((3, 0)), np.zeros((0, 0))


def _missing(mass, J, S0=(0.0, 0.0, 0.0)):
    return missing_inertia(mass, np.asarray(J, dtype=float), NONE, np.array(S0), NONE, NOTHING)


def test_directions_are_those_without_inertia():
    for size in (1.0, 1e-4):
        assert len(_missing(2.0, size * np.diag([0.1, 0.2, 0.2]))) == 0
    # a thin rod about itself, in axes of its own and in others
    np.testing.assert_allclose(
        np.abs(_missing(2.0, np.diag([0.0, 2.0, 2.0]))), [[0, 0, 0, 1, 0, 0]], atol=1e-9
    )
    e = np.array([1.0, 2.0, -1.0]) / np.sqrt(6.0)
    (found,) = _missing(2.0, np.eye(3) - np.outer(e, e))
    np.testing.assert_allclose(np.abs(found[3:] @ e), 1.0)
    # a mass point off the frame, and one at it
    off = np.array([1.0, 0.0, 0.0])
    assert len(_missing(2.0, 2.0 * (np.eye(3) - np.outer(off, off)), 2.0 * off)) == 3
    assert len(_missing(2.0, np.zeros((3, 3)))) == 3
    assert len(_missing(0.0, np.zeros((3, 3)))) == 6
    # a mode that moves the mass as the frame does has no mass of its own
    S = np.array([[1.0], [0.0], [0.0]])
    found = missing_inertia(1.0, np.eye(3), np.zeros((3, 1)), np.zeros(3), S, np.eye(1))
    np.testing.assert_allclose(np.abs(found), [[0, 0, 0, 0, 0, 0, 1]], atol=1e-9)


def _pendulums(n: int) -> Sample:
    """A flexible body, massless bodies in a row fixed to its end and to each other, a thin rod on
    the last, and a mass point on a massless stick at the end.
    """
    rng = np.random.default_rng(1)
    body = body_of(random_points(rng, 2))
    rod = rigid_body("rod", 1.5, np.zeros(3), np.diag([0.0, 0.4, 0.4]))
    point = rigid_body("point", 0.5, np.zeros(3), np.zeros((3, 3)))
    massless = [rigid_body("massless", 0.0, np.zeros(3), np.zeros((3, 3)))] * n
    bodies = [body, *massless, rod, point]
    still, moving = np.zeros((3, 2)), 0.1 * rng.normal(size=(3, 2))
    end, half = np.array([1.0, 0.2, -0.1]), np.array([0.5, 0.0, 0.0])
    markers = [
        MarkerTable(GROUND, np.zeros(3)),
        MarkerTable(0, np.zeros(3), np.eye(3), still, still),
    ]
    joints = [JointTable("foot", "revolute", 0, 1)]
    markers.append(MarkerTable(0, end, np.eye(3), moving, moving))
    for k in range(n):
        markers += [MarkerTable(1 + k, np.zeros(3)), MarkerTable(1 + k, np.zeros(3))]
        joints.append(JointTable(f"tie {k}", "fixed", len(markers) - 3, len(markers) - 2))
    markers += [MarkerTable(n + 1, -half), MarkerTable(n + 1, half), MarkerTable(n + 2, -half)]
    last = len(markers)
    joints.append(JointTable("rod", "revolute", last - 4, last - 3))
    joints.append(JointTable("point", "revolute", last - 2, last - 1))
    model = assemble_model(bodies, markers, joints, gravity_G=GRAVITY)
    scale = model.inertia_scale.copy()
    scale[scale == 0.0] = 1.0  # as VirtualBodies.scaled
    model = model._replace(inertia_scale=scale)
    positions, none = np.zeros(model.n_pos), np.zeros(model.n_vel)
    at = [np.zeros(3), *[end] * n, end + half, end + 3.0 * half]
    for i, r in enumerate(at):
        positions[model.pos_start[i] : model.pos_start[i] + 4] = (*r, 1.0)
    names = [j.name for j in joints]
    return Sample(model, Start(positions, none, none.astype(bool)), names, last - 1)


@pytest.mark.parametrize("n", [1, 3])
def test_accelerations_and_multipliers_are_those_of_dense_linear_algebra(n):
    model, y = prepared(_pendulums(n), Treatment("index1"))
    assert by_blocks(model)
    assert model.added_inertia.size == 6 * n + 1 + 3
    y[model.n_pos : -1] += 0.3  # whatever the constraints say
    work, found, expected = new_workspace(model), np.empty(y.size), np.empty(y.size)
    derivative_into(model, work, 0.2, y, found)
    dense_derivative_into(model, new_workspace(model), 0.2, y, expected)
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-9 * np.abs(expected).max())
    multipliers = accelerations(model, assemble(model, 0.2, y), y)[1]
    size = np.abs(multipliers).max()
    np.testing.assert_allclose(work.multipliers, multipliers, rtol=0.0, atol=1e-9 * size)


def test_a_mode_that_moves_as_the_frame_does():
    """A mass point on a mode, held at a marker that the mode moves: the frame swings, not it."""
    phi, psi = np.zeros((1, 3, 1)), np.zeros((1, 3, 1))
    phi[0, 0, 0] = 1.0
    body = body_of(Points(np.ones(1), np.zeros((1, 3)), phi, psi, np.eye(3)[None]), 25.0)
    at = MarkerTable(0, np.array([0.1, 0.0, 0.0]), np.eye(3), -0.5 * phi[0], psi[0])
    markers = [MarkerTable(GROUND, np.zeros(3)), at]
    model = assemble_model([body], markers, [JointTable("weld", "fixed", 0, 1)])
    assert model.added_inertia.size == 1
    y = np.zeros(model.n_pos + model.n_vel + 1)
    y[3], y[7] = 1.0, 0.01
    found, expected = np.empty(y.size), np.empty(y.size)
    derivative_into(model, new_workspace(model), 0.0, y, found)
    dense_derivative_into(model, new_workspace(model), 0.0, y, expected)
    np.testing.assert_allclose(found, expected, atol=1e-12)
    assert abs(found[model.n_pos + 6]) > 0.01


@pytest.mark.parametrize("added", [1e-3, 1e3])
def test_what_is_added_is_of_no_effect(added):
    model, y = prepared(_pendulums(2), Treatment("index1"))
    found = []
    for one in (model, model._replace(added_inertia=added * model.added_inertia)):
        out = np.empty(y.size)
        derivative_into(one, new_workspace(one), 0.0, y, out)
        found.append(out)
    np.testing.assert_allclose(*found, rtol=0.0, atol=1e-9 * np.abs(found[0]).max())


@pytest.mark.parametrize(
    ("name", "treatment"),
    [("radau", "projection"), ("generalized-alpha", "ggl"), ("generalized-alpha", "index3")],
)
def test_implicit_runs_against_rk8(name, treatment):
    sample = _pendulums(2)
    ends = []
    for who, how, rtol in (("rk8", "projection", 1e-9), (name, treatment, 1e-6)):
        model, y0 = prepared(sample, Treatment(how))
        made = new_run(model, y0, Treatment(how), who, 0.3, rtol=rtol, atol=0.1 * rtol)
        done = integrate(made, [0.3])
        assert done.status == "finished", done.message
        ends.append(done.y[-1][: model.n_pos])
    np.testing.assert_allclose(ends[1], ends[0], atol=1e-5 if name == "radau" else 2e-3)


def test_thin_rods_in_a_loop_with_surplus_rows():
    """Four-bar of rods without inertia about themselves: the same motion as with some."""
    ends = []
    for core in (0.0, 1e-2):
        model, y0 = prepared(four_bars(1, core=core), Treatment())
        assert (model.added_inertia.size > 0) == (core == 0.0)
        made = new_run(model, y0, Treatment(), "radau", 0.4, rtol=1e-6, atol=1e-8)
        done = integrate(made, [0.4])
        assert done.status == "finished", done.message
        ends.append(done.y[-1][: model.n_pos])
    np.testing.assert_allclose(*ends, atol=1e-6)


def test_a_body_that_nothing_holds_is_named():
    """A rod on a ball joint may turn about itself without inertia: no acceleration follows."""
    rod = rigid_body("rod", 1.5, np.zeros(3), np.diag([0.0, 0.4, 0.4]))
    half = np.array([0.5, 0.0, 0.0])
    markers = [MarkerTable(GROUND, -half), MarkerTable(0, -half)]
    none = np.zeros(6)
    start = Start(np.array([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]), none, none.astype(bool))
    model = assemble_model([rod], markers, [JointTable("one", "revolute", 0, 1)])
    starting_state(model, start, "given", ["one"], ["rod"])
    model = assemble_model([rod], markers, [JointTable("one", "spherical", 0, 1)])
    with pytest.raises(InputError, match=r"bodies\.rod: .*axis \(1, 0, 0\).*inertia.*universal"):
        starting_state(model, start, "given", ["one"], ["rod"])
    e = assemble(model, 0.0, consistent_state(model, start, ["one"]))
    found = undetermined_body(e.M, e.Phi_q, model.inertia_scale, model.vel_start)
    assert found is not None
    np.testing.assert_allclose(np.abs(found[1]), [0, 0, 0, 1, 0, 0], atol=1e-6)


def _crossed(**link: object) -> pm.Case:
    """A weight under a universal joint, or under two hinges with a link between them."""
    case = pm.Case("cross", gravity=[0, 0, -9.81])
    case.point("o", (0, 0, 0))
    places = {"o": (0, 0, 0), "end": (0, 0, -0.5)}
    weight = case.rigid(
        "weight",
        mass=2.0,
        centre=(0, 0, -0.3),
        interfaces=places,
        inertia=np.diag([0.02, 0.03, 0.04]).tolist(),
    )
    weight.angular_velocity = [3.0, 2.0, 0.0]
    if link:
        case.rigid("link", mass=0.0, inertia=np.zeros((3, 3)).tolist(), interfaces={"o": (0, 0, 0)})
        case.table["bodies"]["link"] |= link
        case.revolute("one", "ground.o", "link.o", axis="x")
        case.revolute("two", "link.o", "weight.o", axis="y")
    else:
        case.universal("cross", "ground.o", "weight.o", axis="x", axis_2="y")
    for axis in "xyz":
        case.signals[axis] = {"kind": "position", "at": "weight.end", "component": axis}
    case.table["solver"] = {"t_end": 0.5, "output_step": 0.05, "rtol": 1e-8}
    case.table["runs"] = {"base": {}}
    return case


def test_two_hinges_and_a_link_without_mass_are_a_universal_joint(tmp_path):
    """The same motion with all integrators; with parallel hinges the link is named."""
    ends = []
    for name, link in (("radau", {}), ("radau", {"mass": 0.0}), ("rk8", {"mass": 0.0})):
        case = _crossed(**link)
        case.solver.integrator = name
        found = pm.run(case, out=tmp_path / f"{len(ends)}").signals
        ends.append([found[axis].values for axis in "xyz"])
    assert np.ptp(ends[0][0]) > 0.15
    np.testing.assert_allclose(ends[1], ends[0], atol=3e-8)
    np.testing.assert_allclose(ends[2], ends[0], atol=3e-8)
    case = _crossed(mass=0.0)
    case.joints.two.axis = [1.0, 0.0, 0.0]
    case.bodies.weight.angular_velocity = [0.0, 0.0, 0.0]
    with pytest.raises(InputError, match=r"bodies\.link: it can turn about its axis \(1, 0, "):
        pm.run(case, out=tmp_path / "parallel")
    with pytest.raises(InputError, match=r"bodies\.link\.inertia = .*positive definite"):
        pm.run(_crossed(mass=1.0), out=tmp_path / "point")
