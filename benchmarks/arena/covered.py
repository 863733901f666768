"""Error bars that are stated, against true errors, over scenes drawn at random with a seed.

Claims of ours are judged:

- sections: the estimated error of K (`plymotion section`) over sqrt(Kii Kjj), against three times
  the density of cells
- planned runs: `error_at_most` of [fidelity] against a run with all modes (tests/samples)
- runs: `error_bars` of [solver], of chains of rods against rk8 at 1e-11, beside it `rtol` alone,
  which is a tolerance and no bar; and of flexible pendulums against runs with all modes

Draws with an even number may be looked at while the estimates are tuned; the others never were.
"""

import json
import math
import subprocess
import sys
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from multiprocessing import get_context
from os import times
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from frame import ROOT
from page import table
from runners.description import toml
from scenes import BUILD
from tqdm import tqdm

from plymotion.solver.math.disk_cache import sources_sha256

if TYPE_CHECKING:
    from plymotion.solver.run.inputs import RunSpec

SEED = 20261129
Draw = np.random.Generator
CARBON = {
    "kind": "orthotropic", "E1": 1.42e11, "E2": 9.8e9, "E3": 9.8e9, "G12": 6e9, "G13": 6e9,
    "G23": 4.8e9, "nu12": 0.3, "nu13": 0.3, "nu23": 0.42, "rho": 1600.0,
}  # fmt: skip
METAL = {"kind": "isotropic", "E": 7e10, "nu": 0.3, "rho": 2700.0}


@dataclass
class Judged:
    """One bar beside its error, both relative."""

    claim: str
    unseen: bool
    bar: float
    error: float


def section(draw: Draw, folder: Path) -> tuple[float, ...]:
    """A rectangle, ellipse or laminated box; its stated and true error of K."""
    shape = draw.choice(["rectangle", "ellipse", "box"])
    size, ratio = 10.0 ** draw.uniform(-2, 0), draw.uniform(0.2, 1.0)
    angles = [round(float(a)) for a in draw.uniform(-90, 90, 2)]
    spec: dict[str, Any] = {"format": 1, "title": "drawn", "convention": "contour"}
    spec["mesh"] = {
        "rectangle": {"shape": "rectangle", "width": size, "height": size * ratio},
        "ellipse": {"shape": "ellipse", "radius_2": size, "radius_3": size * ratio},
        "box": {"shape": "box", "width": size, "height": size * ratio, "wall": 0.03 * size},
    }[shape]
    spec["materials"] = {"m": CARBON if shape == "box" else METAL}
    spec["regions"] = {"all": {"material": "m"}}
    if shape == "box":
        ply = 0.03 * size / 4
        spec["laminates"] = {
            "wall": {"material": "m", "angles_deg": angles, "ply_thickness": ply, "repeat": 2}
        }
        spec["regions"] = {"all": {"laminate": "wall"}}
    found = []
    for density in (1.0, 3.0):
        spec["mesh"]["density"] = density
        file = folder / "drawn.toml"
        file.write_text(toml(spec), encoding="utf-8")
        command = [sys.executable, "-m", "plymotion", "section", str(file), "--json", "--force"]
        command += ["--no-figures", "--quiet", "--out", str(folder / "out")]
        done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)
        found.append(json.loads(done.stdout))
    K, true = (np.array(each["K"]) for each in found)
    scale = np.sqrt(np.outer(np.diag(true), np.diag(true)))
    bar = float((np.abs(np.array(found[0]["error_estimate"])) / scale).max())
    return bar, float((np.abs(K - true) / scale).max())


def planned(draw: Draw, folder: Path) -> tuple[float, ...]:
    """A driven pendulum of one or two beams with [fidelity]: bar and error of what is delivered."""
    from samples.fidelity_samples import pendulum, planned_run, true_signals

    from plymotion.solver.studies.fidelity.checked_run import checked, plan_of
    from plymotion.solver.studies.fidelity.comparison import difference, scales

    scene = pendulum(
        links=int(draw.integers(1, 3)),
        speed=float(draw.uniform(2.0, 8.0)),
        t_end=float(draw.uniform(0.15, 0.4)),
        accuracy=float(10.0 ** draw.uniform(-3, -1)),
        signals=[["tip_x", "tip_y"], ["bending"], ["force"]][draw.integers(3)],
    )
    side = str(draw.choice(["stiff", "soft"]))
    answer = checked(plan_of(*planned_run(scene, side)))
    stated = answer.delivered_at_most
    if answer.delivered is None or None in stated.values():
        return math.nan, math.nan
    bar = np.array([stated[name] for name in answer.names], dtype=float)
    exact = true_signals(scene, side, 1e-8, axial=3)
    values = np.array([exact[name] for name in answer.names])
    sizes = scales("pointwise", values)
    error = difference("pointwise", answer.delivered.signals, values) / sizes
    worst = int(np.argmax(error / bar))
    return float(bar[worst]), float(error[worst])


def rigid(draw: Draw, folder: Path) -> tuple[float, ...]:
    """A chain of one to three rods, hinges turned at random: bar and error of its end, and rtol."""
    from plymotion.solver.inputs.case.load import load_case
    from plymotion.solver.inputs.case.write import write_case
    from plymotion.solver.run.execution import read_run

    n, lengths = int(draw.integers(1, 4)), draw.uniform(0.2, 1.0, 3)
    spec: dict[str, Any] = {"format": 1, "title": "drawn", "gravity": [0.0, -9.81, 0.0]}
    spec |= {"ground": {"o": {"position": [0.0, 0.0, 0.0]}}, "bodies": {}, "joints": {}}
    at = 0.0
    for k, length in enumerate(map(float, lengths[:n])):
        inertia = [[1e-3, 0.0, 0.0], [0.0, length**2 / 12, 0.0], [0.0, 0.0, length**2 / 12]]
        spec["bodies"][f"rod{k}"] = {
            "kind": "rigid", "mass": 1.0, "centre": [length / 2, 0.0, 0.0], "inertia": inertia,
            "position": [at, 0.0, 0.0],
            "interfaces": {"a": {"position": [0.0] * 3}, "b": {"position": [length, 0.0, 0.0]}},
        }  # fmt: skip
        tilt = float(draw.uniform(-0.5, 0.5))
        spec["joints"][f"hinge{k}"] = {
            "kind": "revolute", "axis": [0.0, math.sin(tilt), math.cos(tilt)],
            "between": [f"rod{k - 1}.b" if k else "ground.o", f"rod{k}.a"],
        }  # fmt: skip
        at += length
    spec["signals"] = {
        c: {"kind": "position", "at": f"rod{n - 1}.b", "component": c} for c in "xyz"
    }
    rtol = float(10.0 ** draw.uniform(-7, -3))
    spec["solver"] = {"t_end": float(draw.uniform(0.5, 2.0)), "output_step": 0.01}
    spec["runs"] = {"base": {}}
    file = folder / "case.toml"
    file.write_text(toml(spec), encoding="utf-8")
    write_case(load_case(file), folder, None)
    run = read_run(folder / "runs/base.json").changed({"solver.rtol": rtol})
    true, _ = silent(run.changed({"solver.integrator": "rk8", "solver.rtol": 1e-11}))
    exact = {signal.name: np.ravel(signal.values) for signal in true.signals}
    return *worst_signal(run, exact, at), rtol


SOLID = """
h = %(height)r; w = %(width)r;
Point(1) = {0, -w/2, -h/2}; Point(2) = {0, w/2, -h/2};
Line(1) = {1, 2}; Transfinite Curve {1} = %(across)d + 1;
a[] = Extrude {0, 0, h} { Line{1}; Layers{%(across)d}; Recombine; };
b[] = Extrude {%(length)r, 0, 0} { Surface{a[1]}; Layers{%(along)d}; Recombine; };
Physical Volume("all") = {b[1]};
"""


def flexible(draw: Draw, folder: Path) -> tuple[float, ...]:
    """A driven pendulum of one or two bars, built by FEniCSx, as beams: the worst signal.

    The truth has solids with 20 vibrations and the shapes under loads at their tips, geometric
    stiffening and rtol = 1e-8: mesh, section, modes, stiffening, integrator and theory differ.
    """
    from samples.fidelity_samples import pendulum

    from plymotion.solver.inputs.case.load import load_case
    from plymotion.solver.inputs.case.write import write_case
    from plymotion.solver.run.execution import read_run

    links, elements = int(draw.integers(1, 3)), int(draw.integers(2, 9))
    length, width = 10.0 ** draw.uniform(-1.0, 0.0), 10.0 ** draw.uniform(-1.5, -0.8)
    size = {"width": float(length * width), "height": float(length * width * draw.uniform(0.3, 1))}
    metal = bool(draw.integers(2))
    material = METAL if metal else CARBON
    described: dict[str, Any] = {"format": 1, "title": "drawn"}
    described |= {"materials": {"m": material}, "regions": {"all": {"material": "m"}}}
    section = {**described, "convention": "contour", "mesh": {"shape": "rectangle", **size}}
    section["mesh"]["density"] = float(draw.uniform(0.3, 1.0))
    axes = {} if metal else {"axis": [1.0, 0.0, 0.0], "normal": [0.0, 0.0, 1.0]}
    solid = {**described, "regions": {"all": {"material": "m", **axes}}}
    solid["mesh"] = {"file": "true.geo", "unit": "m"}
    if not metal:
        ply = {"material": "m", "angles_deg": [0], "ply_thickness": size["height"]}
        section |= {"laminates": {"along": ply}, "regions": {"all": {"laminate": "along"}}}
    modes: list[dict[str, Any]] = [{"kind": "bending-xy", "count": int(draw.integers(1, 5))}]
    modes[0]["count"] = min(modes[0]["count"], elements)
    if draw.integers(2):
        modes.append({"kind": "attachment", "at": "tip", "directions": ["x", "y"]})
    # in units of the first period of the clamped bar, about
    speed = math.sqrt(7e10 / 2700 if metal else 1.42e11 / 1600)
    period = 6.2 * length**2 / size["width"] / speed * links
    t_end = float(period * draw.uniform(1.0, 4.0))
    solver = {
        "t_end": t_end, "output_step": t_end / 200.0, "rtol": float(10.0 ** draw.uniform(-7, -3)),
        "geometric_stiffening": bool(draw.integers(2)), "error_bars": True,
        "start": str(draw.choice(["positions", "quasi-static"])),
    }  # fmt: skip
    beam: dict[str, Any] = {"kind": "beam", "section": "bar", "elements": elements}
    beam |= {"modes": modes, "length": length}
    beam["interfaces"] = {"root": {"at": "start"}, "tip": {"at": "end"}}
    every = [{"kind": "lowest", "count": 20}]
    every += [{"kind": "attachment", "at": "tip", "directions": ["x", "y", "rz"]}]
    ends = {name: {"plane": {"point": [x, 0.0, 0.0], "normal": [n, 0.0, 0.0]}}
            for name, x, n in (("root", 0.0, -1.0), ("tip", length, 1.0))}  # fmt: skip
    part = {"kind": "solid", "solid": "true.toml", "modes": every, "second_order": True}
    exact = {"rtol": 1e-8, "geometric_stiffening": True, "error_bars": False}
    across = 3
    along = max(12, round(across * length / size["width"]))
    sizes = {**size, "length": length, "across": across, "along": along}
    (folder / "true.geo").write_text(SOLID % sizes, encoding="utf-8")
    case = pendulum(links=links, speed=float(draw.uniform(0.5, 3.0)) / t_end, t_end=t_end)
    for key in ("fidelity", "materials", "sections", "masses"):
        del case[key]
    case |= {"format": 1, "title": "drawn"}
    of_solid = {**part, "interfaces": ends}
    for name, body, file, keys in (
        ("stated", beam, section, dict[str, Any]()), ("true", of_solid, solid, exact),
    ):  # fmt: skip
        table = {**case, "solver": {**solver, **keys}, "runs": {name: {}}}
        held = {"reference": {"kind": "clamped", "at": "root"}}
        table["bodies"] = {
            f"link{k}": {**body, **held, "position": [k * length, 0.0, 0.0]} for k in range(links)
        }
        if name == "stated":
            table["sections"] = {"bar": {"file": "stated.toml"}}
        (folder / f"{name}.toml").write_text(toml(file), encoding="utf-8")
        (folder / f"{name}.case.toml").write_text(toml(table), encoding="utf-8")
        write_case(load_case(folder / f"{name}.case.toml"), folder / name, None)
    files = [folder / name / "runs" / f"{name}.json" for name in ("stated", "true")]
    command = [sys.executable, "-m", "plymotion", "packages", *map(str, files), "--quiet"]
    subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)
    run, true = map(read_run, files)
    return worst_signal(run, {s.name: np.ravel(s.values) for s in silent(true)[0].signals})


def worst_signal(run: "RunSpec", exact: dict[str, Any], size: float = 0.0) -> tuple[float, float]:
    """Bar and error, over `size` or the largest value, of the signal whose error fills it most."""
    from plymotion.solver.run.error_bars import with_error_bars

    result, summary = silent(run)
    with_error_bars(summary, run, result, silent)
    found = [(math.nan, math.nan)]
    for signal in result.signals:
        bar, true = summary["signals"][signal.name]["error_bar"], exact[signal.name]
        if bar is not None:
            scale = size or float(np.abs(true).max())
            error = float(np.abs(np.ravel(signal.values) - true).max())
            found.append((max(bar, 1e-16) / scale, error / scale))
    return max(found[1:] or found, key=lambda pair: pair[1] / pair[0])


def silent(run: "RunSpec") -> Any:
    """Result and summary of a run."""
    from plymotion.solver.run.execution import execute

    return execute(run, progress=False)


CLAIMS = {
    "sections: estimate of K": section,
    "planned runs": planned,
    "runs of rigid bodies: error_bars": rigid,
    "runs of flexible bodies: error_bars": flexible,
}
TOLERANCE = "runs: rtol alone"


def judge(k: int, folder: Path) -> list[float]:
    """Bar, error and more of draw k, and the CPU seconds that it took."""
    own, begin = folder / str(k), times()
    own.mkdir(exist_ok=True)
    found = list(CLAIMS.values())[k % len(CLAIMS)](np.random.default_rng([SEED, k]), own)
    return [*found, sum(times()[:4]) - sum(begin[:4])]


def measured(count: int, lanes: int) -> dict[str, Any]:
    """Coverage, median width and the table, over `count` scenes in all, `lanes` at a time."""
    folder = BUILD / "drawn"
    folder.mkdir(parents=True, exist_ok=True)
    found: list[Judged] = []
    spent: dict[str, float] = {}
    # what was drawn before with the same sources is read again
    kept = folder / f"timed-{sources_sha256('solver', 'preprocess')[:16]}.jsonl"
    lines = kept.read_text(encoding="utf-8").splitlines() if kept.exists() else []
    before = {row[0]: row[1:] for row in map(json.loads, lines)}
    with ProcessPoolExecutor(lanes, get_context("spawn")) as pool:
        jobs = {pool.submit(judge, k, folder): k for k in range(count) if k not in before}
        for job in tqdm(as_completed(jobs), total=len(jobs), unit="draw", desc="error bars"):
            before[jobs[job]] = job.result()
            with kept.open("a", encoding="utf-8") as stream:
                stream.write(json.dumps([jobs[job], *job.result()]) + "\n")
    for k in range(count):
        name = list(CLAIMS)[k % len(CLAIMS)]
        bar, error, *rtol, seconds = before[k]
        spent[name] = spent.get(name, 0.0) + seconds
        unseen = k // len(CLAIMS) % 2 == 1
        found.append(Judged(name, unseen, bar, error))
        if rtol:
            found.append(Judged(TOLERANCE, unseen, rtol[0], error))
    rows = []
    stated = [j for j in found if j.claim != TOLERANCE]
    for name in [*CLAIMS, "all", TOLERANCE]:
        for unseen in (False, True):
            chosen = stated if name == "all" else [j for j in found if j.claim == name]
            own = [j for j in chosen if j.unseen == unseen]
            rows.append([name, "never used" if unseen else "may tune", *cells(own)])
    judged = [j for j in stated if j.unseen and not math.isnan(j.bar)]
    return {
        "coverage": sum(j.error <= j.bar for j in judged) / max(len(judged), 1),
        "bar_over_error_median": float(np.median([j.bar / max(j.error, 1e-16) for j in judged])),
        "draws": [vars(j) for j in found],
        "draws_cpu_s": spent,
        "error_bars": table(
            ["claim", "draws", "number", "inside", "median bar / error", "worst error / bar"], rows
        ),
    }


def cells(own: list[Judged]) -> list[str]:
    """Number, share inside, median width, worst."""
    known = [j for j in own if not math.isnan(j.bar)]
    if not known:
        return [str(len(own)), "–", "–", "–"]
    inside = sum(j.error <= j.bar for j in known) / len(known)
    width = float(np.median([j.bar / max(j.error, 1e-16) for j in known]))
    worst = max(j.error / j.bar for j in known)
    none = len(own) - len(known)
    number = str(len(own)) + (f" ({none} without a bar)" if none else "")
    return [number, f"{inside:.0%}", f"{width:.2g}", f"{worst:.2g}"]
