"""Fixed steps by the solver table, which benchmarks use and cases do not have."""

import pytest
from constraint_runs import prepared
from mechanism_samples import pendulum

from plymotion.solver.dynamics.constraints.treatment import treatment_of
from plymotion.solver.integrators.choice import make_integrator
from plymotion.solver.integrators.generic import integrate


@pytest.mark.parametrize(
    ("integrator", "constraints"),
    [
        ("rk8", "projection"),
        ("gear", "projection"),
        ("radau", "projection"),
        ("generalized-alpha", "ggl"),
    ],
)
@pytest.mark.parametrize(("t_end", "steps"), [(0.1, 10), (0.105, 11)])
def test_every_step_but_the_last_has_this_length(integrator, constraints, t_end, steps):
    solver = {
        "integrator": integrator,
        "constraints": constraints,
        "t_end": t_end,
        "rtol": 1e-6,
        "atol_position": 1e-8,
        "atol_velocity": 1e-6,
        "max_step": None,
        "max_order": 3,
        "fixed_step": 0.01,
    }
    model, y0 = prepared(pendulum(), treatment_of(solver))
    lengths = []
    solution = integrate(
        make_integrator(model, y0, solver), [t_end], lambda one: lengths.append(one.t - one.t_old)
    )
    assert solution.status == "finished"
    assert lengths[:-1] == pytest.approx([0.01] * (steps - 1))
    assert lengths[-1] == pytest.approx(t_end - 0.01 * (steps - 1))
