"""Genetic algorithms of pymoo: no gradients, for many local optima and for fronts (NSGA-II)."""

from typing import Any

import numpy as np

from ..problem import Options, Problem
from .contract import Driver, Ending, library

POPULATION = 24


def genetic(problem: Problem, options: Options) -> Ending:
    """Minimise by a genetic algorithm. Raises InputError without pymoo."""
    front = problem.study.front is not None
    where = "pymoo.algorithms." + ("moo.nsga2" if front else "soo.nonconvex.ga")
    Algorithm: Any = getattr(library(where, "pymoo"), "NSGA2" if front else "GA")
    ElementwiseProblem: Any = library("pymoo.core.problem", "pymoo").ElementwiseProblem
    minimize: Any = library("pymoo.optimize", "pymoo").minimize
    n, count = problem.z0.size, problem.cons(problem.x0).size
    bounds = problem.bounds[:n]

    class Elements(ElementwiseProblem):  # type: ignore[misc]
        def _evaluate(self, x: Any, out: dict[str, object], *_: Any, **__: Any) -> None:
            # The bound of peaks is what the design gives: the largest of them.
            full = np.r_[x, 0.0] if problem.bounded else x
            cons = problem.cons(full)
            if problem.bounded:
                peaks = problem.peaks
                out["F"] = float(-cons[:peaks].min())
                cons = np.r_[np.ones(peaks), cons[peaks:]]
            else:
                out["F"] = problem.fun(full)
            if front:
                out["F"] = [out["F"], problem.second(full)]
            if count:
                out["G"] = -cons

    elements = Elements(
        n_var=n, n_obj=1 + front, n_ieq_constr=count, xl=bounds[:, 0], xu=bounds[:, 1]
    )
    algorithm = Algorithm(pop_size=POPULATION, eliminate_duplicates=True)
    limit = ("n_gen", options.iterations)
    minimize(elements, algorithm, limit, seed=options.seed, verbose=False)
    best = problem.best
    x = problem.x0 if best is None else problem.x_of(np.array(best.p))
    return Ending(x, True, f"{options.iterations} generations")


DRIVER = Driver(
    "genetic", "genetic algorithm (pymoo), without gradients; fronts by NSGA-II", genetic
)
