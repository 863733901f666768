"""Studies of a design against closed forms and rebuilt designs: build/benchmarks/design.json.

python benchmarks/design.py build/benchmarks/design.json
"""

import json
import sys
import tempfile
from dataclasses import replace
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np
from scipy.optimize import minimize_scalar

from plymotion.solver.studies.design.study import optimise
from plymotion.solver.studies.design.trials import Order, Trials
from plymotion.solver.workers.executors import Here
from tests.samples.design_samples import BEST, CARBON, angles, oscillator, tube

PLIES = 12


def extension_twist(folder: Path) -> dict[str, Any]:
    """A tube of one angle: the best twist under tension of a thin wall is that of S16."""
    one = {"a": angles(1)["p0"]}
    one["a"]["of"].append("sections.tube:laminates.wall.plies.1.angle_deg")
    study = {"run": "base", "maximise": {"section": "arm", "entry": "S14"}, "verify": False}
    table = tube(parameters=one, studies={"twist": study})
    begin = perf_counter()
    found = optimise(Order(table, Path("tube.toml"), False, "twist", folder), Here)
    S11, S22, S66 = 1.0 / CARBON["E1"], 1.0 / CARBON["E2"], 1.0 / CARBON["G12"]
    S12 = -CARBON["nu12"] / CARBON["E1"]

    def coupling(t: float) -> float:
        c, s = np.cos(t), np.sin(t)
        first = (2.0 * S11 - 2.0 * S12 - S66) * s * c**3
        return float(first - (2.0 * S22 - 2.0 * S12 - S66) * s**3 * c)

    thin = minimize_scalar(coupling, bounds=(0.1, 1.4), method="bounded")
    ends = [start["best"]["p"][0] for start in found["starts"]]
    return {
        "angle_deg": found["optimum"]["p"][0],
        "thin_wall_deg": float(np.degrees(thin.x)),
        "starts": len(ends),
        "starts_within_0.1_deg": sum(abs(e - found["optimum"]["p"][0]) < 0.1 for e in ends),
        "gradient": found["gradient"],
        "wall_s": perf_counter() - begin,
    }


def oscillating(folder: Path) -> dict[str, Any]:
    """A ball on a spring: the best stiffness is where the largest force is at its limit."""
    order = Order(oscillator(), Path("ball.toml"), False, "stop", folder)
    found = optimise(order, Here)
    return {
        "stiffness": found["optimum"]["p"][0],
        "closed_form": BEST,
        "violation": found["optimum"]["violation"],
        "gradient": found["gradient"],
    }


def frequency_slopes(folder: Path) -> dict[str, Any]:
    """Exact derivatives of the lowest frequency by 12 angles, against rebuilt designs."""
    study = {"run": "base", "maximise": {"frequency": "arm"}, "difference": 1e-4}
    table = tube(PLIES, parameters=angles(PLIES), studies={"f": study})
    order = Order(table, Path("tube.toml"), False, "f", folder)
    p = 70.0 * np.random.default_rng(34).uniform(-1.0, 1.0, PLIES)
    slopes, seconds = [], []
    for exact in (True, False):
        trials = Trials(replace(order, exact=exact))
        trials.values(p)
        begin = perf_counter()
        trials.values(p)
        value = perf_counter()
        slopes.append(np.array(trials.slopes(p)[0][0]))
        seconds.append({"value_wall_s": value - begin, "slopes_wall_s": perf_counter() - value})
    largest = float(np.abs(slopes[1]).max())
    return {
        "largest_error": float(np.abs(slopes[0] - slopes[1]).max()) / largest,
        "exact": seconds[0],
        "differences": seconds[1],
    }


def main() -> None:
    """Compute all and write the file that the command line names."""
    with tempfile.TemporaryDirectory() as folder:
        found = {
            each.__name__: each(Path(folder) / each.__name__)
            for each in (extension_twist, oscillating, frequency_slopes)
        }
    out = Path(sys.argv[1])
    out.parent.mkdir(parents=True, exist_ok=True)
    out.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
    print(out.read_text(encoding="utf-8"))


if __name__ == "__main__":
    main()
