"""Rules of lay-ups: parameters that are linked (p = T z + c), linear limits, and discrete checks.

The angles of all plies are linear in the parameters of kind angle. The matrix is found from
specifications of bodies, in which lay-ups are complete however they were written.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ...errors import InputError
from ...inputs.case.bodies.specifications import model_and_check
from ...inputs.case.design import CheckedStudy
from ...inputs.case.tables.design_keys import Rule
from ...math.arrays import Array

CARDINAL = (0.0, 45.0, -45.0, 90.0)  # directions of the rule of shares [deg]
NEAR = 1e-6  # [deg] and of coefficients


@dataclass(frozen=True)
class Layup:
    """The plies of one wall or laminate of a design, in the order of the description."""

    name: str  # BODY.REGION
    angles: Array  # (k,) [deg]
    thicknesses: Array  # (k,) [m]; equal shares if none is given
    materials: tuple[str, ...]


def layups(study: CheckedStudy, p: Array) -> dict[str, Layup]:
    """Return the lay-ups of a design (p,) that differ from each other, by name."""
    layups_by_name: dict[str, Layup] = {}
    known = set()
    for body, spec in model_and_check(study.designs([p]).own.bodies[0])[0].items():
        for name, plies in _plies(spec.content):
            text = repr((body, plies))
            if text not in known:
                known.add(text)
                layups_by_name[f"{body}.{name}"] = Layup(
                    f"{body}.{name}",
                    np.array([float(ply["angle_deg"]) for ply in plies]),
                    np.array([float(ply.get("thickness", 1.0 / len(plies))) for ply in plies]),
                    tuple(str(ply["material"]) for ply in plies),
                )
    return layups_by_name


def _plies(table: Any, name: str = "") -> Iterator[tuple[str, list[Mapping[str, Any]]]]:
    """Yield the lists of plies in a specification with the names of their tables."""
    if isinstance(table, Mapping):
        plies = table.get("plies")
        if isinstance(plies, list) and plies and all("angle_deg" in ply for ply in plies):
            yield name, plies
        for key, value in table.items():
            yield from _plies(value, str(key))
    elif isinstance(table, list):
        for value in table:
            yield from _plies(value, name)


@dataclass(frozen=True)
class Space:
    """The free parameters z of a study, p = T z + c, lower <= z <= upper, A z <= b."""

    names: tuple[str, ...]  # of z
    T: Array  # (p, z)
    c: Array  # (p,)
    lower: Array  # (z,)
    upper: Array
    A: Array  # (l, z)
    b: Array  # (l,)
    allowed: tuple[tuple[float, ...], ...]  # values of the discrete ones of z, in order
    wrong: dict[bytes, int] = field(default_factory=dict)  # of designs p, for all starts

    def p(self, z: Array) -> Array:
        """Return the parameters (p,) of a point."""
        return np.asarray(self.T @ z + self.c)

    def z(self, p: Array) -> Array:
        """Return the point whose parameters are nearest, within the bounds."""
        z = np.linalg.lstsq(self.T, p - self.c, rcond=None)[0]
        return np.asarray(np.clip(z, self.lower, self.upper))

    def only(self, free: Sequence[int], z: Array) -> "Space":
        """Return the space of some of its parameters; the others keep their values of z."""
        kept = z.copy()
        kept[free] = 0.0
        return Space(
            tuple(self.names[k] for k in free),
            self.T[:, free],
            self.p(kept),
            self.lower[free],
            self.upper[free],
            self.A[:, free],
            self.b - self.A @ kept,
            tuple(self.allowed[k] for k in free),
        )


def space_of(study: CheckedStudy) -> Space:
    """Return the free parameters of a study under its rules.

    Raises
    ------
    InputError
        A rule that the parameters cannot follow, named.
    """
    parameters = list(study.parameters.values())
    n, rules = len(parameters), study.table.rules
    equal: list[tuple[Array, float]] = []  # row . p = number
    below: list[tuple[Array, float]] = []
    steps = [r.step for r in rules if isinstance(r, Rule) and r.step is not None]
    if rules:
        _require_fitting(study)
        for name, (J, at_zero) in _angles(study).items():
            if "symmetric" in rules:
                equal += _pairs_equal(J, at_zero, 1.0, enumerate(range(len(J))[::-1]))
            if "balanced" in rules:
                equal += _balanced(name, J, at_zero, half="symmetric" in rules)
            for k in range(len(J) - 1):
                row, off = J[k] - J[k + 1], float(at_zero[k + 1] - at_zero[k])
                if np.abs(row).max() > NEAR:
                    below += [(row, s + off) for s in steps] + [(-row, s - off) for s in steps]
    T, c, free = _solved(equal, n)
    bounds = np.array([q.range() for q in parameters])
    lower, upper = bounds[free, 0], bounds[free, 1]
    for k in sorted(set(range(n)) - set(free)):  # bounds of the linked ones
        below += [(np.eye(n)[k], bounds[k, 1]), (-np.eye(n)[k], -bounds[k, 0])]
    rows = [(row @ T, b - row @ c) for row, b in below]
    kept = []
    for row, b in rows:
        at = np.flatnonzero(np.abs(row) > NEAR)
        if at.size == 1:  # a bound
            k, value = int(at[0]), b / row[at[0]]
            if row[k] > 0:
                upper[k] = min(upper[k], value)
            else:
                lower[k] = max(lower[k], value)
        elif at.size:
            kept.append((row, b))
    if not (lower < upper).all():
        raise InputError(f"design.studies.{study.name}.rules: the bounds leave no design")
    A = np.array([row for row, _ in kept]).reshape(-1, len(free))
    names = list(study.parameters)
    return Space(
        tuple(names[k] for k in free),
        T,
        c,
        lower,
        upper,
        A,
        np.array([b for _, b in kept]),
        tuple(tuple(parameters[k].allowed()) for k in free),
    )


def _require_fitting(study: CheckedStudy) -> None:
    """Raise InputError for rules of discrete lay-ups with continuous angles."""
    for rule in study.table.rules:
        for key in ("share", "equal_plies"):
            if getattr(rule, key, None) is not None:
                for name, parameter in study.parameters.items():
                    if parameter.kind == "angle" and not parameter.allowed():
                        raise InputError(
                            f"design.studies.{study.name}.rules: {key} counts plies of equal "
                            f"angles; expected `set` or `step` of parameter {name}"
                        )


def _angles(study: CheckedStudy) -> dict[str, tuple[Array, Array]]:
    """Return d(angles)/dp (k, p) and angles at p = 0 (k,) of the lay-ups that vary."""
    start = study.start
    base, columns = layups(study, start), []
    for k, parameter in enumerate(study.parameters.values()):
        low, high = parameter.range()
        step = np.zeros(start.size)
        step[k] = (1.0 if start[k] < 0.5 * (low + high) else -1.0) * 0.125 * (high - low)
        moved = layups(study, start + step) if parameter.kind == "angle" else base
        columns.append(
            {n: (moved[n].angles - each.angles) / step[k] for n, each in base.items() if n in moved}
        )
    angles = {}
    for name, each in base.items():
        if all(name in column for column in columns):
            J = np.round(np.stack([column[name] for column in columns], axis=1), 12)
            if np.abs(J).max() > NEAR:
                angles[name] = J, each.angles - J @ start
    return angles


def _pairs_equal(J: Array, at_zero: Array, sign: float, pairs: Any) -> list[tuple[Array, float]]:
    """Return equations of angles that are sign times those of their partners."""
    conditions = []
    for i, j in pairs:
        row, off = J[i] - sign * J[j], float(sign * at_zero[j] - at_zero[i])
        if i < j and np.abs(row).max() > NEAR:
            conditions.append((row, off))
        elif i < j and abs(off) > NEAR:
            raise InputError(f"rules: plies {i} and {j} cannot follow: no parameter sets them")
    return conditions


def _balanced(name: str, J: Array, at_zero: Array, *, half: bool) -> list[tuple[Array, float]]:
    """Return equations by which each ply that varies has one of the opposite angle."""
    count = (len(J) + 1) // 2 if half else len(J)
    left = [k for k in range(count) if np.abs(J[k]).max() > NEAR]
    pairs = []
    while left:
        k = left.pop(0)
        rest = [
            m
            for m in left
            if np.abs(J[k] + J[m]).max() <= NEAR and abs(at_zero[k] + at_zero[m]) <= NEAR
        ]
        if rest:  # balanced as it is
            left.remove(rest[0])
            continue
        other = [m for m in left if np.abs(J[k] - J[m]).max() > NEAR]
        if not other:
            raise InputError(
                f"rules: balanced: ply {k} of {name} has no partner: expected one of another "
                "parameter, or the same parameter with factor = -1"
            )
        left.remove(other[0])
        pairs.append((k, other[0]))
    return _pairs_equal(J, at_zero, -1.0, pairs)


def _solved(equal: list[tuple[Array, float]], n: int) -> tuple[Array, Array, list[int]]:
    """Return T, c and the free parameters of linear equations: later ones follow earlier ones."""
    if not equal:
        return np.eye(n), np.zeros(n), list(range(n))
    M = np.array([[*row, value] for row, value in equal])
    pivots: list[int] = []
    for column in range(n - 1, -1, -1):
        rest = np.abs(M[len(pivots) :, column])
        if not rest.size or rest.max() <= NEAR:
            continue
        r, best = len(pivots), len(pivots) + int(rest.argmax())
        M[[r, best]] = M[[best, r]]
        M[r] /= M[r, column]
        others = np.arange(len(M)) != r
        M[others] -= np.outer(M[others, column], M[r])
        pivots.append(column)
    if (np.abs(M[len(pivots) :, n]) > NEAR).any():
        raise InputError("rules: they contradict each other, or the angles that do not vary")
    free = [k for k in range(n) if k not in pivots]
    T, c = np.zeros((n, len(free))), np.zeros(n)
    T[free, range(len(free))] = 1.0
    for r, column in enumerate(pivots):
        T[column], c[column] = -M[r, free], M[r, n]
    return T, c, free


def broken(study: CheckedStudy, p: Array) -> list[str]:
    """Return which rules a discrete design breaks, in words."""
    rules = [rule for rule in study.table.rules if isinstance(rule, Rule)]
    each = layups(study, p).values() if rules else ()
    return [line for rule in rules for layup in each for line in _breaks(rule, layup)]


def _breaks(rule: Rule, layup: Layup) -> Iterator[str]:
    angles = layup.angles
    if rule.step is not None:
        turn = np.abs((np.diff(angles) + 90.0) % 180.0 - 90.0)
        if (turn > rule.step + NEAR).any():
            yield f"{layup.name}: {turn.max():g} deg between neighbouring plies"
    if rule.equal_plies is not None:
        same = np.abs((np.diff(angles) + 90.0) % 180.0 - 90.0) <= NEAR
        length = longest = 1
        for each in same:
            length = length + 1 if each else 1
            longest = max(longest, length)
        if longest > rule.equal_plies:
            yield f"{layup.name}: {longest} equal plies in sequence"
    if rule.share is not None:
        for direction in CARDINAL:
            near = np.abs((angles - direction + 90.0) % 180.0 - 90.0) <= NEAR
            share = layup.thicknesses[near].sum() / layup.thicknesses.sum()
            if share < rule.share - NEAR:
                yield f"{layup.name}: share {share:.3g} at {direction:g} deg"
