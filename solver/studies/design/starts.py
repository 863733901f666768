"""One start of a study: gradient steps, a turn away from a saddle, then the discrete search."""

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, field
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from ...errors import InputError, few
from ...inputs.case.design import CheckedStudy
from ...math.arrays import Array
from .drivers.table import driver_of
from .problem import FEASIBLE, Options, Point, Problem, Values, undominated
from .rules import Space, broken, space_of
from .study_state import FILE, Memory
from .trials import StudySpec, Trials

QUARTER = 90.0  # [deg] a ply turned by it mirrors itself: the gradient by symmetry is zero
SYMMETRIC, FLAT = 0.5, 1e-3  # [deg] from there; scaled derivative that may be such a zero
TURN, TURNS = 3.0, 3  # [deg] out of a saddle; at most so many times
RESTORED = 3  # times that a start which ends beyond its limits goes back to them, at most
EVERY = 256  # designs that follow the rules, up to which all are computed
LISTED = 4096  # combinations of allowed values, up to which the rules are looked at for that


class Known:
    """Designs whose values and slopes are kept in the memory of a study."""

    def __init__(self, trials: Trials, memory: Memory) -> None:
        self.trials, self.memory = trials, memory
        self.computed = 0

    def values(self, p: Array) -> Values:
        """Return the values of a design."""
        stored = self.memory.get("values", p)
        if stored is None:
            stored = asdict(self.trials.values(p))
            self.memory.put("values", p, stored)
            self.computed += 1
        return Values(**stored)

    def slopes(self, p: Array) -> list[list[list[float]]]:
        """Return the slopes of a design. Raises InputError."""
        stored: list[list[list[float]]] | None = self.memory.get("slopes", p)
        if stored is None:
            stored = self.trials.slopes(p)
            self.memory.put("slopes", p, stored)
        return stored


@dataclass
class Start:
    """What became of one start."""

    number: int
    best: Point | None = None
    continuous: Point | None = None  # before the discrete search
    history: list[Point] = field(default_factory=list)
    converged: bool = False
    message: str = ""
    left_saddle: bool = False
    invalid: list[str] = field(default_factory=list)
    front: list[Point] = field(default_factory=list)
    computed: int = 0  # designs that were built and run, not those known before


def first_points(study: CheckedStudy, space: Space) -> Array:
    """Return the free parameters (k, z) at which starts begin: the case, then Sobol points.

    The first half of the points has one share of the bounds for all angles. Stiffnesses are means
    over plies, so that many independent angles all make nearly the same laminate.
    """
    count = study.table.starts
    own = space.z(study.start)[None]
    if count == 1:
        return own
    kinds = [study.parameters[name] for name in space.names]
    named = [k for k, parameter in enumerate(kinds) if parameter.names]
    angles = [k for k, parameter in enumerate(kinds) if parameter.kind == "angle"]
    from scipy.stats import qmc  # here: loading it takes 0.4 s

    sobol = qmc.Sobol(len(space.names), rng=np.random.default_rng(study.table.seed))
    shares = sobol.random_base2(int(np.ceil(np.log2(count - 1))) if count > 2 else 0)[: count - 1]
    shares[: count // 2, angles] = shares[: count // 2, angles[:1]]
    points = np.r_[own, space.lower + shares * (space.upper - space.lower)]
    points[:, named] = np.rint(points[:, named])  # there is nothing between names
    return points


_opened: dict[tuple[Path, str], tuple[Trials, Space, Memory]] = {}


def forget() -> None:
    """Forget the study of this process: the file of its memory may have been begun anew."""
    _opened.clear()


def opened(given: StudySpec, key: str) -> tuple[Trials, Space, Memory]:
    """Return the study of a process, read once."""
    at = given.folder, key
    if at not in _opened:
        _opened.clear()
        trials = Trials(given)
        _opened[at] = trials, space_of(trials.study), Memory(given.folder / FILE, key)
    return _opened[at]


def compute_start(given: StudySpec, key: str, number: int) -> Start:
    """Compute a start, or what is missing of it: a task of an executor.

    Parameters
    ----------
    key : digest of what its numbers depend on, as of its memory
    number : of the start, a row of `first_points`
    """
    trials, space, memory = opened(given, key)
    study = trials.study
    z0 = first_points(study, space)[number]
    known, start = Known(trials, memory), Start(number)
    try:
        search(start, study, lambda z: Problem(known, study.table, trials.measures, space, z), z0)
    except InputError as error:
        start.message = str(error).splitlines()[0]
    start.computed = known.computed
    return start


def search(
    start: Start, study: CheckedStudy, problem_at: Callable[[Array], Problem], z0: Array
) -> None:
    """Go from free parameters to the best design.

    Parameters
    ----------
    start : gets what becomes of it
    problem_at : returns the problem that begins at free parameters (z,)
    z0 : (z,) where it begins

    Raises
    ------
    InputError
        The design at z0 is invalid.
    """
    problem = problem_at(z0)
    _descend(problem, start, study)
    for _ in range(TURNS):
        turned, before = _beside_saddle(problem, study, start.number), start.best
        if turned is None:
            break
        problem = problem_at(turned)
        _descend(problem, start, study)
        start.left_saddle = True
        if start.best is before:
            break
    for _ in range(RESTORED):
        before = start.best
        if before is None or before.violation <= FEASIBLE or study.table.front is not None:
            break
        for restoring in (True, False):  # the nearest design within the limits, then on from there
            z = problem.space.z(np.array((start.best or before).p))
            problem = problem.again(z, problem.space, restoring=restoring)
            _descend(problem, start, study)
        if start.best is before:
            break
    start.continuous = start.best
    if start.best is not None and any(problem.space.allowed):
        _allowed(problem, start, study, start.best)


def _allowed(problem: Problem, start: Start, study: CheckedStudy, best: Point) -> None:
    """Search allowed values, then continuous parameters beside them, in turn while that helps."""
    free = [k for k, values in enumerate(problem.space.allowed) if not values]
    for _ in range(RESTORED):
        start.best = best = _discrete(problem, study, best)
        if not best.shown:
            wrong = few(broken(study, np.array(best.p))) or "values that are not allowed"
            start.best, start.message = None, f"no design near it follows the rules: {wrong}"
            return
        if not free or study.table.front is not None:
            return
        z = problem.space.z(np.array(best.p))
        _descend(problem.again(z[free], problem.space.only(free, z)), start, study)
        if start.best is best:
            return
        best = start.best


def _descend(problem: Problem, start: Start, study: CheckedStudy) -> None:
    table = study.table
    name = "slsqp" if problem.restoring else table.driver
    driver = driver_of(name, f"design.studies.{study.name}")
    ending = driver.minimise(problem, Options(table.iterations, table.tolerance, table.seed))
    start.converged, start.message = ending.converged, ending.message
    start.history += problem.history
    start.front = undominated([*start.front, *problem.front])
    start.invalid += [why for why in problem.invalid if why not in start.invalid]
    if problem.best is not None and problem.best.better_than(start.best):
        start.best = problem.best


def _beside_saddle(problem: Problem, study: CheckedStudy, number: int) -> Array | None:
    """Return a point beside the best one if symmetry may hold the optimiser there; else None.

    At 0 and 90 deg the derivative by an angle is zero if the design mirrors itself, whether it is
    a minimum or not. Angles there whose derivative is zero are turned by a few degrees. One that
    has reached a bound at 90 deg goes on from -90 deg, which is the same ply.
    """
    space, best = problem.space, problem.best
    if best is None:
        return None
    z = space.z(np.array(best.p))
    slopes = [np.array(s) @ space.T for s in problem.designs.slopes(np.array(best.p))]
    random = np.random.default_rng([study.table.seed, number])
    turned = z.copy()
    for k, name in enumerate(space.names):
        if study.parameters[name].kind != "angle":
            continue
        low, high = space.lower[k], space.upper[k]
        flat = all(
            np.abs(s[:, k]).max() * QUARTER <= FLAT * (np.abs(v).max() or 1.0)
            for s, v in zip(slopes, problem.designs.values(np.array(best.p)).values, strict=True)
        )
        away = abs(z[k] - QUARTER * round(z[k] / QUARTER))
        sign = random.choice([-1.0, 1.0])
        whole = high - low >= 2.0 * QUARTER
        if whole and (z[k] >= high - SYMMETRIC or z[k] <= low + SYMMETRIC):
            turned[k] = low + TURN if z[k] > 0.0 else high - TURN
        elif away < SYMMETRIC and flat:
            turned[k] = np.clip(z[k] + sign * TURN * random.uniform(0.5, 1.0), low, high)
    return None if np.array_equal(turned, z) else turned


def _discrete(problem: Problem, study: CheckedStudy, start: Point) -> Point:
    """Return the best design of allowed values near a continuous one.

    If few designs follow the rules, all are computed, because no change of one ply may lead from
    one of them to another. If there are more, each parameter goes to the nearest allowed value.
    Then, layer by layer, its neighbours are computed and the best one is kept; neighbours of the
    opposite angle and exchanges of two layers follow, until nothing is better. Continuous
    parameters keep their values.
    """
    space, seen = problem.space, dict[bytes, Point]()
    z = space.z(np.array(start.p))
    layers = [k for k, values in enumerate(space.allowed) if values]
    for k in layers:
        values = np.array(space.allowed[k])
        z[k] = values[np.abs(values - z[k]).argmin()]

    def point(z: Array) -> Point:
        key = z.tobytes()
        if key not in seen:
            p = space.p(z)
            wrong = _wrong(study, space, p)
            result = problem.designs.values(p) if not wrong else None
            if result is None or result.why:
                seen[key] = Point(p.tolist(), np.inf, 1e3 * (wrong or 1), [])
            else:
                seen[key] = problem.point(p, result)
        return seen[key]

    def improved(candidates: list[Array]) -> bool:
        nonlocal z
        best = min(candidates, key=lambda c: (max(point(c).violation, 1e-4), point(c).merit))
        if point(best).better_than(point(z)):
            z = best
            return True
        return False

    if (every := _every(study, space, z, layers)) is not None:
        improved([z, *every])
        return point(z)
    better = True
    while better:
        better = any([improved(_neighbours(study, space, z, k)) for k in layers])
        better = better or any([improved(_neighbours(study, space, z, k, -1.0)) for k in layers])
        pairs = [(i, j) for i in layers for j in layers if i < j and z[i] != z[j]]
        for i, j in pairs if not better else ():
            better = improved([_exchanged(space, z, i, j)]) or better
    return point(z)


def _every(
    study: CheckedStudy, space: Space, z: Array, layers: Sequence[int]
) -> list[Array] | None:
    """Return all points of allowed values that follow the rules; None if there are many."""
    if np.prod([len(space.allowed[k]) for k in layers], dtype=float) > LISTED:
        return None
    followed = []
    for values in product(*(space.allowed[k] for k in layers)):
        point = z.copy()
        point[layers] = values
        if not _wrong(study, space, space.p(point)):
            followed.append(point)
        if len(followed) > EVERY:
            return None
    return followed


def _neighbours(
    study: CheckedStudy, space: Space, z: Array, k: int, sign: float = 1.0
) -> list[Array]:
    """Return points with the allowed values of one parameter that are next to sign times its own.

    Of a choice all others.
    """
    values = list(space.allowed[k])
    kind, at = study.parameters[space.names[k]].kind, values.index(float(z[k]))
    if sign < 0.0:
        at = int(np.abs(np.array(values) + z[k]).argmin())
    around = kind == "angle" and values[-1] - values[0] + values[1] - values[0] >= 2.0 * QUARTER
    near: Any = {at - 1, at, at + 1}
    if kind == "choice":
        near = set(range(len(values)))
    elif around:
        near = {i % len(values) for i in near}
    neighbours = []
    for i in sorted(i for i in near if 0 <= i < len(values) and values[i] != z[k]):
        neighbours.append(z.copy())
        neighbours[-1][k] = values[i]
    return neighbours or [z]


def _exchanged(space: Space, z: Array, i: int, j: int) -> Array:
    """Return a point with two values exchanged, if both are allowed there."""
    if z[j] not in space.allowed[i] or z[i] not in space.allowed[j]:
        return z
    exchanged = z.copy()
    exchanged[[i, j]] = z[[j, i]]
    return exchanged


def _wrong(study: CheckedStudy, space: Space, p: Array) -> int:
    """Return the number of broken rules and of linked parameters whose values are not allowed."""
    if (stored := space.wrong.get(p.tobytes())) is not None:
        return stored
    count = len(broken(study, p))
    for parameter, value in zip(study.parameters.values(), p, strict=True):
        allowed = parameter.allowed()
        low, high = parameter.range()
        near = 1e-9 * (high - low)
        if allowed and min(abs(v - value) for v in allowed) > near:
            count += 1
        count += not low - near <= value <= high + near
    space.wrong[p.tobytes()] = count
    return count
