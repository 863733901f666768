"""What a run leaves: histories, signals, checks and warnings from its solution."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..checks import findings
from ..checks.stiffening import stiffening_findings
from ..dynamics.freedom import degrees_of_freedom
from ..dynamics.model import Model
from ..integrators.generic import Solution
from ..math.arrays import Array
from ..mechanism import BuiltMechanism
from ..monitors.energy import JUMP_CODE
from ..monitors.spin import SPIN_CODE, SpinMonitor
from ..package import ModalPackage
from ..results import BodyGeometry, RunResult, Signal, signal_summary
from ..signals import Recording, Sensor, reactions, recover
from ..strength import beam_bodies as ply_stress
from ..strength import shell_bodies as shell_stress

VTK_LINE = 3
BALANCED_TIMES = 101  # at most, at which reactions are held against momenta


@dataclass(frozen=True)
class RunSpec:
    """A run as `check` wrote it, with its packages read."""

    case: str
    run: str
    mechanism: dict[str, Any]
    packages: dict[str, ModalPackage]


def collect(
    spec: RunSpec,
    built: BuiltMechanism,
    sensors: dict[str, Sensor],
    monitor: SpinMonitor,
    solution: Solution,
    solve_s: float,
    notes: Sequence[findings.Finding] = (),
) -> tuple[RunResult, dict[str, Any]]:
    """Recover everything of interest from the solution; `notes` are what the run noticed."""
    model, t, y = built.model, solution.t, solution.y
    past = recover.history(model, t, y)
    recording = Recording(model, t, y)
    found_signals = tuple(
        Signal(name, sensor.unit, sensor.description, sensor.values(recording))
        for name, sensor in sensors.items()
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
        "energy_drift_relative": float(np.abs(result.relative_balance).max()),
        "drive_work": float(past.energies["drive_work"][-1]),
        "momentum_balance": _momentum_balance(model, t, y),
        "degrees_of_freedom": degrees_of_freedom(model, y[0]),
        "modes_used": {n: p.n_mode for n, p in spec.packages.items()},
    }
    completed = solution.status == "finished"
    warnings = [findings.finding(SPIN_CODE, m) for m in monitor.warnings.values()]
    if not completed and solution.code != SPIN_CODE:
        warnings.append(findings.finding(f"run-{solution.status}", solution.message))
    if checks["degrees_of_freedom"] == 0:
        notes = [note for note in notes if note["code"] != JUMP_CODE]
    warnings += [*notes, *findings.of_checks(checks), *findings.of_motion(built, y)]
    warnings += stiffening_findings(built, spec.mechanism, t, y)
    for name, package in spec.packages.items():
        for item in package.provenance.get("warnings", []):
            warnings.append(findings.finding(item["code"], f"{name}: {item['message']}"))
    strength = _strength(built, t, y)
    for name, found in strength.items():
        if found.governing.ratio < 1.0:
            text = ply_stress.failure_text(name, found.governing)
            warnings.append(findings.finding("ply-failure", text))
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
        "strength": {name: ply_stress.summary(found) for name, found in strength.items()},
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


def _momentum_balance(model: Model, t: Array, y: Array) -> float:
    """Return the relative error of loads and reactions against the change of momentum."""
    some = np.unique(np.linspace(0, t.size - 1, BALANCED_TIMES).astype(int))
    balance = reactions.momentum_balance(model, t[some], y[some])
    return max(balance.linear, balance.angular)


def _strength(built: BuiltMechanism, t: Array, y: Array) -> dict[str, ply_stress.BodyStrength]:
    """Return the strength of every body whose package can tell."""
    found = {}
    for i, name in enumerate(built.body_names):
        package = built.packages.get(name)
        if package is None:
            continue
        _, _, q = recover.body_frames(built.model, i, y)
        strength = ply_stress.body_strength(package, t, q)
        if strength is None:
            strength = shell_stress.shell_strength(package, t, q)
        if strength is not None:
            found[name] = strength
    return found


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
                np.full(len(spokes), VTK_LINE, dtype=np.int64),
            )
        bodies.append(body)
        points.append(recover.node_positions(built.model, i, y, nodes, shapes))
    return tuple(bodies), np.concatenate(points, axis=1)
