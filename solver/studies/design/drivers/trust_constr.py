"""Trust-region method of SciPy with barriers: many variables, slower than SLSQP with few."""

import numpy as np
from scipy.optimize import BFGS, NonlinearConstraint, minimize

from ..problem import Options, Problem
from .contract import Driver, Ending


def trust_constr(problem: Problem, options: Options) -> Ending:
    """Minimise by trust-constr."""
    limits = []
    if problem.cons(problem.x0).size:
        limits = [NonlinearConstraint(problem.cons, 0.0, np.inf, jac=problem.cons_jac, hess=BFGS())]
    optimum = minimize(
        problem.fun,
        problem.x0,
        jac=problem.jac,
        hess=BFGS(),
        method="trust-constr",
        bounds=problem.bounds,
        constraints=limits,
        options={
            "gtol": options.tolerance,
            "xtol": options.tolerance,
            "maxiter": options.iterations,
            "initial_tr_radius": 0.2,
        },
    )
    return Ending(optimum.x, optimum.status in (1, 2), str(optimum.message))


DRIVER = Driver("trust-constr", "trust region with barriers (SciPy), many variables", trust_constr)
