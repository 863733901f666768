"""Stiffness by tension in Newton's matrix, against the derivative of the accelerations.

A load of 2000 kg hangs at rest on a chain, or a force of 20 kN pulls it. What is left out, the
weight of a flexible link on its own modes, is as small as the link is light.
"""

import numpy as np
import pytest
import scipy.linalg
from samples.crane_samples import beam_crane, rigid_crane
from samples.segment_samples import run_of

from plymotion.solver.dynamics.evaluation.accelerations import accelerations, assemble
from plymotion.solver.dynamics.evaluation.evaluation import evaluate
from plymotion.solver.dynamics.model.coordinates import moved
from plymotion.solver.dynamics.model.model import new_workspace
from plymotion.solver.integrators.compiled.pencil import freeze, new_frozen
from plymotion.solver.integrators.compiled.tension import freeze_tension
from plymotion.solver.run.preparation import prepare

STANDS = {"smooth_step": {"value": 0.0, "duration": 1.0}}
PULL = """[forces.pull]
kind = "force"
at = "link4.low"
direction = [0.0, 0.0, -1.0]
law = { polynomial = [20000.0] }
"""
HELD = "drive = { smooth_step = { value = 0.0, duration = 1.0 } }"


CRANES = {
    "rigid": lambda folder: rigid_crane(folder, 5, drive=HELD),
    "pulled": lambda folder: rigid_crane(folder, 5, load=0.05, drive=HELD, more=PULL),
    "wires": lambda folder: run_of(*beam_crane(3, drive=STANDS)),
}


def hanging(spec):
    """Model, start and constrained motions (n, k) of a crane whose trolley stands."""
    ready = prepare(spec.mechanism, spec.packages)
    equations = assemble(ready.model, 0.0, ready.y0)
    return ready.model, ready.y0, equations, scipy.linalg.null_space(equations.Phi_q)


@pytest.mark.parametrize("crane", CRANES)
def test_tension_is_the_derivative_of_the_accelerations(crane, tmp_path):
    """All frequencies across the chain, up to 1900 rad/s of rigid links, 2e4 rad/s of wires."""
    model, y0, equations, Z = hanging(CRANES[crane](tmp_path))
    n_pos, step, columns = model.n_pos, 1e-8, []
    for z in Z.T:
        pair = []
        for sign in (1.0, -1.0):
            y = y0.copy()
            y[:n_pos] = moved(model, y[:n_pos], sign * step * z)
            pair.append(accelerations(model, assemble(model, 0.0, y), y)[0])
        columns.append((pair[0] - pair[1]) / (2.0 * step))
    exact = np.sort(np.linalg.eigvals(-Z.T @ np.array(columns).T).real)

    work, frozen = new_workspace(model), new_frozen(model)
    evaluate(model, work, 0.0, y0)
    forces = np.zeros(model.layout.newton.place.shape[0])
    forces[: model.n_constraint] = accelerations(model, equations, y0)[1]
    freeze(model, work, 0.0, y0, frozen)
    freeze_tension(model, work, 0.0, y0, forces, frozen.tension)
    K = np.zeros((model.n_vel, model.n_vel))
    for i in range(model.n_body):
        v, n, m = model.vel_start[i], model.layout.size[i], model.n_mode[i]
        lower = np.tril(frozen.tension[i, :n, :n])
        K[v : v + n, v : v + n] = lower + lower.T - np.diag(np.diag(lower))
        modal = model.K_qq[model.square_start[i] :][: m * m].reshape(m, m)
        K[v + 6 : v + n, v + 6 : v + n] += modal
    found = scipy.linalg.eigvalsh(Z.T @ K @ Z, Z.T @ equations.M @ Z)
    assert exact[-1] > 1e6
    np.testing.assert_allclose(found, exact, rtol=1e-3 if crane == "wires" else 1e-8)
