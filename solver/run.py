"""One run: packages, model, consistent start, integration, results."""

import json
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from tqdm import tqdm

from . import findings, recover, signals
from .errors import InputError
from .initial import consistent_state
from .integrate import Integrator, Solution, StopRequest, integrate, new_integrator
from .mechanism import BuiltMechanism, build
from .model import Model
from .monitor import SPIN_CODE, SpinMonitor
from .package import ModalPackage, PackageError
from .package.io import read_package
from .package.schema import Array
from .results import (
    BodyGeometry,
    RunResult,
    Signal,
    signal_summary,
    write_result,
    write_summary,
)
from .system import derivative

INCOMPLETE = 3  # exit code of a run that ended early with a result


@dataclass(frozen=True)
class RunSpec:
    """A run as `check` wrote it, with its packages read."""

    case: str
    run: str
    mechanism: dict[str, Any]
    packages: dict[str, ModalPackage]


def read_run(file: Path) -> RunSpec:
    """Read build/<case>/runs/<run>.json and the packages that it names.

    Raises
    ------
    InputError, PackageError
        Not a run file; a package that cannot be read or was built from other inputs.
    """
    try:
        table = json.loads(file.read_text(encoding="utf-8"))
        case, run, mechanism = table["case"], table["run"], table["mechanism"]
        entries = table["packages"]
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise InputError(
            f"{file}: not a run file ({error}); expected one written by "
            "`python -m plymotion.solver check`"
        ) from error
    packages = {}
    for body, entry in entries.items():
        path = (file.parent.parent / entry["file"]).resolve()
        shown = path.relative_to(Path.cwd()) if path.is_relative_to(Path.cwd()) else path
        package = read_package(shown)
        expected = entry.get("inputs_sha256")
        found = package.provenance.get("inputs_sha256")
        if expected is not None and found != expected:
            raise PackageError(
                f"{shown}: built from other inputs than bodies.{body} of case {case}, run {run} "
                f"(inputs {str(found)[:12]}, expected {expected[:12]}): run `make {case}`"
            )
        packages[body] = package
    return RunSpec(case, run, mechanism, packages)


def output_times(t_end: float, step: float) -> Array:
    """Return 0, step, 2 step, ..., t_end, (k,) [s]; the last interval may be shorter."""
    count = int(np.floor(t_end / step * (1 + 1e-12)))
    times = np.linspace(0.0, count * step, count + 1)
    if t_end - times[-1] > 1e-9 * t_end:
        times = np.append(times, t_end)
    times[-1] = t_end
    return times


def tolerances(model: Model, solver: dict[str, Any]) -> Array:
    """Return absolute tolerances (n,) of positions, velocities and the work."""
    atol = np.full(model.n_pos + model.n_vel + 1, float(solver["atol_velocity"]))
    atol[: model.n_pos] = solver["atol_position"]
    return atol


def make_integrator(model: Model, y0: Array, solver: dict[str, Any]) -> Integrator:
    """Return the integrator that the case asks for, ready to step from t = 0."""
    options: dict[str, Any] = {
        "rtol": solver["rtol"],
        "atol": tolerances(model, solver),
        "block_starts": [0, model.n_pos, model.n_pos + model.n_vel],
    }
    if solver["max_step"] is not None:
        options["max_step"] = solver["max_step"]
    if solver["integrator"] == "gear":
        options["max_order"] = solver["max_order"]
    return new_integrator(
        solver["integrator"],
        lambda t, y: derivative(model, t, y),
        0.0,
        y0,
        solver["t_end"],
        **options,
    )


class _Progress:
    """Show simulated time and pass each step on to the monitor."""

    def __init__(self, monitor: SpinMonitor, t_end: float, label: str, show: bool) -> None:
        self.monitor = monitor
        self.bar = tqdm(
            total=t_end,
            desc=label,
            unit="s",
            disable=None if show else True,
            bar_format="{desc}: {percentage:3.0f}% |{bar}| {n:.3f}/{total:.3f} s [{elapsed}]",
            leave=False,
            mininterval=0.2,
        )

    def __call__(self, integrator: Integrator) -> StopRequest | None:
        self.bar.update(integrator.t - self.bar.n)
        return self.monitor(integrator)


def execute(spec: RunSpec, *, progress: bool = True) -> tuple[RunResult, dict[str, Any]]:
    """Integrate one run; return the result and the summary.

    Raises
    ------
    InputError
        A mechanism that cannot be assembled, redundant constraints.
    """
    begin = time.perf_counter()
    solver = spec.mechanism["solver"]
    built = build(spec.mechanism, spec.packages)
    model = built.model
    y0 = consistent_state(model, built.start, built.joint_names)
    monitor = SpinMonitor(model, built.body_names, stop=solver["on_invalid"] == "stop")
    refused = monitor.at_start(0.0, y0)
    if refused is not None:
        solution = Solution(np.zeros(1), y0[None, :], "stopped", refused, SPIN_CODE)
    else:
        integrator = make_integrator(model, y0, solver)
        follow = _Progress(monitor, solver["t_end"], spec.run, progress)
        times = output_times(solver["t_end"], solver["output_step"])
        solution = integrate(integrator, times, follow)
        follow.bar.close()
    solve_s = time.perf_counter() - begin
    return _collect(spec, built, monitor, solution, solve_s)


def _collect(
    spec: RunSpec,
    built: BuiltMechanism,
    monitor: SpinMonitor,
    solution: Solution,
    solve_s: float,
) -> tuple[RunResult, dict[str, Any]]:
    """Recover everything of interest from the solution."""
    model, t, y = built.model, solution.t, solution.y
    past = recover.history(model, t, y)
    found_signals = tuple(
        Signal(
            name,
            signals.unit(table),
            table["description"],
            signals.evaluate(built, name, table, y),
        )
        for name, table in spec.mechanism["signals"].items()
    )
    geometry, points = _geometry(built, y)
    result = RunResult(
        case=spec.case,
        run=spec.run,
        t=t,
        signals=found_signals,
        q=y[:, : model.n_pos],
        v=y[:, model.n_pos : model.n_pos + model.n_vel],
        multipliers=past.multipliers,
        energies=past.energies,
        bodies=geometry,
        node_positions_G=points,
        violations={
            "position": past.position_violation,
            "rotation": past.rotation_violation,
            "velocity": past.velocity_violation,
        },
    )
    checks: dict[str, Any] = {
        "constraint_position_max": float(past.position_violation.max()),
        "constraint_rotation_max": float(past.rotation_violation.max()),
        "constraint_velocity_max": float(past.velocity_violation.max()),
        "energy_drift_relative": recover.energy_drift(past.energies),
        "drive_work": float(past.energies["drive_work"][-1]),
        "modes_used": {n: p.n_mode for n, p in spec.packages.items()},
    }
    completed = solution.status == "finished"
    warnings = [findings.finding(SPIN_CODE, m) for m in monitor.warnings.values()]
    if not completed and solution.code != SPIN_CODE:
        warnings.append(findings.finding(f"run-{solution.status}", solution.message))
    warnings += findings.of_checks(checks) + findings.of_motion(built, y)
    for name, package in spec.packages.items():
        for item in package.provenance.get("warnings", []):
            warnings.append(findings.finding(item["code"], f"{name}: {item['message']}"))
    counters = solution.counters
    summary = {
        "case": spec.case,
        "run": spec.run,
        "completed": completed,
        "status": solution.status,
        "message": solution.message,
        "t_end": float(t[-1]),
        "signals": {s.name: signal_summary(s, t) for s in found_signals},
        "checks": checks,
        "cost": {
            "preprocess_s": sum(
                float(sum(p.provenance.get("seconds", {}).values())) for p in spec.packages.values()
            ),
            "solve_s": solve_s,
            "steps": counters.steps,
            "rejected": counters.rejected,
            "evaluations": counters.evaluations,
            "jacobians": counters.jacobians,
            "factorisations": counters.factorisations,
            "integrator": spec.mechanism["solver"]["integrator"],
        },
        "hints": list(solution.hints),
        "warnings": warnings,
    }
    return result, summary


def _geometry(built: BuiltMechanism, y: Array) -> tuple[tuple[BodyGeometry, ...], Array]:
    """Return the drawn shape of every body and its global points (k, n, 3)."""
    bodies, points = [], []
    for i, name in enumerate(built.body_names):
        package = built.packages.get(name)
        if package is not None:
            nodes, shapes = package.nodes_B, package.shapes_B[:, :, :3]
            body = BodyGeometry(
                name, nodes, package.connectivity, package.offsets, package.cell_types
            )
        else:
            ends = [p.position_B for _, (b, p) in built.places.items() if b == i]
            nodes = np.array([np.zeros(3), *ends])
            shapes = np.zeros((0, nodes.shape[0], 3))
            spokes = np.array([(0, k) for k in range(1, len(nodes))], dtype=np.int64)
            body = BodyGeometry(
                name,
                nodes,
                spokes.reshape(-1),
                np.arange(len(spokes) + 1, dtype=np.int64) * 2,
                np.full(len(spokes), 3, dtype=np.int64),
            )
        bodies.append(body)
        points.append(recover.node_positions(built.model, i, y, nodes, shapes))
    return tuple(bodies), np.concatenate(points, axis=1)


def run_file(file: Path, out: Path, *, progress: bool = True) -> dict[str, Any]:
    """Execute a run file and write result.vtkhdf and summary.json into `out`."""
    result, summary = execute(read_run(file), progress=progress)
    out.mkdir(parents=True, exist_ok=True)
    write_result(out / "result.vtkhdf", result)
    # Last, because make takes it as the sign of a finished run.
    write_summary(out / "summary.json", summary)
    return summary
