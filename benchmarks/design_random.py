"""Optimum of a study, and random designs, for benchmarks/design.py; both can go on."""

import shutil
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from plymotion.solver.math.arrays import Array
from plymotion.solver.studies.design.starts import Known, opened
from plymotion.solver.studies.design.study import optimise
from plymotion.solver.studies.design.study_state import Memory
from plymotion.solver.studies.design.trials import StudySpec, Trials
from plymotion.solver.workers.executors import Local, Task, distribute

RANDOM, AT_ONCE, VIOLATED = 2000, 40, 1e-3


class _Designs:
    """The source of an executor: random designs, some for each task."""

    def __init__(self, given: StudySpec, key: str, points: Array) -> None:
        parts = np.split(points, range(AT_ONCE, len(points), AT_ONCE))
        self._tasks = [Task(computed, (given, key, part)) for part in parts][::-1]
        self._best, self._count = np.inf, 0

    def next(self, lane: int, width: int) -> Task | None:
        return self._tasks.pop() if self._tasks else None

    def took(self, task: Task, result: list[float]) -> None:
        self._count += len(result)
        self._best = min(self._best, *result)
        print(f"{self._count} random designs, best {self._best:.9g}", flush=True)

    def lost(self, task: Task) -> None:
        self._tasks.append(task)


def computed(given: StudySpec, key: str, points: Array) -> list[float]:
    """Return objectives of designs, infinite beyond limits; what is known is not computed again."""
    trials, _, memory = opened(given, key)
    known, limits = Known(trials, memory), limits_of(given)
    found = [known.values(p).shown for p in points]
    return [
        shown[0] if shown and _violation(limits, shown[1:]) <= VIOLATED else np.inf
        for shown in found
    ]


def against_random(case: Path, folder: Path, table: dict[str, Any]) -> dict[str, Any]:
    """Return how good the optimum of a study is; the folder has its state until it is complete."""
    given = StudySpec(table, case, False, "tip", folder)
    found = starts(given)
    spec = replace(given, folder=folder / "random")
    trials = Trials(spec)
    low, high = np.array([p.range() for p in trials.study.parameters.values()]).T
    points = np.random.default_rng(36).uniform(low, high, (RANDOM, low.size))
    begin, memory = time.perf_counter(), Memory(spec.folder / "study.jsonl", trials.digest())
    distribute(Local(2), _Designs(spec, memory.key, points))
    values = np.array(computed(spec, memory.key, points))
    values = values[np.isfinite(values)]
    shutil.rmtree(folder)
    return {
        **found,
        "random": RANDOM,
        "random_within_limits": len(values),
        "random_best_median_mm": [1e3 * float(f(values)) for f in (np.min, np.median)],
        "random_s": time.perf_counter() - begin,
    }


def starts(given: StudySpec) -> dict[str, Any]:
    """Return the optimum of a study, what its limits are, and how many starts found it."""
    begin = time.perf_counter()
    found = optimise(given, lambda: Local(2), show=True)
    best, merits = found["optimum"], [s["best"]["shown"][0] for s in found["starts"] if s["best"]]
    limits = limits_of(given)
    return {
        "optimum_mm": 1e3 * best["shown"][0],
        "limits": best["shown"][1:],
        "violation_before_and_after_verification": [
            _violation(limits, found[each]["shown"][1:])
            for each in ("optimum", "verified")
            if limits
        ],
        "starts": len(merits),
        "starts_within_1e-3": sum(m < 1.001 * best["shown"][0] for m in merits),
        "designs_of_the_study": sum(len(start["history"]) for start in found["starts"]),
        "computed_by_this_command": sum(start["computed"] for start in found["starts"]),
        "study_s_two_processes": time.perf_counter() - begin,
    }


def limits_of(given: StudySpec) -> list[dict[str, Any]]:
    """Return the limits of the study."""
    return given.table["design"]["studies"]["tip"].get("subject_to", [])


def _violation(limits: list[dict[str, Any]], shown: list[float]) -> float:
    """Return the largest relative violation of limits by what is shown of a design."""
    beyond = (
        1.0 - value / limit["min"] if "min" in limit else value / limit["max"] - 1.0
        for limit, value in zip(limits, shown, strict=True)
    )
    return max(0.0, *beyond, 0.0)
