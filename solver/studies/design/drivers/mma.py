"""Method of moving asymptotes of NLopt: many variables and many limits."""

from typing import Any

import numpy as np

from ....math.arrays import Array
from ..problem import Options, Problem
from .contract import Driver, Ending, library


def mma(problem: Problem, options: Options) -> Ending:
    """Minimise by MMA. Raises InputError without NLopt."""
    nlopt: Any = library("nlopt", "nlopt")
    optimiser = nlopt.opt(nlopt.LD_MMA, problem.x0.size)
    low, high = problem.bounds.T
    optimiser.set_lower_bounds(low)
    optimiser.set_upper_bounds(high)

    def objective(x: Array, gradient: Array) -> float:
        if gradient.size:
            gradient[:] = problem.jac(x.copy())
        return problem.fun(x.copy())

    def limits(result: Array, x: Array, gradient: Array) -> None:
        if gradient.size:
            gradient[:] = -problem.cons_jac(x.copy())
        result[:] = -problem.cons(x.copy())

    optimiser.set_min_objective(objective)
    count = problem.cons(problem.x0).size
    if count:
        optimiser.add_inequality_mconstraint(limits, np.full(count, 1e-8))
    optimiser.set_ftol_rel(options.tolerance)
    optimiser.set_xtol_rel(options.tolerance)
    optimiser.set_maxeval(options.iterations)
    try:
        x = optimiser.optimize(problem.x0)
    except (nlopt.RoundoffLimited, RuntimeError) as error:
        return Ending(problem.x0, False, str(error))
    code = optimiser.last_optimize_result()
    return Ending(np.asarray(x), 0 < code < nlopt.MAXEVAL_REACHED, f"NLopt ended with {code}")


DRIVER = Driver("mma", "method of moving asymptotes (NLopt), many variables and limits", mma)
