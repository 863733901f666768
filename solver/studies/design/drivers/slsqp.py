"""Sequential quadratic programming of SciPy: up to about fifty variables."""

from scipy.optimize import minimize

from ..problem import Options, Problem
from .contract import Driver, Ending


def slsqp(problem: Problem, options: Options) -> Ending:
    """Minimise by SLSQP."""
    limits = {"type": "ineq", "fun": problem.cons, "jac": problem.cons_jac}
    optimum = minimize(
        problem.fun,
        problem.x0,
        jac=problem.jac,
        method="SLSQP",
        bounds=problem.bounds,
        constraints=[limits] if problem.cons(problem.x0).size else [],
        options={"ftol": options.tolerance, "maxiter": options.iterations},
    )
    return Ending(optimum.x, bool(optimum.success), str(optimum.message))


DRIVER = Driver("slsqp", "sequential quadratic programming (SciPy), the default", slsqp)
