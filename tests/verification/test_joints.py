"""Every joint: Jacobian and gamma against differences; joints do no work. Eq. (10), (11)."""

import numpy as np
import pytest
from samples.case_samples import rigid, run_text
from samples.flexible_samples import body_of, difference, random_marker, random_points, random_state

from plymotion.solver.dynamics.elements.joints.contract import FREEDOMS
from plymotion.solver.dynamics.elements.joints.table import CONSTRAINTS, DRIVES, KINDS
from plymotion.solver.dynamics.evaluation.accelerations import assemble
from plymotion.solver.math import laws
from plymotion.solver.math.rotations import along_parameters, matrix_to_parameters, vector_to_matrix
from plymotion.solver.mechanism.assembly import assemble_model
from plymotion.solver.mechanism.tables import JointTable, MarkerTable, rigid_body

LAW = laws.polynomial([0.1, 0.7, 0.3, -0.2])


def _model(kind, rng, grounded):
    points = [random_points(rng, 3), random_points(rng, 2)]
    bodies = [body_of(p) for p in points]
    one = random_marker(rng, -1, 0) if grounded else random_marker(rng, 0, 3)
    two = random_marker(rng, 1, 2)
    joint = JointTable("joint", kind, 0, 1, LAW if kind in DRIVES else None, parameters=(1.3,))
    return assemble_model(bodies, [one, two], [joint])


def _moved(model, y, a, h):
    """State after h seconds at constant coordinate accelerations a (one RK4 step)."""

    def rate(state):
        out = np.zeros_like(state)
        for i in range(model.n_body):
            p, j, m = model.pos_start[i], model.n_pos + model.vel_start[i], model.n_mode[i]
            out[p : p + 3] = state[j : j + 3]
            rates = along_parameters(state, p + 3, *state[j + 3 : j + 6])
            out[p + 3 : p + 7] = 0.5 * np.array(rates)
            out[p + 7 : p + 7 + m] = state[j + 6 : j + 6 + m]
        out[model.n_pos : -1] = a
        return out

    k1 = rate(y)
    k2 = rate(y + 0.5 * h * k1)
    k3 = rate(y + 0.5 * h * k2)
    k4 = rate(y + h * k3)
    return y + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)


@pytest.mark.parametrize("grounded", [False, True])
@pytest.mark.parametrize("kind", list(KINDS))
def test_jacobian_and_gamma_against_differences(kind, grounded):
    rng = np.random.default_rng(7)
    model = _model(kind, rng, grounded)
    y, a, t = random_state(rng, model), rng.normal(size=model.n_vel), 0.3

    def velocity(state, equations):
        return equations.Phi_q @ state[model.n_pos : -1] + equations.Phi_t

    def Phi(s):
        return assemble(model, t + s, _moved(model, y, a, s)).Phi

    def Phi_d(s):
        state = _moved(model, y, a, s)
        return velocity(state, assemble(model, t + s, state))

    equations = assemble(model, t, y)
    scale = np.abs(equations.Phi_q).max() * np.abs(y[model.n_pos :]).max()
    np.testing.assert_allclose(velocity(y, equations), difference(Phi), atol=1e-9 * scale)
    np.testing.assert_allclose(
        equations.Phi_q @ a - equations.gamma, difference(Phi_d), atol=1e-8 * scale
    )


def test_printed_eq_11_misses_the_mixed_term():
    """Eq. (11) prints -2 Phi_q qdot for its last term: only -2 Phi_qt qdot fits the difference."""
    rng = np.random.default_rng(11)
    model = _model("rotation_drive", rng, False)
    y, t = random_state(rng, model), 0.3
    equations = assemble(model, t, y)
    later = assemble(model, t + 1e-6, y)
    v = y[model.n_pos : -1]
    mixed = (later.Phi_q - equations.Phi_q) @ v / 1e-6  # Phi_qt qdot
    printed = equations.gamma + 2 * mixed - 2 * equations.Phi_q @ v
    assert np.abs(printed - equations.gamma).max() > 0.1


@pytest.mark.parametrize("kind", list(KINDS))
def test_rows_remove_what_the_joint_says(kind):
    """Between coincident frames: which velocities of marker two in its axes the rows hold."""
    A = vector_to_matrix(np.array([0.4, -1.1, 0.7]))
    body = rigid_body("body", 1.0, np.zeros(3), np.eye(3))
    markers = [MarkerTable(-1, np.zeros(3), A), MarkerTable(0, np.zeros(3), np.eye(3))]
    law = laws.polynomial([0.0]) if kind in DRIVES else None
    joint = JointTable("joint", kind, 0, 1, law, parameters=(1.0,))
    model = assemble_model([body], markers, [joint])
    y = np.zeros(model.n_pos + model.n_vel + 1)
    y[3:7] = matrix_to_parameters(A)
    of_two = assemble(model, 0.0, y).C[:, 6:]
    C = np.hstack([of_two[:, :3] @ A, of_two[:, 3:] @ A])
    rank = np.linalg.matrix_rank(C, tol=1e-9)
    held = [
        freedom
        for freedom, unit in zip(FREEDOMS, np.eye(6), strict=True)
        if rank and np.linalg.matrix_rank(np.vstack([C, unit]), tol=1e-9) == rank
    ]
    constraint = CONSTRAINTS[kind]
    assert set(constraint.removes) <= set(held)
    if len(constraint.removes) == len(constraint.units):
        assert set(constraint.removes) == set(held)


@pytest.mark.parametrize("lead", [0.05, -0.02])
def test_nut_falls_along_a_screw(lead, tmp_path):
    """Weight turns the nut: z = -g t^2 / 2 over 1 + J (2 pi / lead)^2 / m, for many turns."""
    text = (
        "gravity = [0.0, 0.0, -9.81]\n[ground.O]\nposition = [0.0, 0.0, 0.3]\n"
        + rigid("nut", 2.0, [0.1, 0.1, 1e-4], {"a": (0, 0, 0)})
        + '[joints.thread]\nkind = "screw"\nbetween = ["ground.O", "nut.a"]\n'
        + f"lead = {lead}\n"
        + "".join(
            f'[signals.{name}]\nkind = "joint"\njoint = "thread"\ncoordinate = "{name}"\n'
            for name in ("z", "angle")
        )
    )
    t, s, summary = run_text(tmp_path, text, t_end=1.0, step=0.01)
    per = 2.0 * np.pi / lead
    z = -0.5 * 9.81 * t**2 / (1.0 + 1e-4 * per**2 / 2.0)
    assert abs(z[-1] / lead) > 10.0
    np.testing.assert_allclose(s["z"], z, atol=1e-9)
    np.testing.assert_allclose(s["angle"], per * z, atol=1e-7)
    assert summary["completed"]


def test_driven_screw_moves_by_its_lead(tmp_path):
    """Both bodies free to move, the pair without external force: the mass centre stays."""
    text = (
        rigid("spindle", 1.0, 0.01, {"a": (0, 0, 0)})
        + rigid("nut", 3.0, 0.02, {"a": (0, 0, 0)})
        + '[joints.thread]\nkind = "screw"\nbetween = ["spindle.a", "nut.a"]\n'
        + "axis = [1.0, 0.0, 0.0]\nlead = 0.1\ndrive = { polynomial = [0.0, 0.0, 20.0] }\n"
        + '[signals.z]\nkind = "joint"\njoint = "thread"\ncoordinate = "z"\n'
        + '[signals.nut]\nkind = "position"\nat = "nut.a"\ncomponent = "x"\n'
        + '[signals.spindle]\nkind = "position"\nat = "spindle.a"\ncomponent = "x"\n'
    )
    t, s, _ = run_text(tmp_path, text, t_end=1.0, step=0.05)
    np.testing.assert_allclose(s["z"], 0.1 * 20.0 * t**2 / (2.0 * np.pi), atol=1e-9)
    np.testing.assert_allclose(3.0 * s["nut"] + s["spindle"], 0.0, atol=1e-9)
