"""Error bars of signals: their differences from a second run that is coarser in everything.

The second run has LOOSER times the tolerance, a third fewer vibrations of each kind in each body,
geometric stiffening whether the run has it or not, and bodies that are stiffer: by the errors of
mesh and section that their packages state, and by the held ends of beams, which beam theory
neglects. docs/accuracy.md has bars beside true errors.
"""

import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ..errors import InputError
from ..inputs.case.record import has_reaction
from ..math.arrays import Array
from ..math.rows import spans
from ..package import ModalPackage
from ..results import RunResult, Signal, Summary
from ..results.codes import LOADED_START
from .inputs import RunSpec

# Thresholds are those of the scenes drawn at random in benchmarks/arena/coverage.py (adr/0077).
LOOSER = 5.0  # tolerance of the second run over that of the run
# Runs of few steps have the same steps with both tolerances: the second run has a tighter one.
FEW_STEPS, TIGHTER = 100, 25.0
# Of the vibrations of a kind, rounded up. The displacement of a beam under a force has an error of
# n^-3 with n vibrations; that of two thirds of them is 3.4 times as large.
FEWER = 1.0 / 3.0
# Where no mode would be left: part of its displacement that others would add, the sum of n^-4.
LONE = 0.1
# The error is the difference where the second run does not have it, as that of stiffening; what
# no vibration of the run contains adds to it. Of rigid bodies with five times the tolerance it is
# about a quarter.
SAFETY, SAFETY_RIGID = 2.0, 0.75

# Integrates a run and returns its result and summary.
Execute = Callable[[RunSpec], tuple[RunResult, Summary]]


def with_error_bars(summary: Summary, spec: RunSpec, result: RunResult, execute: Execute) -> None:
    """Add `error_bar` to the signals of the summary of a finished run, and the entry `error_bars`.

    Parameters
    ----------
    summary : of the run; it is changed in place
    spec : the run
    result : of the run: its output times and signals
    execute : integrates the coarser run
    """
    codes = [finding["code"] for finding in summary["warnings"]]
    steps = summary["cost"]["steps"]
    bars, entry = error_bars(spec, result.t, result.signals, steps, codes, execute)
    for name, bar in bars.items():
        summary["signals"][name]["error_bar"] = bar
    summary["error_bars"] = entry


def error_bars(
    spec: RunSpec,
    t: Array,
    signals: Sequence[Signal],
    steps: int,
    codes: Sequence[str],
    execute: Execute,
) -> tuple[dict[str, float | None], dict[str, object]]:
    """Return the error bars of a finished run by signal, and what is known of them.

    A bar is the largest difference over all output times, in the unit of the signal, times a factor
    of safety. It is None, with a `reason`, where the second run does not end as the first one did,
    and for reactions in runs that begin with sudden loads, which no number of modes gives.

    Parameters
    ----------
    spec : the run
    t : (n_t,) output times of the run [s]
    signals : of the run at these times
    steps : of the integrator in the run; few of them ask for a tighter second run
    codes : of the findings of the run (results/codes.py)
    execute : integrates the coarser run; its InputError becomes the `reason`
    """
    begin, reason, known = time.process_time(), "", {}
    few = steps < FEW_STEPS
    safety = SAFETY if few or spec.packages else SAFETY_RIGID
    try:
        rough, other = execute(coarser(spec, 1.0 / TIGHTER if few else LOOSER))
        if np.array_equal(rough.t, t):
            known = {signal.name: signal for signal in rough.signals}
        else:
            reason = f"the coarser run ended early: {other['message']}"
    except InputError as error:
        reason = f"the coarser run: {error}"
    unknown = []
    if LOADED_START.name in codes:
        tables = spec.mechanism.signals
        unknown = [name for name in tables if has_reaction(name, tables)]
    bars = {
        one.name: safety * largest_difference(one, known[one.name])
        if known and one.name not in unknown
        else None
        for one in signals
    }
    sudden = [f"{name}, because loads begin suddenly" for name in unknown]
    return bars, {
        "not_contained": [*not_contained(spec), *sudden],
        "reason": reason,
        "cpu_s": time.process_time() - begin,
    }


def largest_difference(one: Signal, other: Signal) -> float:
    """Return the largest difference of two signals of equal times; NaN if only one is NaN.

    Where both are infinite, as strength ratios without stress, or NaN, they do not differ.
    """
    largest = 0.0
    for first, end in spans(len(one.values), 1):
        a, b = np.asarray(one.values[first:end]), np.asarray(other.values[first:end])
        differ = (a != b) & ~(np.isnan(a) & np.isnan(b))
        gap = np.abs(np.subtract(a, b, where=differ, out=np.zeros(a.size)))
        largest = float(np.maximum(largest, gap.max(initial=0.0)))  # keeps NaN
    return largest


def coarser(spec: RunSpec, factor: float) -> RunSpec:
    """Return the run that error bars compare with, with `factor` times the tolerances."""
    solver = spec.mechanism.solver
    changes: dict[str, object] = {"solver.rtol": min(factor * solver.rtol, 0.1)}
    for key in ("atol_position", "atol_velocity"):
        if (value := getattr(solver, key)) is not None:
            changes[f"solver.{key}"] = factor * value
    if any(package.second_order is not None for package in spec.packages.values()):
        changes["solver.geometric_stiffening"] = True
    packages = {name: _stiffer(package) for name, package in spec.packages.items()}
    for name, package in spec.packages.items():
        if (tables := _requests(spec, name)) is not None:
            left = [table for table in map(_fewer, tables) if table.get("count") != 0]
            if left:
                changes[f"bodies.{name}.reduced"] = left
            else:
                own = packages[name]
                packages[name] = replace(own, stiffness=own.stiffness + LONE * package.stiffness)
    return replace(spec.changed(changes), run=f"{spec.run}, error bars", packages=packages)


def _stiffer(package: ModalPackage) -> ModalPackage:
    """Return a body that is stiffer by its errors.

    Too few modes are too stiff as well: errors do not cancel in the difference of the runs.
    """
    errors = package.stiffness_error, held_ends(package)
    return replace(package, stiffness=package.stiffness + sum(e for e in errors if e is not None))


# Saint-Venant's warping of F1, M2, M3 lies in the section, that of F2, F3, M1 along the beam: seen
# from the other end, one of the two has the other sign.
OTHER_END = np.array([1.0, -1.0, -1.0, -1.0, 1.0, 1.0])


def held_ends(package: ModalPackage) -> Array | None:
    """Return the modal stiffness that a uniform beam gains where its end sections are held, (m, m).

    A beam whose end sections are held as rigid faces has F' S F / 2 less energy at each, with the
    resultants F there and S of the section (docs/format.md, end_compliance). Interfaces between the
    ends are left out. None without the data: not a uniform beam with an analysed section.
    """
    if package.recovery is None or len(package.sections) != 1:
        return None
    S, F = package.sections[0].end_compliance, package.recovery.resultants_E
    if S is None:
        return None
    ends = F[0], OTHER_END[:, None] * F[-1]
    return np.asarray(sum(end.T @ S @ end for end in ends))


def not_contained(spec: RunSpec) -> list[str]:
    """Return what the error bars of a run do not contain."""
    packages = {name: package for name, package in spec.packages.items() if package.n_mode}
    missing = ["theory of beams and shells apart from held ends"] if packages else []
    unknown = [name for name, package in packages.items() if package.stiffness_error is None]
    missing += [f"mesh and section of {' and '.join(unknown)}"] if unknown else []
    linear = [name for name, package in packages.items() if package.second_order is None]
    missing += [f"geometric stiffening of {' and '.join(linear)}"] if linear else []
    unknown = [name for name in packages if _requests(spec, name) is None]
    return [*missing, *(f"modes of {name}" for name in unknown)]


def _requests(spec: RunSpec, name: str) -> list[Any] | None:
    """Return the modes that the case asks for; None of bodies whose packages it only names."""
    body: Any = spec.mechanism.bodies[name]
    if body.rigid:
        return None
    tables = body.reduced or getattr(body, "modes", None)
    return None if tables is None else list(tables)


def _fewer(table: Any) -> dict[str, object]:
    count = getattr(table, "count", 0)
    return vars(table) | ({"count": count - int(np.ceil(FEWER * count))} if count else {})
