"""Accepted requests of [fidelity] against another theory: `make fidelity-theory`.

.venv/bin/python benchmarks/fidelity_theory.py build/benchmarks/fidelity-theory.json [SCENE ...]

Beams divided into SEGMENTS bodies with frames of their own, which turn by any angle: geometrically
exact in the limit of many segments. The same with half of them shows how near that limit is. A
third of the scenes of fidelity_scenes.py; their requests and plans are those of fidelity.py.
"""

import json
import sys
import time
from itertools import product
from pathlib import Path

import fidelity
import numpy as np
from fidelity import OUTPUTS, Table, asking, error, toml
from fidelity_scenes import HELD, SCENES

from plymotion.solver.studies.fidelity.checked_run import checked, plan_of, read_planned
from plymotion.solver.studies.fidelity.comparison import difference, scales

THIRD = (
    "one-link", "one-link-soft", "resonance", "off-resonance", "spin-up", "spin-up-short",
    "pendulum-aluminium", "pendulum-steel",
)  # fmt: skip
ACCURACIES = (1e-1, 1e-2, 1e-3)
SEGMENTS = 16
FOLDER = Path("build/benchmarks/fidelity-theory")


def main() -> None:
    """Measure the scenes, write the file."""
    out = Path(sys.argv[1])
    scenes: Table = json.loads(out.read_text())["scenes"] if out.is_file() else {}
    for name in sys.argv[2:] or THIRD:
        begin = time.process_time()
        scenes[name] = measured(name)
        met = scenes[name]["met"]
        print(f"{name}: met {met} ({time.process_time() - begin:.0f} CPU s)", flush=True)
        figures = {"accuracies": totals(scenes), "scenes": scenes}
        out.parent.mkdir(parents=True, exist_ok=True)
        out.with_suffix(".part").write_text(json.dumps(figures, indent=1), encoding="utf-8")
        out.with_suffix(".part").rename(out)


def measured(name: str) -> Table:
    """Return the accepted requests of a scene with their errors against the other theory."""
    exact = segmented(name, SEGMENTS)
    coarse = segmented(name, SEGMENTS // 2)
    sizes = scales("pointwise", exact)
    fidelity.built([name])
    own, _ = fidelity.truth(name)
    spec, check = read_planned(fidelity.FOLDER / name / "runs" / "planned.json")
    requests = []
    for output, accuracy in product(OUTPUTS, ACCURACIES):
        o = OUTPUTS.index(output)
        answer = checked(plan_of(asking(spec, output, accuracy), check))
        delivered = answer.delivered
        assert delivered is not None
        requests.append(
            {
                "output": output,
                "accuracy": accuracy,
                "verdict": answer.verdict,
                "delivered": float(error(delivered, 0, exact[o]) / sizes[o]),
            }
        )
    accepted = [r for r in requests if r["verdict"] == "met"]
    met = [r for r in accepted if r["delivered"] <= r["accuracy"]]
    return {
        "held": name in HELD,
        "theories": dict(zip(OUTPUTS, gap(own, exact), strict=True)),
        "segments": dict(zip(OUTPUTS, gap(coarse, exact), strict=True)),
        "requests": requests,
        "met": f"{len(met)} of {len(accepted)}",
    }


def gap(one: np.ndarray, two: np.ndarray) -> list[float]:
    """Return the difference of signals (o, k), of their largest values."""
    return [float(d) for d in difference("pointwise", one, two) / scales("pointwise", two)]


def totals(scenes: Table) -> Table:
    """Return accepted and met requests by accuracy."""
    found: Table = {}
    for request in (r for scene in scenes.values() for r in scene["requests"]):
        row = found.setdefault(f"{request['accuracy']:g}", {"accepted": 0, "met": 0})
        row["accepted"] += request["verdict"] == "met"
        row["met"] += request["verdict"] == "met" and request["delivered"] <= request["accuracy"]
    return found


def segmented(name: str, count: int) -> np.ndarray:
    """Return the signals (o, k) of a scene with beams in segments."""
    folder = FOLDER / f"{name}-{count}"
    scene = SCENES[name]
    bodies = {
        body: {
            **table,
            "segments": count,
            "elements": 6 * count,
            "modes": [{"kind": "bending-xy", "count": 1}],
        }
        for body, table in scene["bodies"].items()
    }
    solver = {
        **scene["solver"], "start": fidelity.START, "rtol": 1e-7, "geometric_stiffening": True
    }  # fmt: skip
    case = {**scene, "bodies": bodies, "solver": solver, "runs": {"base": {}}}
    return fidelity.kept_run(folder, toml(case), f"{name} in {count} segments")


if __name__ == "__main__":
    main()
