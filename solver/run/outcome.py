"""Results of a run from its solution: histories, signals, checks, warnings, summary."""

import os
import platform
import shlex
import sys
from collections import defaultdict
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cache
from importlib.util import find_spec
from pathlib import Path

import numpy as np

from plymotion import __version__

from ..checks.finished_run import FinishedRun, Past
from ..checks.judge import judge
from ..checks.modes import loaded_damping
from ..checks.statics import unjudged_hints
from ..dynamics.analysis import recovery as recover
from ..math.arrays import Array
from ..math.compiled import installed_version
from ..math.rows import IN_MEMORY, LongRows, RowKeeper, columns, temporary_file
from ..mechanism.built_mechanism import BuiltMechanism
from ..package import ModalPackage
from ..results import BodyGeometry, RunResult, Signal, Summary, signal_summary
from ..results.codes import FEEDBACK
from ..results.surfaces import MOST_STORED, all_positions
from ..signals import Sensor, fatigue_entry, recorded
from ..strength.fatigue import Turning
from ..strength.strength_summary import summary as strength_entry
from .drawing import drawn_loads, links, pictures, point_masses, with_views
from .inputs import RunSpec

VTK_LINE = 3
MOST_IN_MEMORY = 10 * IN_MEMORY  # bytes of reactions and signals


def collect(
    spec: RunSpec,
    sensors: dict[str, Sensor],
    finished: FinishedRun,
    solve_s: float,
    folder: Path | None = None,
    progress: Callable[[float], None] = lambda _: None,
) -> tuple[RunResult, Summary]:
    """Recover everything of interest from a finished run, and judge it.

    What has a row for every output time is computed block by block. Of a run whose states are
    in a file (integrators/generic/drive.py), or with many signals, it is kept in a file as well,
    in `folder`. `progress` gets the part of the work that is done.

    Parameters
    ----------
    spec : the run
    sensors : sensors by name of the signal
    finished : solution and what was noticed
    solve_s : CPU time of the integration [s]
    folder : folder for rows that do not fit into memory
    progress : function that gets the part of the work that is done, 0 to 1
    """
    model, solution = finished.model, finished.solution
    t, y = solution.t, solution.y
    width = len(sensors) + model.n_constraint
    stored = 8 * width * len(t) > MOST_IN_MEMORY or isinstance(y, LongRows)
    file = temporary_file(folder) if stored else None
    kept: dict[tuple[str, str], RowKeeper] = defaultdict(lambda: RowKeeper(file))
    past = Past(within=finished.in_play)
    turning = {name: Turning() for name, sensor in sensors.items() if sensor.life is not None}
    done = 0.0
    for block, values in recorded(sensors, model, finished.blocks):
        history = recover.history_of(model, block.y, block.along)
        past.take(block.t, history)
        kept["", "multipliers"].append(history.multipliers)
        for name, rows in values:
            if name in turning:
                turning[name].take(rows * sensors[name].scale)
            kept["signals", name].append(rows)
            done += len(block.t) / (len(t) * len(sensors))
            progress(0.5 * min(done, 1.0))
        for group, table in (("energies", history.energies), ("violations", history.violations)):
            for name, rows in table.items():
                kept[group, name].append(rows)
    finished = replace(finished, known=past)
    found_signals = tuple(
        Signal(name, sensor.unit, sensor.description, kept["signals", name].all())
        for name, sensor in sensors.items()
    )
    geometry, points = drawn_shapes(finished.built, y)
    balls = point_masses(finished.mechanism, finished.built)
    geometry = with_views(geometry, finished.built, y, balls, pictures(finished.mechanism))
    progress(0.5)  # where nothing is measured, too: checks of 10,000 bodies take seconds
    multipliers = kept["", "multipliers"].all()
    result = RunResult(
        case=spec.case,
        run=spec.run,
        t=t,
        signals=found_signals,
        q=columns(y, 0, model.n_pos),
        v=columns(y, model.n_pos, model.n_pos + model.n_vel),
        multipliers=multipliers,
        energies={n: rows.all() for (group, n), rows in kept.items() if group == "energies"},
        bodies=geometry,
        node_positions_G=points,
        violations={n: rows.all() for (group, n), rows in kept.items() if group == "violations"},
        links=links(finished.mechanism, finished.built),
        loads=drawn_loads(finished.built, t, y, multipliers),
        provenance=provenance(spec.packages),
    )
    judgement = judge(finished)
    # Remarks on the cost of a run are findings too; `hints` repeats them beside the integrator's.
    hints = [finding.text for finding in judgement.findings if finding.code == FEEDBACK.name]
    counters = solution.counters
    summary: Summary = {
        "case": spec.case,
        "run": spec.run,
        "completed": solution.status == "finished",
        "status": solution.status,
        "message": solution.message,
        "t_end": float(t[-1]),
        "signals": _summaries(found_signals, t, progress),
        "checks": {
            **judgement.numbers,
            "modes_used": {n: p.n_mode for n, p in finished.packages.items()},
        },
        "provenance": result.provenance,
        "strength": {n: strength_entry(strength) for n, strength in judgement.strengths.items()},
        "damping": loaded_damping(finished),
        "fatigue": {name: fatigue_entry(sensors[name], turning[name]) for name in turning},
        "cost": {
            "preprocess_s": sum(
                float(sum(p.provenance.get("seconds", {}).values())) for p in spec.packages.values()
            ),
            "solve_s": solve_s,
            "solve_s_omits": "start of the program, reading, recovery, writing; see seconds",
            "steps": counters.steps,
            "rejected": counters.rejected,
            "evaluations": counters.evaluations,
            "jacobians": counters.jacobians,
            "factorisations": counters.factorisations,
            "integrator": spec.mechanism.solver.integrator,
        },
        "hints": [*solution.hints, *hints, *unjudged_hints(finished)],
        "warnings": [finding.entry() for finding in judgement.findings],
    }
    return result, summary


def _summaries(
    signals: Sequence[Signal], t: Array, progress: Callable[[float], None]
) -> dict[str, dict[str, object]]:
    """Return the summaries of signals by name; `progress` gets the second half of the work."""
    summaries = {}
    for number, signal in enumerate(signals, 1):
        summaries[signal.name] = signal_summary(signal, t)
        progress(0.5 + 0.5 * number / len(signals))
    return summaries


def drawn_shapes(built: BuiltMechanism, y: Array) -> tuple[tuple[BodyGeometry, ...], Array]:
    """Return the drawn shape of every body and its global points (k, n, 3)."""
    bodies, places = [], []
    ends: dict[int, list[Array]] = defaultdict(list)
    for b, p in built.places.values():
        ends[b].append(p.position_B)
    for i, name in enumerate(built.body_names):
        package = built.packages.get(name)
        if package is not None:
            nodes, shapes = package.nodes_B, package.shapes_B[:, :, :3]
            body = BodyGeometry(
                name, nodes, package.connectivity, package.offsets, package.cell_types
            )
        else:
            nodes = np.array([np.zeros(3), *ends[i]])
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
        places.append((int(built.model.pos_start[i]), nodes, shapes))
    return tuple(bodies), all_positions(y, places)


# What a result was computed with: versions, packages and the command.


def provenance(packages: Mapping[str, ModalPackage]) -> dict[str, object]:
    """Return versions, the digest of the inputs of each package, and the command if it started
    the run."""
    table: dict[str, object] = {
        "versions": dict(_versions()),
        "packages": {name: p.provenance.get("inputs_sha256") for name, p in packages.items()},
    }
    name, *words = sys.argv
    if Path(name).stem in ("plymotion", "__main__"):
        table["command"] = shlex.join(["plymotion", *words])
    return table


@cache
def _versions() -> dict[str, str]:
    versions = {
        "plymotion": __version__,
        "python": platform.python_version(),
        "numpy": np.__version__,
    }
    if find_spec("numba"):
        versions["numba"] = installed_version("numba")
    return versions


# Room on the disk that a run will take.

WORTH_A_NOTE = 1_000_000_000  # bytes
RIGID_BODY, PER_BODY = 3, 14  # drawn points; numbers of position and velocity
CONSTRAINTS, OTHERS = 6, 8  # numbers of a joint; of time, energies, violations


def nearest_folder(folder: Path) -> Path:
    """Return a folder, or the one above it that exists."""
    whole = Path(os.path.realpath(folder))  # Path.resolve raises where links form a loop
    return next(each for each in (whole, *whole.parents) if each.is_dir())


def disk_note(spec: RunSpec, folder: Path) -> str:
    """Return a remark on a run whose results, on the disk of `folder`, are large; "" for others."""
    mechanism = spec.mechanism
    times = mechanism.solver.t_end / mechanism.solver.output_step
    bodies = len(mechanism.bodies)
    states = PER_BODY * bodies + 2 * sum(p.n_mode for p in spec.packages.values())
    points = sum(len(p.nodes_B) for p in spec.packages.values())
    points += RIGID_BODY * (bodies - len(spec.packages))
    drawn = 8.0 * times * 3 * points
    if mechanism.solver.node_positions == "auto" and drawn > MOST_STORED:
        drawn = 0.0
    others = CONSTRAINTS * len(mechanism.joints) + OTHERS + len(mechanism.signals)
    results = 8.0 * times * (states + others) + drawn
    passing = 8.0 * times * (states + others)
    if results < WORTH_A_NOTE:
        return ""
    import shutil  # most results need no note

    free = shutil.disk_usage(folder).free
    return (
        f"{times:.3g} output times need up to {_size(results)} in result.vtkhdf, and "
        f"{_size(passing)} while the run lasts ({_size(free)} are free): a larger "
        "solver.output_step needs less"
    )


def _size(count: float) -> str:
    return f"{count / 1e9:.1f} GB"
