"""Springs, bushings and dampers far stiffer than the motion: steps follow the motion alone.

The reference is the same mechanism with a joint in place of the element, or with none where the
element has nothing to do; rk8 where the element is soft.
"""

import numpy as np
import pytest
from samples.constraint_runs import new_run, prepared
from samples.flexible_samples import body_of, random_points
from samples.mechanism_samples import GRAVITY, GROUND, Sample

from plymotion.solver.dynamics.elements.constraints.treatment import Treatment
from plymotion.solver.dynamics.elements.forces.contract import FORCE, N_ELEMENT_ROW, STIFFNESS
from plymotion.solver.dynamics.elements.forces.table import ELEMENTS, MOST_ROWS, element_rows
from plymotion.solver.dynamics.evaluation.accelerations import assemble, energies
from plymotion.solver.dynamics.evaluation.evaluation import evaluate
from plymotion.solver.dynamics.model.coordinates import moved
from plymotion.solver.dynamics.model.model import new_workspace
from plymotion.solver.integrators.generic.drive import integrate
from plymotion.solver.mechanism.assembly import assemble_model
from plymotion.solver.mechanism.built_mechanism import Start
from plymotion.solver.mechanism.tables import ForceTable, JointTable, MarkerTable

BOTH = pytest.mark.parametrize(
    ("name", "treatment"),
    [("radau", "projection"), ("generalized-alpha", "ggl"), ("generalized-alpha", "index3")],
)
OWN = 400.0  # stiffness of the bodies' first modes, of unit modal mass nearly
RATIOS = (1e3, 1e6, 1e9)


def _links(tie: str, k: float = 0.0, c: float = 0.0, flexible: bool = True) -> Sample:
    """Two flexible links in a plane, elbow bent, the shoulder a hinge; `tie` is the elbow.

    "fixed", "hinge" and "rod" are joints; "bushing", "rotary", "spring" and "damper" have an
    element that is as stiff as `k` and `c` say in their place, at rest at the start. Markers: 0
    ground, 1 shoulder, 2 and 3 elbow, 4 the end of the second link, 5 on the first.
    """
    rng = np.random.default_rng(3)
    m = 2 if flexible else 0
    bodies = [body_of(random_points(rng, m), OWN) for _ in range(2)]
    ends = (np.array([1.0, 0.0, 0.0]), np.array([0.3, 0.9, 0.0]))
    shapes = 0.1 * rng.normal(size=(2, 3, 2))[:, :, :m]

    def marker(body: int, x, moving: bool = False) -> MarkerTable:
        phi, psi = shapes if moving else np.zeros((2, 3, m))
        return MarkerTable(body, np.array(x, dtype=float), np.eye(3), phi, psi)

    markers = [MarkerTable(GROUND, np.zeros(3)), marker(0, np.zeros(3)), marker(0, ends[0], True)]
    markers += [marker(1, np.zeros(3)), marker(1, ends[1], True), marker(0, [0.2, 0.1, 0.0], True)]
    joints, forces = [JointTable("shoulder", "revolute", 0, 1)], []
    length = float(np.linalg.norm(ends[0] + ends[1] - markers[5].x))
    if tie != "bushing":
        joints.append(JointTable("elbow", "fixed" if tie == "fixed" else "revolute", 2, 3))
    if tie == "rod":
        joints.append(JointTable("rod", "distance", 5, 4, parameters=(length,)))
    elif tie == "spring":
        forces.append(ForceTable("spring", "spring", 5, 4, (k, c, length)))
    elif tie == "rotary":
        forces.append(ForceTable("spring", "rotary_spring", 2, 3, (k, c, 0.0)))
    elif tie == "damper":
        forces.append(ForceTable("damper", "rotary_spring", 2, 3, (0.0, c, 0.0)))
    elif tie == "bushing":
        forces.append(ForceTable("bushing", "bushing", 2, 3, (k,) * 6 + (c,) * 6))
    model = assemble_model(bodies, markers, joints, gravity_G=GRAVITY, forces=forces)
    positions, none = np.zeros(model.n_pos), np.zeros(model.n_vel)
    second = int(model.pos_start[1])
    positions[3] = positions[second + 3] = 1.0
    positions[second : second + 3] = ends[0]
    return Sample(model, Start(positions, none, none.astype(bool)), [j.name for j in joints], 4)


def _end(sample, name, treatment, t_end, **options):
    """Model and solution at the end."""
    model, y0 = prepared(sample, Treatment(treatment))
    solution = integrate(new_run(model, y0, Treatment(treatment), name, t_end, **options), [t_end])
    assert solution.status == "finished", solution.message
    return model, solution


def _coarse(sample):
    """Vibrations under 1e-4 m and 0.1 m/s do not count."""
    model = sample.model
    atol = np.full(model.n_pos + model.n_vel + 1, 0.1)
    atol[: model.n_pos] = 1e-4
    return {"rtol": 1e-4, "atol": atol}


# element, the joint that it becomes, damping over stiffness or the damping itself [s]
TIES = {
    "spring": ("spring", "rod", 1e-3),
    "spring, undamped": ("spring", "rod", 0.0),
    "rotary": ("rotary", "fixed", 1e-3),
    "bushing": ("bushing", "fixed", 1e-3),
    "bushing, undamped": ("bushing", "fixed", 0.0),
    "damper": ("damper", "fixed", 1.0),
}


@BOTH
@pytest.mark.parametrize("tie", TIES)
def test_a_stiff_element_is_a_joint(tie, name, treatment):
    """From a thousand to 1e9 times as stiff as the bodies: as many steps as the joint takes."""
    element, joint, lag = TIES[tie]
    options = _coarse(_links(joint))
    model, exact = _end(_links(joint), name, treatment, 0.4, **options)
    shift = []
    for ratio in RATIOS:
        k = ratio * OWN
        sample = _links(element, k, lag * k)
        found = _end(sample, name, treatment, 0.4, **_coarse(sample))[1]
        counts = found.counters
        tried = exact.counters.steps + exact.counters.rejected
        assert counts.steps + counts.rejected <= 2 * tried + 10, ratio
        shift.append(np.abs(found.y[-1] - exact.y[-1])[: model.n_pos].max())
    assert max(shift[1:]) < 1e-2, shift


def test_a_mechanism_of_elements_alone():
    """A chain of bodies on bushings, no joint: the order of rows has nothing to hold on to."""
    rng = np.random.default_rng(2)
    n = 4
    bodies = [body_of(random_points(rng, 0)) for _ in range(n)]
    markers, forces = [MarkerTable(GROUND, np.zeros(3))], []
    for i in range(n):
        markers += [MarkerTable(i, np.zeros(3)), MarkerTable(i, np.array([1.0, 0.0, 0.0]))]
    for i in (2, 0, 3, 1):  # in any order
        k = (1e9, 1e9, 1e9, 1e9, 1e9, 50.0, *(1e6,) * 5, 1.0)
        forces.append(ForceTable(f"{i}", "bushing", 2 * i, 2 * i + 1, k))
    model = assemble_model(bodies, markers, [], gravity_G=GRAVITY, forces=forces)
    positions, none = np.zeros(model.n_pos), np.zeros(model.n_vel)
    for i in range(n):
        positions[7 * i], positions[7 * i + 3] = i, 1.0
    sample = Sample(model, Start(positions, none, none.astype(bool)), [], 1)
    ends = {}
    for name, treatment in (("radau", "projection"), ("generalized-alpha", "ggl")):
        _, found = _end(sample, name, treatment, 0.5, **_coarse(sample))
        assert found.counters.steps + found.counters.rejected < 150
        ends[name] = found.y[-1][: model.n_pos]
    hinges = [JointTable(e.name, "revolute", e.marker_1, e.marker_2) for e in forces]
    soft = [
        ForceTable(e.name, "rotary_spring", e.marker_1, e.marker_2, (50.0, 1.0, 0.0))
        for e in forces
    ]
    model = assemble_model(bodies, markers, hinges, gravity_G=GRAVITY, forces=soft)
    jointed = Sample(model, sample.start, [j.name for j in hinges], 1)
    _, exact = _end(jointed, "rk8", "projection", 0.5, rtol=1e-8, atol=1e-10)
    assert np.abs(ends["radau"] - exact.y[-1][: model.n_pos]).max() < 1e-3
    assert np.abs(ends["generalized-alpha"] - exact.y[-1][: model.n_pos]).max() < 1e-2


@pytest.mark.parametrize("k", [1e6, 1e8, 1e10])
def test_a_spring_of_no_length_ties_points_together(k):
    """It holds across as along: a pendulum on it is one on a ball joint, and stays on it."""
    rng = np.random.default_rng(4)
    body = body_of(random_points(rng, 0))
    markers = [MarkerTable(GROUND, np.zeros(3)), MarkerTable(0, np.array([0.7, 0.1, 0.0]))]
    ties = {
        "spring": ([], [ForceTable("tie", "spring", 0, 1, (k, 0.0, 0.0))]),
        "joint": ([JointTable("ball", "spherical", 0, 1)], []),
    }
    ends, steps = {}, {}
    for tie, (joints, forces) in ties.items():
        model = assemble_model([body], markers, joints, gravity_G=GRAVITY, forces=forces)
        positions, none = np.zeros(model.n_pos), np.zeros(model.n_vel)
        positions[:3], positions[3] = -markers[1].x, 1.0
        names = [j.name for j in joints]
        sample = Sample(model, Start(positions, none, none.astype(bool)), names, 1)
        _, found = _end(sample, "radau", "projection", 1.0, **_coarse(sample))
        ends[tie], steps[tie] = found.y[-1][:7], found.counters.steps + found.counters.rejected
    assert steps["spring"] <= 2 * steps["joint"] + 10
    assert np.abs(ends["spring"] - ends["joint"]).max() < 2e3 / k + 1e-3


def test_a_preloaded_spring_beside_a_rod():
    """1e6 N that a rod takes, 1e4 times the weight: the swing of the pendulum is not affected.

    Newton's matrix knows neither how the tension of the spring turns nor how that of the rod does.
    """
    rng = np.random.default_rng(5)
    body = body_of(random_points(rng, 0))
    markers = [MarkerTable(GROUND, np.zeros(3)), MarkerTable(0, np.array([0.7, 0.1, 0.0]))]
    joints = [JointTable("rod", "distance", 0, 1, parameters=(1.0,))]
    ends, steps = [], []
    for forces in ([], [ForceTable("s", "spring", 0, 1, (1e7, 0.0, 0.9))]):
        model = assemble_model([body], markers, joints, gravity_G=GRAVITY, forces=forces)
        positions, none = np.zeros(model.n_pos), np.zeros(model.n_vel)
        positions[0], positions[3] = 1.0, 1.0
        positions[:3] -= markers[1].x
        sample = Sample(model, Start(positions, none, none.astype(bool)), ["rod"], 1)
        _, found = _end(sample, "radau", "projection", 0.5, **_coarse(sample))
        ends.append(found.y[-1][:7])
        steps.append(found.counters.steps + found.counters.rejected)
    assert steps[1] <= 10 * steps[0]
    np.testing.assert_allclose(ends[1], ends[0], atol=1e-3)


@BOTH
@pytest.mark.parametrize("tie", ["spring", "bushing", "rotary"])
def test_soft_elements_against_rk8(tie, name, treatment):
    """Positions and the work of dampers, by steps that resolve the elements."""
    sample = _links(tie, 300.0, 20.0)
    _, exact = _end(sample, "rk8", "projection", 0.3, rtol=1e-10, atol=1e-12)
    fine = {"rtol": 1e-6, "atol": 1e-7}
    model, found = _end(sample, name, treatment, 0.3, **fine)
    off = np.abs(found.y[-1] - exact.y[-1])
    limit = 1e-5 if name == "radau" else 1e-3
    assert off[: model.n_pos].max() < limit
    assert off[-1] < limit * max(1.0, abs(exact.y[-1, -1]))
    assert exact.y[-1, -1] < -1e-3  # the dampers have done work


@BOTH
def test_energy_is_kept_by_undamped_elements(name, treatment):
    """What the elements store and give back, over a fine run."""
    sample = _links("bushing", 1e3)
    model, y0 = prepared(sample, Treatment(treatment))
    times = np.linspace(0.0, 0.3, 7)
    made = new_run(model, y0, Treatment(treatment), name, 0.3, rtol=1e-6, atol=1e-7)
    found = integrate(made, times)
    total = [energies(model, assemble(model, 0.0, y), y).sum() for y in found.y]
    assert np.ptp(total) < (1e-5 if name == "radau" else 2e-2)


@pytest.mark.parametrize("kind", [k for k in ELEMENTS.values() if k.rows], ids=lambda k: k.kind)
def test_rows_are_the_tangent_of_the_element(kind):
    """Contract: -g'F is the force of the element at rest, k g'g its change where F is small."""
    sample = _links("hinge", flexible=False)
    numbers = {"spring": (50.0, 3.0, 0.9), "rotary_spring": (5.0, 2.0, 0.3)}
    values = numbers.get(kind.kind, (40.0, 30.0, 20.0, 3.0, 2.0, 1.0, *(0.5,) * 6))
    table = ForceTable("e", kind.kind, 1, 4, values)
    bodies = [body_of(random_points(np.random.default_rng(3), 0)) for _ in range(2)]
    markers = [
        MarkerTable(GROUND, np.zeros(3)),
        *(MarkerTable(k, np.array(x)) for k, x in ((0, [0.0, 0, 0]), (0, [1.0, 0, 0]))),
        *(MarkerTable(k, np.array(x)) for k, x in ((1, [0.0, 0, 0]), (1, [0.3, 0.9, 0.1]))),
    ]
    model = assemble_model(bodies, markers, [], forces=[table])
    y = np.zeros(model.n_pos + model.n_vel + 1)
    y[: model.n_pos] = sample.start.positions[: model.n_pos]
    step = np.zeros(model.n_vel)
    step[9:12] = (0.02, -0.01, 0.15)
    y[: model.n_pos] = moved(model, y[: model.n_pos], step)
    work, rows = new_workspace(model), np.zeros((MOST_ROWS, N_ELEMENT_ROW))
    evaluate(model, work, 0.0, y)
    one, two = work.motion[model.force_marker[0]]
    element_rows(int(model.force_kind[0]), one, two, model.force_parameters[0], rows)
    rows = rows[kind.rows_in_use(values)]
    J = np.hstack([work.J_m[k, :, :6] for k in model.force_marker[0]])
    G = rows[:, :6] @ J[:, :6], rows[:, 6:12] @ J[:, 6:12]
    G = np.hstack(G)
    f = assemble(model, 0.0, y).f
    np.testing.assert_allclose(-G.T @ rows[:, FORCE], f, atol=1e-9)
    assert (rows[:, STIFFNESS] >= 0.0).all()
    # rate of the element's own coordinate by differences
    for j in range(model.n_vel):
        step = np.zeros(model.n_vel)
        step[j] = 1e-6
        change = []
        for sign in (1.0, -1.0):
            near = y.copy()
            near[: model.n_pos] = moved(model, y[: model.n_pos], sign * step)
            evaluate(model, work, 0.0, near)
            one, two = work.motion[model.force_marker[0]]
            there = np.zeros((MOST_ROWS, N_ELEMENT_ROW))
            element_rows(int(model.force_kind[0]), one, two, model.force_parameters[0], there)
            change.append(there[kind.rows_in_use(values)][:, FORCE])
        rate = (change[0] - change[1]) / 2e-6
        np.testing.assert_allclose(rate, rows[:, STIFFNESS] * G[:, j], atol=1e-7)
