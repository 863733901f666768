"""Joints at flexible bodies by markers and by virtual bodies: the same motion and forces."""

import numpy as np
import pytest

from plymotion.solver.dynamics.evaluation.accelerations import assemble
from plymotion.solver.inputs.case.load import load_case
from plymotion.solver.inputs.case.write import write_case
from plymotion.solver.mechanism.build import build
from plymotion.solver.mechanism.consistent import consistent_state
from plymotion.solver.run.execution import execute, read_run

REACTIONS = {
    f"{joint}_{component}": {
        "kind": "reaction",
        "joint": joint,
        "quantity": "force",
        "component": component,
        "side": 1,
        "axes": "joint",
        "divide_by": None,
        "description": "",
    }
    for joint in ("shoulder", "elbow")
    for component in "xyz"
}


@pytest.fixture(scope="module")
def spec(repository, tmp_path_factory):
    """A linear double pendulum from its shipped packages, 20 ms of it."""
    folder = tmp_path_factory.mktemp("build")
    case = load_case(repository / "cases/double-pendulum-limits/case.toml")
    write_case(case, folder, repository / "tests/packages/double-pendulum-limits")
    return read_run(folder / "runs/layup-2-linear.json").changed(
        {
            "solver.t_end": 0.02,
            "solver.rtol": 1e-9,
            "solver.atol_position": 1e-12,
            "solver.atol_velocity": 1e-10,
            **{f"signals.{name}": table for name, table in REACTIONS.items()},
        }
    )


def _attached(spec, how, **solver):
    changes = {f"solver.{key}": value for key, value in solver.items()}
    return spec.changed({"solver.attachment": how} | changes)


@pytest.mark.parametrize(("integrator", "t_end"), [("rk8", 0.02), ("radau", 0.004)])
def test_same_motion_and_reactions(spec, integrator, t_end):
    found = {}
    for how in ("marker", "virtual"):
        changed = _attached(spec, how, integrator=integrator, t_end=t_end)
        result, summary = execute(changed, progress=False)
        assert summary["completed"]
        found[how] = {s.name: s.values for s in result.signals}
        assert summary["checks"]["energy_drift_relative"] < 1e-9
    for name, values in found["marker"].items():
        size = max(1.0, np.abs(values).max())
        np.testing.assert_allclose(found["virtual"][name], values, atol=1e-8 * size, err_msg=name)


def test_saddle_point_stays_regular_without_mass(spec):
    """The mass matrix loses six ranks for each virtual body; the whole matrix is regular."""
    how = _attached(spec, "virtual")
    built = build(how.mechanism, how.packages)
    model = built.model
    assert model.n_body == 2 + 3  # arm root, arm tip, hand root
    y = consistent_state(model, built.start, built.joint_names)
    equations = assemble(model, 0.0, y)
    assert np.linalg.matrix_rank(equations.M) == model.n_vel - 6 * 3
    n, n_c = model.n_vel, model.n_constraint
    A = np.zeros((n + n_c, n + n_c))
    A[:n, :n], A[n:, :n], A[:n, n:] = equations.M, equations.Phi_q, equations.Phi_q.T
    scale = 1.0 / np.sqrt(np.abs(A).max(axis=1))  # of units, not of the problem
    assert np.linalg.cond(scale[:, None] * A * scale) < 1e9
    np.testing.assert_allclose(y[model.pos_start[2:]], [0.0, 0.545, 0.545], atol=1e-12)
