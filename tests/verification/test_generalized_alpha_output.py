"""Generalized-alpha between steps and under a drive: states, work, and balance of order two."""

import numpy as np
import pytest
from samples.case_samples import HEAD, rigid

from plymotion.solver.dynamics.evaluation.series import balance
from plymotion.solver.inputs.case.load import load_case
from plymotion.solver.inputs.case.write import write_case
from plymotion.solver.integrators.choice import make_integrator
from plymotion.solver.integrators.generic.drive import integrate
from plymotion.solver.run.execution import read_run
from plymotion.solver.run.preparation import prepare

STEPS = (0.02, 0.01, 0.005)
LEVER = [0.01, 0.1, 0.1]


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """A rod turned by t^3, a second one on a hinge at its end; (formulation, step) to integrator.

    Without a step, radau at 1e-10.
    """
    folder = tmp_path_factory.mktemp("driven")
    text = (
        "gravity = [0.0, -9.81, 0.0]\n[ground]\nO = { position = [0.0, 0.0, 0.0] }\n"
        + rigid("rod", 1.0, LEVER, {"a": [-0.5, 0, 0], "b": [0.5, 0, 0]}, position=[0.5, 0, 0])
        + rigid("two", 1.0, LEVER, {"a": [-0.5, 0, 0]}, position=[1.5, 0, 0])
        + '[joints.foot]\nkind = "revolute"\nbetween = ["ground.O", "rod.a"]\naxis = [0, 0, 1.0]\n'
        + "drive = { polynomial = [0.0, 0.0, 0.0, 1.0] }\n"
        + '[joints.mid]\nkind = "revolute"\nbetween = ["rod.b", "two.a"]\naxis = [0, 0, 1.0]\n'
        + "[solver]\nt_end = 1.0\noutput_step = 0.1\nrtol = 1e-10\n[runs.base]\n"
    )
    (folder / "case.toml").write_text(HEAD + text)
    write_case(load_case(folder / "case.toml"), folder / "build")
    spec = read_run(folder / "build/runs/base.json")

    def one(formulation: str = "", step: float | None = None):
        keys = {"integrator": "generalized-alpha", "constraints": formulation}
        changes = {f"solver.{k}": v for k, v in keys.items()} if formulation else {}
        mine = spec.changed(changes)
        ready = prepare(mine.mechanism, mine.packages)
        args = ready.model, ready.y0, mine.mechanism.solver, ready.treatment
        return ready, make_integrator(*args, fixed_step=step)

    return one


@pytest.mark.parametrize("formulation", ["index3", "ggl"])
@pytest.mark.parametrize("part", [0.0, 0.25, 0.5])
def test_order_within_steps_under_a_cubic_drive(made, formulation, part):
    """Positions, velocities, work of the drive, and energy less work."""
    errors = []
    for h in STEPS:
        times = np.array([0.0, 0.4, 0.6, 0.8])
        times[1:] += part * h
        ready, integrator = made(formulation, h)
        y, exact = integrate(integrator, times).y, integrate(made()[1], times).y
        model, apart = ready.model, np.abs(y - exact)
        kept = balance(model, times, y)
        drift = kept.energies.sum(axis=1) - y[:, -1]
        ends = model.n_pos, model.n_pos + model.n_vel
        errors.append(
            [
                apart[:, : ends[0]].max(),
                apart[:, ends[0] : ends[1]].max(),
                apart[:, -1].max(),
                np.abs(drift - drift[0]).max(),
            ]
        )
    orders = np.log2(np.divide(errors[:-1], errors[1:]))
    assert orders.min() > 1.85, orders


@pytest.mark.parametrize("formulation", ["index3", "ggl"])
@pytest.mark.parametrize("alone", [False, True])
def test_outputs_within_steps_lie_on_the_constraints(made, formulation, alone):
    """From the loop and from dense output step by step; the cubic alone misses them by 1e-6 m."""
    times = np.linspace(0.0, 1.0, 173)
    ready, integrator = made(formulation, 0.02)
    y = integrate(integrator, times, (lambda one: None) if alone else None).y
    kept = balance(ready.model, times, y)
    inside = np.abs(times / 0.02 - np.rint(times / 0.02)) > 1e-6
    assert np.abs(kept.Phi[inside]).max() < 1e-11
    # one correction, with the Jacobian before the positions were moved
    assert np.abs(kept.Phi_d[inside]).max() < 1e-6
