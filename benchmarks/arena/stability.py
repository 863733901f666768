"""Map of stability: step by stiffness, for every integrator of every code that takes fixed steps.

A cart of 1 kg on a spring along a rail, from which a rod of 1 kg hangs that swings from the
horizontal. 200 steps; a run is unstable when the spring has more than twice the energy that the
fall of the rod can give. Ours are called as a run calls them, with a step that a case cannot set.
"""

import json
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
from frame import Runner
from matplotlib.colors import ListedColormap
from scenes import BUILD, HERE, read

from plymotion.solver.report.style import WARNING, Canvas, colour, house_style

STIFFNESS = np.geomspace(1e2, 1e10, 9)  # [N/m]
STEPS = np.geomspace(1e-4, 1e-1, 13)  # [s]
ENERGY = 0.5 * 9.81  # of the fall [J]
CELLS = [(float(k), float(h)) for k in STIFFNESS for h in STEPS]
OURS: dict[str, tuple[str, str, dict[str, Any]]] = {
    "rk5": ("rk5", "projection", {}),
    "rk8": ("rk8", "projection", {}),
    "radau": ("radau", "projection", {}),
    "gear, order 1": ("gear", "baumgarte", {"fixed_order": 1}),
    "gear, order 2": ("gear", "baumgarte", {"fixed_order": 2}),
    "generalized-alpha, 0.8": ("generalized-alpha", "ggl", {"spectral_radius": 0.8}),
    "generalized-alpha, 1.0": ("generalized-alpha", "ggl", {"spectral_radius": 1.0}),
}


def measured(codes: list[Runner]) -> dict[str, dict[str, list[int]]]:
    """State of each cell by code and method: 0 stable, 1 unstable, 2 stopped or not finite."""
    scene = read(HERE / "stability")
    sheet = scene.sheet()
    found = {}
    for runner in codes:
        methods = getattr(runner.module, "FIXED", ())
        if runner.absent or not (methods or "own" in runner.module.ENVIRONMENT):
            continue
        if methods:
            folder = BUILD / "stability" / runner.key
            folder.mkdir(parents=True, exist_ok=True)
            job = {"sheet": sheet["sheet"], "cells": CELLS, "methods": methods}
            (folder / "in.json").write_text(json.dumps(job), encoding="utf-8")
            command = [runner.python, str(runner.module.__file__), str(folder.absolute())]
            subprocess.run(command, capture_output=True, check=True)
            reached = json.loads((folder / "out.json").read_text(encoding="utf-8"))
        else:
            reached = ours(Path(sheet["run_file"]))
        found[runner.name] = {
            method: [
                2 if x is None else int(0.5 * k * x * x > 2.0 * ENERGY)
                for x, (k, _) in zip(values, CELLS, strict=True)
            ]
            for method, values in reached.items()
        }
    return found


def ours(file: Path) -> dict[str, list[float | None]]:
    """Largest |x| of the cart by method, None where the integrator stops."""
    from samples.constraint_runs import new_run

    from plymotion.solver.dynamics.elements.constraints.treatment import Treatment
    from plymotion.solver.mechanism.assembly import treated
    from plymotion.solver.run.execution import read_run
    from plymotion.solver.run.preparation import prepare

    spec = read_run(file)
    found: dict[str, list[float | None]] = {method: [] for method in OURS}
    for k in STIFFNESS:
        own = spec.changed({"forces.spring.expression": f"-{float(k)!r} * x"})
        ready = prepare(own.mechanism, own.packages)
        for h in STEPS:
            for method, (name, constraints, options) in OURS.items():
                treatment = Treatment(constraints)
                model = treated(ready.model, treatment)
                reached = 0.0
                try:
                    more = {"fixed_step": float(h), "rtol": 1e-8, "atol": 1e-10} | options
                    made = new_run(model, ready.y0, treatment, name, 200 * float(h), **more)
                    while made.status == "running":
                        made.step()
                        reached = max(reached, abs(float(made.y[0])))
                    whole = made.status == "finished" and np.isfinite(made.y).all()
                except (ArithmeticError, RuntimeError, ValueError, np.linalg.LinAlgError):
                    whole = False
                found[method].append(reached if whole else None)
    return found


def rows(results: dict[str, Any]) -> list[list[str]]:
    """Numbers of stable, growing and stopped runs by code and method."""
    return [
        [code, method, *(str(states.count(k)) for k in range(3))]
        for code, methods in results["stability"].items()
        for method, states in methods.items()
    ]


def draw(found: dict[str, dict[str, list[int]]], picture: Path) -> None:
    """A panel for each method."""
    panels = [(code, method) for code, methods in found.items() for method in methods]
    columns = 4
    rows = -(-len(panels) // columns)
    shades = ListedColormap([colour(2), colour(4), WARNING])
    with house_style(formulas=True):
        canvas = Canvas(11.0, 2.5 * rows)
        axes = np.ravel(canvas.panels(rows, columns))
        for axis, (code, method) in zip(axes, panels, strict=False):
            state = np.reshape(found[code][method], (len(STIFFNESS), len(STEPS)))
            axis.pcolormesh(STEPS, STIFFNESS, state, cmap=shades, vmin=0, vmax=2, alpha=0.8)
            axis.set(xscale="log", yscale="log", xlabel="step [s]", ylabel="spring [N/m]")
            axis.plot(STEPS, 5.0 / STEPS**2, color="#222222", linewidth=0.8, linestyle=":")
            axis.set_ylim(STIFFNESS[0] / 3, STIFFNESS[-1] * 3)
            axis.set_title(f"{code}\n{method}", fontsize=8)
            axis.grid(visible=False)
        for axis in axes[len(panels) :]:
            axis.set_visible(False)
        canvas.save(picture)
