"""Studies of a design against closed forms and rebuilt designs: build/benchmarks/design.json.

python benchmarks/design.py build/benchmarks/design.json [PART ...]
"""

import itertools
import json
import os
import resource
import sys
import tempfile
import time
import tomllib
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from design_random import against_random
from design_scenes import SCENES, hinged
from scipy.optimize import minimize_scalar

from plymotion.solver.package.common.design import Derivative
from plymotion.solver.run.preparation import integrated, prepare
from plymotion.solver.signals import Recording
from plymotion.solver.studies.design.exact import Traced, by_adjoint
from plymotion.solver.studies.design.measures import Made, measure_of
from plymotion.solver.studies.design.study import optimise
from plymotion.solver.studies.design.trials import StudySpec, Trials
from plymotion.solver.studies.sensitivities.differentiated_run import Trace, with_sensitivities
from plymotion.solver.studies.sensitivities.parameters import combined, design_parameter
from plymotion.solver.workers.executors import Here
from tests.samples.design_samples import BEST, CARBON, angles, oscillator, tube

PLIES = 12
BEAM = Path("cases/actuated-beam/case.toml").absolute()
STATE = Path("build/benchmarks/random").absolute()  # with it, an interrupted part goes on
ANGLE = 0.2  # step of differences [deg]
SIX, SIX_WEIGHTS = (-3, -2, -1, 1, 2, 3), (-1, 9, -45, 45, -9, 1)


def extension_twist(folder: Path) -> dict[str, Any]:
    """A tube of one angle: the best twist under tension of a thin wall is that of S16."""
    one = {"a": angles(1)["p0"]}
    one["a"]["of"].append("sections.tube:laminates.wall.plies.1.angle_deg")
    study = {"run": "base", "maximise": {"section": "arm", "entry": "S14"}, "verify": False}
    table = tube(parameters=one, studies={"twist": study})
    found = optimise(StudySpec(table, Path("tube.toml"), False, "twist", folder), Here)
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
    }


def oscillating(folder: Path) -> dict[str, Any]:
    """A ball on a spring: the best stiffness is where the largest force is at its limit."""
    given = StudySpec(oscillator(), Path("ball.toml"), False, "stop", folder)
    found = optimise(given, Here)
    return {
        "stiffness": found["optimum"]["p"][0],
        "closed_form": BEST,
        "violation": found["optimum"]["violation"],
        "gradient": found["gradient"],
    }


def frequency_slopes(folder: Path) -> dict[str, Any]:
    """Exact derivatives of the lowest frequency by 12 angles, against rebuilt designs."""
    study = {"run": "base", "maximise": {"frequency": "arm"}}
    table = tube(PLIES, parameters=angles(PLIES), studies={"f": study})
    given = StudySpec(table, Path("tube.toml"), False, "f", folder)
    p = 70.0 * np.random.default_rng(34).uniform(-1.0, 1.0, PLIES)
    slopes, plain = np.array(Trials(replace(given, exact=True)).slopes(p)[0][0]), Trials(given)
    expected = np.array([_six_points(plain, p, k) for k in range(PLIES)])
    return {"largest_error": float(np.abs(slopes - expected).max() / np.abs(expected).max())}


def signals_of_scenes(folder: Path) -> dict[str, float]:
    """Errors of derivatives of signals over time, along a direction of two ply angles.

    Over the largest derivative of the signal, against six-point differences of rebuilt designs; of
    four steps the best counts: the noise of runs spoils small ones, fast vibrations large ones.
    """
    p, direction, found = np.array([55.0, -25.0]), np.array([0.8, -0.6]), dict[str, float]()
    for name, change in SCENES.items():
        table = hinged()
        change(table)
        first, *others = ({"signal": signal, "of": "rms"} for signal in table["signals"])
        study = {"run": "base", "minimise": first, "verify": False, "rtol": 1e-10}
        study["subject_to"] = [{**other, "max": 1e9} for other in others]
        table["design"]["studies"] = {"all": study}
        given = StudySpec(table, Path("scene.toml"), False, "all", folder / name)
        exact = Trials(replace(given, exact=True))
        # packages without derivatives keep strains to 5e-7 only
        plain = Trials(replace(given, exact=name == "stresses"))
        if why := exact.values(p).why:
            raise SystemExit(f"{name}: {why}")
        columns = exact._columns(p)
        slopes = [np.tensordot(direction, column, 1) for column in zip(*columns, strict=True)]
        errors = np.full(len(slopes), np.inf)
        for step in (0.2, 0.04, 0.015, 0.006):
            expected = [np.zeros_like(slope) for slope in slopes]
            for place, weight in zip(SIX, SIX_WEIGHTS, strict=True):
                assert not plain.values(p + place * step * direction).why
                assert plain._last is not None
                for sum_, raw in zip(expected, plain._last[2], strict=True):
                    sum_ += weight * raw / (60.0 * step)
            pairs = zip(slopes, expected, strict=True)
            errors = np.minimum(errors, [abs(a - b).max() / abs(a).max() for a, b in pairs])
        found[name] = float(errors.max())
        print(f"{name:26s} {found[name]:.1e}", flush=True)
    return found


def beam(plies: int = PLIES // 2, **study: Any) -> dict[str, Any]:
    """The actuated beam of the paper: an angle of each of the plies of flanges and of webs."""
    table = tomllib.loads(BEAM.read_text("utf-8"))
    box = tomllib.loads((BEAM.parent / "../sections/box-layup-2.toml").read_text("utf-8"))
    ply = {"material": "as4-3501-6", "thickness": 0.000762 / plies}
    layup = [{**ply, "angle_deg": a} for a in (0.0, 30.0) * (plies // 2)]
    box["laminates"] = {"flange": {"plies": layup}, "web": {"plies": layup}}
    walls = {"top": "flange", "bottom": "flange", "left": "web", "right": "web"}
    box["regions"] = {wall: {"laminate": name} for wall, name in walls.items()}
    key = "sections.box:laminates.{}.plies.{}.angle_deg"
    parameters = {
        f"{name}{k}": {"of": [key.format(name, k)], "kind": "angle", "bounds": [-90.0, 90.0]}
        for name in ("flange", "web")
        for k in range(plies)
    }
    for unused in ("variants", "figures", "coarse"):
        table.pop(unused)
    table["bodies"]["beam"]["damping_ratio"] = 0.02  # so that steps follow the motion
    table["solver"] |= {"integrator": "radau", "t_end": 0.5, "output_step": 0.01}
    tip = {"run": "base", "minimise": {"signal": "tip_deflection", "of": "rms"}, **study}
    return table | {
        "runs": {"base": {}},
        "sections": {"box": {"description": box}},
        "signals": {"tip_deflection": table["signals"]["tip_deflection"]},
        "design": {"parameters": parameters, "studies": {"tip": tip}},
    }


def actuated_beam(folder: Path) -> dict[str, Any]:
    """Its gradient by 12 angles against six-point differences of three, and what it costs."""
    rng = np.random.default_rng(35)
    p, found = 60.0 * rng.uniform(-1.0, 1.0, PLIES), dict[str, Any]()
    for rtol in (1e-6, 1e-10):
        table = beam(rtol=rtol)
        table["solver"]["rtol"] = rtol
        given = StudySpec(table, BEAM, False, "tip", folder)
        exact, plain = Trials(replace(given, exact=True)), Trials(given)
        for each in (exact, plain):
            each.values(p)  # loads what it needs
        slopes = np.array(exact.slopes(p)[0][0])
        if rtol == 1e-6:
            found["design_cpu_s"] = _seconds(plain.values, p)
            found["design_with_derivatives_cpu_s"] = _seconds(exact.values, p)
            found["slopes_cpu_s"] = _seconds(exact.slopes, p)
            found["two_designs_beside_each_cpu_s"] = 2 * PLIES * found["design_cpu_s"]
    errors = []
    for k in (0, 4, 9):
        errors.append(abs(slopes[k] - _six_points(plain, p, k)) / float(np.abs(slopes).max()))
    return {**found, "largest_error": max(errors)}


def ringing_beam(folder: Path) -> dict[str, Any]:
    """The price of a gradient where steps are many: the beam without damping for a second."""
    found: dict[str, Any] = {}
    strength = {"subject_to": [{"strength": "beam", "min": 0.01}]}
    for count, limits in itertools.product((PLIES, 4 * PLIES), ({}, strength)):
        table = beam(rtol=1e-6, plies=count // 2, **limits)
        table["bodies"]["beam"].pop("damping_ratio")
        table["solver"] |= {"rtol": 1e-6, "t_end": 1.0}
        given = StudySpec(table, BEAM, False, "tip", folder)
        exact, plain = Trials(replace(given, exact=True)), Trials(given)
        rng, seconds = np.random.default_rng(35), dict[str, float]()
        for k in range(4):  # the least of three, behind one that loads what they need
            p = 60.0 * rng.uniform(-1.0, 1.0, count)
            took = {
                "design": _seconds(plain.values, p),  # package and run
                "run": _seconds(_run_again, plain),
                "with_derivatives": _seconds(exact.values, p),
                "slopes": _seconds(exact.slopes, p),
            }
            if k:
                seconds = {n: min(each, seconds.get(n, each)) for n, each in took.items()}
        whole = seconds["with_derivatives"] + seconds["slopes"]
        package = seconds["design"] - seconds["run"]
        found[f"angles_{count}{'_with_strength' * bool(limits)}"] = {
            **{f"{name}_cpu_s": each for name, each in seconds.items()},
            "steps": sum(len(steps) for steps in exact._traces["base"].trace.steps),
            "runs_besides_one_package": (whole - package) / seconds["run"],
        }
    return found


def many_parameters(folder: Path, count: int = 1000) -> dict[str, Any]:
    """Adjoint and tangent of the same beam by parameters of its stiffness, against its run."""
    table = beam(rtol=1e-6)
    table["bodies"]["beam"].pop("damping_ratio")
    table["solver"] |= {"rtol": 1e-6, "t_end": 1.0}
    trials = Trials(StudySpec(table, BEAM, False, "tip", folder))
    trials.values(30.0 * np.ones(PLIES))
    spec = trials._last[1].spec
    ((name, package),) = spec.packages.items()
    root, rng = np.linalg.cholesky(package.stiffness), np.random.default_rng(37)
    rates = [root @ rng.normal(size=(len(root), 2)) for _ in range(count)]
    design = tuple(
        Derivative(f"g{k}", "number", (), {"modes/stiffness": rate @ rate.T / count})
        for k, rate in enumerate(rates)
    )
    spec = replace(spec, packages={name: replace(package, design=design)})
    prepared = prepare(spec.mechanism, spec.packages)
    trace, begin = Trace(prepared), time.process_time()
    finished = integrated(prepared, trace, stages=True)
    run, begin = time.process_time() - begin, time.process_time()
    kept, shares = combined([spec], [one.name for one in design])
    parameters = [design_parameter(spec, f"g{k}") for k in kept]
    traced = Traced(prepared, finished, trace, ["tip_deflection"])
    made = Made(spec, finished, prepared.measured, Recording(prepared.model, finished.solution.t,
                np.asarray(finished.solution.y[:])))  # fmt: skip
    measure = measure_of(trials.study.table.objective)
    adjoint = by_adjoint(traced, parameters, [measure], made)[0][0] @ shares
    middle = time.process_time()
    weights = measure.reduce(measure.raw(made), made.t)[1][0]
    result, _ = with_sensitivities(spec, parameters)
    tip = [one.values for one in result.sensitivities if one.signal == "tip_deflection"]
    tangent = weights @ np.stack(tip, axis=1) @ shares
    return {
        "parameters": count,
        "independent": len(shares),
        "run_cpu_s": run,
        "adjoint_runs": (middle - begin) / run,
        "tangent_runs_with_the_run": (time.process_time() - middle) / run,
        "largest_difference": float(np.abs(adjoint - tangent).max() / np.abs(tangent).max()),
    }


def random_designs(_: Path) -> dict[str, Any]:
    """The best of 16 starts of the actuated beam, against the best of random designs."""
    return against_random(BEAM, STATE / "free", beam(starts=16, verify=False))


def random_designs_within_limits(_: Path) -> dict[str, Any]:
    """With the thickness of all plies, and limits of strength, frequency and mass."""
    limits = {"strength": (1.5, None), "frequency": (15.0, None), "mass": (None, 0.085)}
    subject_to = [
        {subject: "beam", **({"min": low} if low else {"max": high})}
        for subject, (low, high) in limits.items()
    ]
    table = beam(starts=16, subject_to=subject_to)
    box = table["sections"]["box"]["description"]
    box["mesh"].pop("wall")  # follows the plies
    keys = [target["of"][0] for target in table["design"]["parameters"].values()]
    thick = [key.replace("angle_deg", "thickness") for key in keys]
    parameter = {"of": thick, "kind": "thickness", "bounds": [1e-4, 1.6e-4]}
    table["design"]["parameters"]["thick"] = parameter
    return against_random(BEAM, STATE / "limited", table)


def _six_points(trials: Trials, p: Any, k: int) -> float:
    """Return the derivative of the objective by an angle, by differences of sixth order."""
    beside = [trials.values(p + i * ANGLE * np.eye(p.size)[k]).values[0][0] for i in SIX]
    return float(np.dot(SIX_WEIGHTS, beside)) / (60.0 * ANGLE)


def _run_again(trials: Trials) -> None:
    """Run the last design again, with its checks."""
    trials.run(trials._last[1].spec, {})


def _seconds(call: Callable[[Any], object], p: Any) -> float:
    """Return the processor time of a call [s], that of the preprocessor that it keeps included."""
    begin = _processor_time()
    call(p)
    return _processor_time() - begin


def _processor_time() -> float:
    """Return the processor time of this process and of its children, living or not [s]."""
    ended = resource.getrusage(resource.RUSAGE_CHILDREN)
    own, found = os.getpid(), time.process_time() + ended.ru_utime + ended.ru_stime
    ticks = os.sysconf("SC_CLK_TCK")
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = stat.read_text().rpartition(")")[2].split()
        except OSError:  # has ended
            continue
        if int(fields[1]) == own:
            found += (int(fields[11]) + int(fields[12])) / ticks
    return found


def main() -> None:
    """Compute all, or the parts that the command line names, and write each as it is known."""
    parts = (
        extension_twist,
        oscillating,
        frequency_slopes,
        signals_of_scenes,
        actuated_beam,
        ringing_beam,
        many_parameters,
        random_designs,
        random_designs_within_limits,
    )
    out, names = Path(sys.argv[1]), sys.argv[2:]
    out.parent.mkdir(parents=True, exist_ok=True)
    found = json.loads(out.read_text(encoding="utf-8")) if out.exists() else {}
    for part in parts:
        if names and part.__name__ not in names:
            continue
        with tempfile.TemporaryDirectory() as folder:
            begin, wall = _processor_time(), time.perf_counter()
            found[part.__name__] = {**part(Path(folder)), "cpu_s": _processor_time() - begin}
        print(
            part.__name__, f"{time.perf_counter() - wall:.0f} s", found[part.__name__], flush=True
        )
        out.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
