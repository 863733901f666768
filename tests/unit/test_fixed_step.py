"""Fixed steps, which benchmarks use and cases do not have."""

import pytest
from samples.constraint_runs import prepared
from samples.mechanism_samples import pendulum

from plymotion.solver.inputs.case.tables.solver import Solver
from plymotion.solver.integrators.choice import make_integrator
from plymotion.solver.integrators.generic.drive import integrate
from plymotion.solver.integrators.table import treatment_of


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
    keys = {"integrator": integrator, "constraints": constraints, "max_order": 3}
    solver = Solver.model_validate({"t_end": t_end, "output_step": t_end, **keys})
    model, y0 = prepared(pendulum(), treatment_of(solver))
    lengths = []
    solution = integrate(
        make_integrator(model, y0, solver, fixed_step=0.01),
        [t_end],
        lambda one: lengths.append(one.t - one.t_old),
    )
    assert solution.status == "finished"
    assert lengths[:-1] == pytest.approx([0.01] * (steps - 1))
    assert lengths[-1] == pytest.approx(t_end - 0.01 * (steps - 1))
