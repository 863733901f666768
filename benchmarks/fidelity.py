"""Accuracy asked, estimated and true of runs with [fidelity]: `make fidelity`.

.venv/bin/python benchmarks/fidelity.py build/benchmarks/fidelity.json [SCENE ...]

Each scene (fidelity_scenes.py) is asked for four outputs at several accuracies. The true error is
measured against a run of the same theory with more modes, a finer mesh and a tight tolerance.
FENICSX_PYTHON builds the packages. What a scene gave is kept in its folder: a run that was
interrupted goes on with the next scene. `--again` measures all scenes named.
"""

import json
import os
import subprocess
import sys
import time
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
from fidelity_figures import by, totals
from fidelity_scenes import HELD, SCENES, Table

from plymotion.solver.inputs.case.load import load_case
from plymotion.solver.inputs.case.write import write_case
from plymotion.solver.package.body.selection import vibrations
from plymotion.solver.run.execution import execute, read_run
from plymotion.solver.studies.fidelity.checked_run import checked, plan_of, read_planned
from plymotion.solver.studies.fidelity.comparison import difference, scales
from plymotion.solver.studies.fidelity.plan import BodyPlan, Plan, with_values
from plymotion.solver.studies.fidelity.trial import Trial, attempted

ACCURACIES = (1e-1, 1e-2, 1e-3, 1e-4)
OUTPUTS = ("tip", "deflection", "force", "moment")
FOLDER = Path("build/benchmarks/fidelity")
TRUTH_RTOL, TRUTH_ELEMENTS, DOUBT_MORE = 1e-9, 96, 4
# Brute force: vibrations of each kind, static shapes, stiffening, tolerance.
GRID = ((0, 1, 3), (0, 4), (False, True), (1e-4,))
FORMAT = 3  # of what is kept of a scene
BUDGET = 10.0  # CPU s of a request
# A sudden start excites all frequencies: a force at 1e-3 has no finite set of modes.
START = "quasi-static"


def main() -> None:
    """Build the packages, measure the scenes that have no result yet, write the file."""
    words = [word for word in sys.argv[1:] if word != "--again"]
    out, again = Path(words[0]), "--again" in sys.argv
    names = words[1:] or list(SCENES)
    scenes = {n: kept for n in SCENES if (kept := known(n)) and not (again and n in names)}
    missing = [name for name in names if name not in scenes]
    for count, name in enumerate(missing, 1):
        begin = time.process_time()
        built([name])
        try:
            scenes[name] = measured(name)
        except RuntimeError as problem:  # a truth that stops cannot be compared with
            print(problem, flush=True)
            continue
        keep(name, scenes[name])
        took = time.process_time() - begin
        summary = scenes[name]["summary"]
        print(f"[{count}/{len(missing)}] {name}: {summary} ({took:.0f} CPU s)", flush=True)
        write(out, scenes)
    write(out, scenes)


def known(name: str) -> Table | None:
    """Return the kept result of a scene; None if its case has changed, or it has none."""
    file = FOLDER / name / "measured.json"
    if not file.is_file():
        return None
    kept: Table = json.loads(file.read_text(encoding="utf-8"))
    same = kept.get("format") == FORMAT and kept["case"] == toml(with_runs(SCENES[name]))
    return kept["measured"] if same else None


def keep(name: str, found: Table) -> None:
    """Keep the result of a scene."""
    file = FOLDER / name / "measured.json"
    content = {"format": FORMAT, "case": toml(with_runs(SCENES[name])), "measured": found}
    file.with_suffix(".part").write_text(json.dumps(content, indent=1), encoding="utf-8")
    file.with_suffix(".part").rename(file)


def built(names: list[str]) -> None:
    """Write the cases and build their packages."""
    for name in names:
        folder = FOLDER / name
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "case.toml").write_text(toml(with_runs(SCENES[name])), encoding="utf-8")
        write_case(load_case(folder / "case.toml"), folder)
        packages(folder)


def packages(folder: Path) -> None:
    """Build the packages of a case that are missing or out of date, in one process."""
    files = sorted((folder / "bodies").glob("*.json"))
    specs = [str(f) for f in files if not current(f)]
    if specs:
        python = os.environ.get("FENICSX_PYTHON", "python3")
        command = [python, "-m", "plymotion.preprocess", "body", *specs]
        subprocess.run([*command, "--out-dir", str(folder / "bodies")], check=True)


def current(spec: Path) -> bool:
    """Tell whether the package of a specification is there and newer."""
    package = spec.with_suffix(".vtkhdf")
    return package.is_file() and package.stat().st_mtime > spec.stat().st_mtime


def with_runs(scene: Table) -> Table:
    """Return a scene with a planned run and the run of the truth."""
    solver = {"rtol": TRUTH_RTOL, "geometric_stiffening": True}
    return {
        **scene,
        "solver": {**scene["solver"], "start": START},
        "variants": {
            "planned": {"fidelity": {"accuracy": 1e-3}},
            "truth": {"bodies": truth_bodies(scene), "solver": solver},
        },
        "runs": {"planned": {"variants": ["planned"]}, "truth": {"variants": ["truth"]}},
    }


def truth_bodies(scene: Table, more: int = 0) -> Table:
    """Return mesh and modes of the beams of a truth, with some more bending vibrations."""
    flat = scene["signals"]["deflection"]["component"] == "y"  # the others move in space
    bodies: Table = {}
    for name, body in scene["bodies"].items():
        if body["kind"] != "beam":
            continue
        places = [p for p in body["interfaces"] if p != "root" and loaded(name, p, scene)]
        modes: list[Table] = [
            {"kind": "bending-xy", "count": 12 + more},
            {"kind": "axial", "count": 2},
        ]
        attached: Table = {"kind": "attachment", "directions": ["x", "y", "rz"]}
        if not flat:
            modes = [
                {"kind": "bending-xy", "count": 6},
                {"kind": "bending-xz", "count": 12 + more},
                {"kind": "torsion", "count": 3},
                {"kind": "axial", "count": 2},
            ]
            del attached["directions"]
        modes += [{**attached, "at": place} for place in places]
        modes += [{"kind": "static-inertia"}, {"kind": "static-axial"}]
        bodies[name] = {"elements": TRUTH_ELEMENTS, "modes": modes}
    return bodies


def loaded(body: str, place: str, scene: Table) -> bool:
    """Tell whether a joint, a mass or a force acts at an interface."""
    key = f"{body}.{place}"
    joints = [text for joint in scene["joints"].values() for text in joint["between"]]
    acting = [*scene.get("masses", {}).values(), *scene.get("forces", {}).values()]
    return key in joints or key in [each["at"] for each in acting]


def truth(name: str) -> tuple[np.ndarray, float]:
    """Return the signals (o, k) of the truth and its CPU time; kept in a file."""
    file, run = FOLDER / name / "truth.npz", FOLDER / name / "runs" / "truth.json"
    if file.is_file():
        known = np.load(file)
        if str(known["case"]) == (FOLDER / name / "case.toml").read_text():
            return known["signals"], float(known["cpu"])
    begin = time.process_time()
    result, summary = execute(read_run(run), progress=False)
    if not summary["completed"]:
        raise RuntimeError(f"{name}: the truth stopped: {summary['message']}")
    signals = {signal.name: signal.values for signal in result.signals}
    found = np.array([signals[output] for output in OUTPUTS])
    cpu = time.process_time() - begin
    case = (FOLDER / name / "case.toml").read_text()
    np.savez(file, signals=found, cpu=cpu, case=case)
    return found, cpu


def doubt(name: str, exact: np.ndarray) -> list[float]:
    """Return how far the truth can tell each signal: its difference from another one.

    That one has DOUBT_MORE bending vibrations more and three times the tolerance: what both lack
    is less. Relative to the largest value; the signals are kept in a file.
    """
    scene, folder = SCENES[name], FOLDER / name / "doubt"
    bodies = truth_bodies(scene, DOUBT_MORE)
    solver = {
        **scene["solver"], "start": START, "rtol": 3.0 * TRUTH_RTOL, "geometric_stiffening": True
    }  # fmt: skip
    merged = {body: {**table, **bodies.get(body, {})} for body, table in scene["bodies"].items()}
    text = toml({**scene, "bodies": merged, "solver": solver, "runs": {"base": {}}})
    other = kept_run(folder, text, name)
    return [float(d) for d in difference("pointwise", other, exact) / scales("pointwise", exact)]


def kept_run(folder: Path, text: str, what: str) -> np.ndarray:
    """Return the signals (o, k) of the run "base" of a case; they are kept in its folder."""
    file = folder / "signals.npz"
    if file.is_file() and str((known := np.load(file))["case"]) == text:
        return np.asarray(known["signals"])
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "case.toml").write_text(text, encoding="utf-8")
    write_case(load_case(folder / "case.toml"), folder)
    packages(folder)
    result, summary = execute(read_run(folder / "runs" / "base.json"), progress=False)
    if not summary["completed"]:
        raise RuntimeError(f"{what}: {folder.name} stopped: {summary['message']}")
    signals = {signal.name: signal.values for signal in result.signals}
    found = np.array([signals[output] for output in OUTPUTS])
    np.savez(file, signals=found, case=text)
    return found


def measured(name: str) -> Table:
    """Return all requests of a scene."""
    exact, truth_cpu = truth(name)
    doubts = doubt(name, exact)
    spec, check = read_planned(FOLDER / name / "runs" / "planned.json")
    spec = asking(spec, OUTPUTS[0], 1e-2)
    first = plan_of(asking(spec, OUTPUTS[0], 1e-2), check)  # loads what is compiled
    both = first.study.model, first.study.check
    trials = [attempted(spec, base_plan(first.plan), *both, [OUTPUTS[0]]) for _ in range(5)]
    rigid = [trial.cpu for trial in trials if trial is not None]
    grid = brute_force(spec, first, exact)
    tight = all_modes(spec, first)
    sizes = scales("pointwise", exact)
    requests = []
    for output, accuracy in product(OUTPUTS, ACCURACIES):
        o = OUTPUTS.index(output)
        answer = checked(plan_of(asking(spec, output, accuracy), check))
        delivered = answer.delivered
        assert delivered is not None
        assert answer.trial is not None
        of_model = error(answer.trial, 0, exact[o]) / sizes[o]
        of_check = error(delivered, 0, exact[o]) / sizes[o]
        meeting = [cpu for cpu, errors in grid if errors[o] / sizes[o] <= accuracy]
        estimate = float(answer.estimate[0]) if answer.estimate is not None else None
        requests.append(
            {
                "output": output,
                "accuracy": accuracy,
                "verdict": answer.verdict,
                "reason": answer.reason,
                "estimate": estimate,
                "true": float(of_model),
                "delivered": float(of_check),
                "model_s": answer.trial.cpu,
                "cheapest_s": min(meeting, default=None),
                "check_s": answer.check.cpu if answer.check is not None else None,
                "indicators_s": answer.cpu["indicators"],
                "plan_s": sum(answer.cpu[part] for part in ("base", "indicators", "plan")),
                "all_s": sum(answer.cpu.values()),
                "rounds": answer.rounds,
                "plan": answer.plan.table(),
            }
        )
    accepted = [r for r in requests if r["verdict"] == "met"]
    met = [r for r in accepted if r["true"] <= r["accuracy"]]
    return {
        "held": name in HELD,
        "truth_s": truth_cpu,
        "doubt": dict(zip(OUTPUTS, doubts, strict=True)),
        "rigid_s": float(np.median(rigid)),
        "all_modes_s": tight.cpu if tight is not None else None,
        "all_modes_error": [
            float(error(tight, o, exact[o]) / sizes[o]) for o in range(len(OUTPUTS))
        ]
        if tight is not None
        else None,
        "requests": requests,
        "summary": f"accepted {len(accepted)} of {len(requests)}, met {len(met)}",
    }


def error(trial: Trial, o: int, exact: np.ndarray) -> float:
    """Largest difference of a signal of a run from the truth; infinite if it ended early."""
    if not trial.complete:
        return 1e300
    return float(difference("pointwise", trial.signals[o], exact))


def asking(spec: Any, output: str, accuracy: float) -> Any:
    """Return the run with another request."""
    fidelity = with_values(
        spec.mechanism.fidelity, accuracy=accuracy, signals=[output], budget=BUDGET
    )
    return replace(spec, mechanism=with_values(spec.mechanism, fidelity=fidelity))


def base_plan(plan: Plan) -> Plan:
    """Return the plan of rigid bodies."""
    return Plan({name: BodyPlan() for name in plan.bodies}, False, 1e-4)


def all_modes(spec: Any, answer: Any) -> Trial | None:
    """Run all vibrations and load shapes of the check packages with a tight tolerance."""
    bodies = {}
    for name in answer.plan.bodies:
        package = answer.study.check[name].package
        labels = tuple(package.mode_labels[i] for i in vibrations(package).tolist())
        bodies[name] = BodyPlan(labels, 10, True, "check")
    return attempted(
        spec, Plan(bodies, True, 1e-5), answer.study.model, answer.study.check, list(OUTPUTS)
    )


def brute_force(spec: Any, answer: Any, exact: np.ndarray) -> list[tuple[float, list[float]]]:
    """Return CPU time and errors (o,) of the models of the grid."""
    found = []
    for count, static, stiffening, rtol in product(*GRID):
        if not count and not static and stiffening:
            continue
        bodies = {}
        for name in answer.plan.bodies:
            package = answer.study.model[name].package
            known = [package.mode_labels[i] for i in vibrations(package).tolist()]
            kept = [label for label in known if int(label.rpartition(" ")[2]) <= count]
            bodies[name] = BodyPlan(tuple(kept), static)
        plan = Plan(bodies, stiffening, rtol)
        trial = attempted(spec, plan, answer.study.model, answer.study.check, list(OUTPUTS))
        if trial is None:
            continue
        found.append((trial.cpu, [error(trial, o, exact[o]) for o in range(len(OUTPUTS))]))
    return found


def write(out: Path, scenes: Table) -> None:
    """Write the file with the figures over all scenes, and those that were not used for tuning."""
    figures = totals(scenes)
    figures["held"] = totals({n: s for n, s in scenes.items() if s["held"]})
    figures["outputs"], figures["accuracies"] = by("output", scenes), by("accuracy", scenes)
    figures["scenes"] = scenes
    out.parent.mkdir(parents=True, exist_ok=True)
    out.with_suffix(".part").write_text(json.dumps(figures, indent=1), encoding="utf-8")
    out.with_suffix(".part").rename(out)


def toml(table: Table) -> str:
    """Return plain data as TOML, tables below the first level in one line."""
    return "\n".join(f"{key} = {inline(value)}" for key, value in table.items()) + "\n"


def inline(value: Any) -> str:
    """Return a value in one line of TOML."""
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{json.dumps(k)} = {inline(v)}" for k, v in value.items()) + " }"
    if isinstance(value, list):
        return "[" + ", ".join(map(inline, value)) + "]"
    return json.dumps(value)


if __name__ == "__main__":
    main()
