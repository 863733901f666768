"""An integrator is added by one class after integrators/contract.py and one entry of the table."""

from typing import get_args

import numpy as np
import pytest
from constraint_runs import prepared
from mechanism_samples import pendulum

from plymotion.solver.dynamics.constraints.treatment import Treatment
from plymotion.solver.inputs.case.solver import Solver
from plymotion.solver.integrators import choice
from plymotion.solver.integrators.contract import Integrator
from plymotion.solver.integrators.generic import integrate
from plymotion.solver.integrators.generic.hermite import Hermite

SOLVER = {
    "integrator": "heun",
    "constraints": "projection",
    "spectral_radius": 0.8,
    "t_end": 0.5,
    "rtol": 1e-5,
    "atol_position": 1e-7,
    "atol_velocity": 1e-6,
    "max_step": None,
    "corrections": 2,
}


class Heun(Integrator):
    """Heun's method of order 2 with Euler's as its error: the toy of this test."""

    order = 2
    on_failure = "Take another method than this toy"

    def __init__(self, *args, corrections=1, **options):
        super().__init__(*args, **options)
        self.corrections = corrections

    @classmethod
    def settings(cls, solver):
        return {"corrections": solver["corrections"]}

    def _attempt(self, h, t_new):
        f_0 = self.derivative(self.t, self.y).copy()
        f_1 = self.derivative(t_new, self.y + h * f_0)
        for _ in range(self.corrections):
            y = self.y + 0.5 * h * (f_0 + f_1)
            f_1 = self.derivative(t_new, y).copy()
        error = self.norm(0.5 * h * (f_1 - f_0) * self.norm.weight(self.y, y))
        factor = 0.9 * max(error, 1e-6) ** -0.5
        self._h_next = h * min(2.0, max(0.2, factor))
        if error > 1.0 and self.fixed_step is None:
            self._trouble = "too rough"
            return None
        nearest = self.project(t_new, y)
        if nearest is None:
            self._h_next = 0.25 * h
            return None
        self._ends = self.y, f_0, nearest, f_1
        return nearest

    def _dense(self):
        return Hermite(self.t_old, self.h, *self._ends)


def test_a_toy_integrator_runs_a_mechanism(monkeypatch):
    monkeypatch.setitem(choice.INTEGRATORS, "heun", Heun)
    model, y0 = prepared(pendulum(), Treatment())
    times = np.linspace(0.0, 0.5, 6)
    made = choice.make_integrator(model, y0, SOLVER)
    assert isinstance(made, Heun)
    assert made.corrections == 2
    done = integrate(made, times)
    assert done.status == "finished"
    exact = integrate(
        choice.make_integrator(model, y0, SOLVER | {"integrator": "rk8", "rtol": 1e-9}), times
    )
    assert np.abs(done.y - exact.y)[:, : model.n_pos].max() < 1e-4
    assert np.abs(np.linalg.norm(done.y[:, :3], axis=1) - 1.0).max() < 1e-9  # projected
    failing = choice.make_integrator(model._replace(gravity_G=np.full(3, np.nan)), y0, SOLVER)
    assert "singular position" in failing.message or "toy" in failing.message


def test_a_case_may_name_every_integrator_of_the_table():
    names = get_args(Solver.model_fields["integrator"].annotation)
    assert set(names) == set(choice.INTEGRATORS)


@pytest.mark.parametrize("kind", choice.INTEGRATORS.values(), ids=lambda k: k.__name__)
def test_every_integrator_of_the_table_keeps_the_contract(kind):
    assert issubclass(kind, Integrator)
    assert isinstance(kind.order, int)
    assert kind.takes in ("derivative", "constrained", "model")
    words = (kind.on_growth, kind.on_failure, kind.on_any_failure)
    assert not any(text.endswith(".") for text in words)
    assert kind.on_failure
