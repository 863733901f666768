"""Every integrator on two mechanisms at equal accuracy: the table of docs/integrators.md.

PYTHONPATH=.:tests:benchmarks .venv/bin/python benchmarks/integrator_choice.py

The integrator is made by the function of a run, with the settings of a case but for its rtol, which
goes from 1e-2 downwards until the probe's error, the largest of 21 times, is small enough. CPU time
of that run, with the tolerances of the mechanism and without monitors, the smallest of three.
Prints a table for each mechanism, cells: ms, steps, rtol. Takes a few minutes.
"""

import time
from collections.abc import Callable

import numpy as np
from samples.constraint_runs import prepared
from samples.mechanism_samples import Sample, chain
from samples.stability_samples import hand
from solver_methods import PEERS

from plymotion.solver.errors import InputError
from plymotion.solver.inputs.case.tables.solver import Solver
from plymotion.solver.integrators.choice import make_integrator
from plymotion.solver.integrators.generic.drive import Solution, integrate
from plymotion.solver.integrators.table import FOR_EQUATIONS, treatment_of
from plymotion.solver.studies.compiling import compile_ahead

TOLERANCES = [10.0**-k for k in np.arange(2.0, 11.1, 0.5)]
CHOICES = [
    ("radau", "projection", {}),
    *(
        (name, "projection", {})
        for name in (*FOR_EQUATIONS, *PEERS)
        if name not in ("radau", "ida")
    ),
    ("gear", "projection", {"max_order": 2}),
    ("generalized-alpha", "ggl", {}),
    ("ida", "ggl", {}),
]
OUTPUTS = 21
LONGEST = 4.0  # s of CPU, after which no tighter tolerance is tried


def _once(
    sample: Sample, name: str, constraints: str, options: dict, rtol: float, t_end: float
) -> tuple[Solution, float]:
    keys = {"t_end": t_end, "output_step": t_end / (OUTPUTS - 1), "rtol": rtol}
    ours = name if name not in PEERS else "generalized-alpha" if constraints == "ggl" else "rk8"
    solver = Solver.model_validate(
        keys | {"integrator": ours, "constraints": constraints} | options
    ).model_copy(update={"integrator": name})
    treatment = treatment_of(solver)
    model, y0 = prepared(sample, treatment)
    begin = time.process_time()
    made = make_integrator(model, y0, solver, treatment)
    solution = integrate(made, np.linspace(0.0, t_end, OUTPUTS))
    return solution, time.process_time() - begin


def table(title: str, sample: Sample, t_end: float, goals: tuple[float, ...]) -> None:
    """Print the cost of every choice at each goal [m]."""
    exact = sample.place(_once(sample, "rk8", "projection", {}, 1e-12, t_end)[0].y)
    print(
        f"\n{title}, {t_end:g} s\n\n| integrator | " + " | ".join(f"{g:g} m" for g in goals) + " |"
    )
    print("|---|" + "---|" * len(goals))
    for name, constraints, options in CHOICES:
        cells = {}
        try:
            for rtol in TOLERANCES:
                solution, cpu = _once(sample, name, constraints, options, rtol, t_end)
                if solution.status != "finished":
                    continue
                apart = sample.place(solution.y) - exact
                error = float(np.linalg.norm(apart, axis=1).max())
                for goal in goals:
                    if error < goal and goal not in cells:
                        again = [
                            _once(sample, name, constraints, options, rtol, t_end)[1]
                            for _ in range(2)
                        ]
                        steps = solution.counters.steps
                        cells[goal] = f"{1e3 * min(cpu, *again):.3g} ms, {steps}, {rtol:.0e}"
                if len(cells) == len(goals) or cpu > LONGEST:
                    break
        except InputError as error:
            print(f"| {name} | {error} |")
            continue
        label = name + "".join(f", {k} = {v}" for k, v in options.items())
        print(f"| {label} | " + " | ".join(cells.get(g, "-") for g in goals) + " |", flush=True)


def main() -> None:
    compile_ahead()
    problems: list[tuple[str, Callable[[], Sample], float, tuple[float, ...]]] = [
        (
            "Chain of 4 rigid links, spherical joints",
            lambda: chain(4, "spherical"),
            1.0,
            (1e-3, 1e-5, 1e-7),
        ),
        (
            "Hand of the double pendulum on a hinge, 4 modes, released under gravity",
            lambda: hand("revolute", gravity=True)[0],
            0.05,
            (1e-4, 1e-6, 1e-8),
        ),
    ]
    for title, make, t_end, goals in problems:
        table(title, make(), t_end, goals)


if __name__ == "__main__":
    main()
