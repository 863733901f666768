"""Parameters of a run: its case with numbers a little smaller and larger, and their models."""

from collections.abc import Collection, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ...dynamics.model.model import Model
from ...errors import InputError, few, nearest, refuse
from ...inputs.case.design import Case
from ...inputs.case.load import checked_case
from ...inputs.case.sweeps import CheckedSweep, Misplaced, number_at
from ...inputs.case.tables.schema import Sweep
from ...integrators.breakpoints import breaks
from ...integrators.table import treatment_of
from ...math.arrays import Array
from ...math.independent_changes import independent
from ...mechanism.assembly import treated
from ...mechanism.build import build, used_packages
from ...mechanism.built_mechanism import BuiltMechanism
from ...mechanism.equilibrium import given_spin
from ...mechanism.start import quasi_static_state, starting_state
from ...package import ModalPackage
from ...package.common.dataset import all_values
from ...run.inputs import RunSpec

# Over the number: central differences of arrays that are polynomials of it.
RELATIVE = 1e-5
SAME = 1e-13  # of the largest change of packages, below which there is none


@dataclass(frozen=True)
class Parameter:
    """A number of a case, and the run with it less and plus h."""

    name: str
    unit: str
    value: float
    h: float
    minus: RunSpec
    plus: RunSpec


def with_parameters(
    table: dict[str, object], file: Path, run: str, keys: Sequence[str], *, coarse: bool = False
) -> tuple[Case, list[tuple[str, float, CheckedSweep]]]:
    """Return a checked case, and for each key its number and the run with that less and plus h.

    Numbers that are expressions of `[parameters]` follow.

    Parameters
    ----------
    table, file : content of a case file, and its name for messages and relative paths
    run : name of the run
    keys : of numbers of the mechanism, as in sweeps (docs/sweeps.md)
    coarse : bodies have coarse meshes

    Raises
    ------
    InputError
        As `checked_case`; a key that is not that of a number, or changes the package of a flexible
        body or the times of the run.
    """
    case = checked_case(table, file, coarse=coarse, sweeps=())
    given, wrong = list[tuple[str, float, CheckedSweep]](), list[str]()
    for key in keys:
        if key.startswith("solver."):
            raise InputError(f"--of {key}: expected a number of the mechanism, not of its solution")
        unit, there = "", None
        with suppress(Misplaced):  # which is said below
            unit, there = number_at(case.runs[run], key, file.parent)
        value = there or 0.0
        h = RELATIVE * (abs(value) or 1.0)
        vary: dict[str, object] = {"values": [value - h, value + h]}
        if unit == "m":
            vary["unit"] = "m"
        try:
            sweep = Sweep.model_validate({"run": run, "vary": {key: vary}})
            members = case.varied(f"--of {key}", sweep)
        except InputError as error:
            wrong += [line.replace(f".vary: {key}", "") for line in str(error).splitlines()]
            continue
        base, every = members.base_bodies, (b for own in members.own.bodies for b in own.items())
        if changed := {n for n, s in every if s.inputs_sha256 != base[n].inputs_sha256}:
            wrong.append(
                f"--of {key}: changes the package of {few(sorted(changed))}; expected a number of "
                "the mechanism, or a parameter whose derivatives the package has (/design)"
            )
        given.append((key, value, members))
    refuse(wrong)
    return case, given


def parameter_of(spec: RunSpec, key: str, value: float, sweep: CheckedSweep) -> Parameter:
    """Return a parameter of a run.

    Parameters
    ----------
    spec : the run
    key : of the number in the case
    value : of the number
    sweep : with two members, less and plus h
    """
    minus, plus = (spec.changed(changes) for changes in sweep.own.changes)
    low, high = map(float, sweep.points[:, 0])
    return Parameter(key, sweep.parameters[0].unit, value, 0.5 * (high - low), minus, plus)


def design_parameter(spec: RunSpec, name: str, others: Sequence[str] = ()) -> Parameter:
    """Return a design parameter of packages, by the derivatives that they have (/design/NAME).

    Parameters
    ----------
    spec : the run
    name : of the parameter
    others : names that a message may propose besides those of packages

    Raises
    ------
    InputError
        No package has derivatives by it.
    """
    steps = list[float]()
    for package in spec.packages.values():
        values = all_values(package)
        for path, rate in next((d.values for d in package.design if d.name == name), {}).items():
            size = float(np.abs(values[path]).max(initial=0.0))
            if rate.any() and size > 0.0:
                steps.append(RELATIVE * size / float(np.abs(rate).max()))
    if not steps:
        raise without_derivatives(spec, name, others)
    h = min(steps)
    return Parameter(name, "", 0.0, h, spec.moved(name, -h), spec.moved(name, h))


def without_derivatives(spec: RunSpec, name: str, others: Sequence[str] = ()) -> InputError:
    """Return the error for a parameter by which no package has derivatives.

    Parameters
    ----------
    spec : the run
    name : of the parameter
    others : names that the message may propose besides those of packages
    """
    known = {*others} | {one.name for package in spec.packages.values() for one in package.design}
    return InputError(
        f"--of {name}: no package of {spec.run} has derivatives by it (/design/{name}); "
        f"expected a dotted key of a number{nearest(name, known)}"
    )


def parted(spec: RunSpec) -> tuple[RunSpec, RunSpec]:
    """Return a run whose packages have derivatives of all but what only stresses are made of, and
    one whose packages have those alone."""

    def part(package: ModalPackage, stresses: bool) -> ModalPackage:
        design = (
            replace(one, values={p: x for p, x in one.values.items() if of_stresses(p) == stresses})
            for one in package.design
        )
        return replace(package, design=tuple(design))

    motion, stresses = (
        replace(spec, packages={body: part(p, which) for body, p in spec.packages.items()})
        for which in (False, True)
    )
    return motion, stresses


def of_stresses(path: str) -> bool:
    """Tell whether only stresses depend on a dataset of a package, not motion and resultants."""
    group, *below = path.split("/")
    return group == "laminates" or (group == "sections" and below[1] in ("plies", "recovery"))


def combined(
    specs: Sequence[RunSpec], names: Sequence[str], apart: Collection[int] = ()
) -> tuple[list[int], Array]:
    """Return which design parameters (r) all others are made of, and shares (r, names) of them.

    A parameter moves the packages of all runs as the sum of its shares does. There are as many as
    the derivatives of the packages have independent directions: 1000 plies of a section change its
    stiffness in 21 ways at most.

    Parameters
    ----------
    specs : the runs
    names : of the parameters
    apart : numbers of parameters that are kept and are no part of others
    """
    values = dict[tuple[int, str, str], Any]()
    changes: dict[str, dict[tuple[int, str, str], Array]] = {name: {} for name in names}
    for run, spec in enumerate(specs):
        for body, package in spec.packages.items():
            values |= {(run, body, path): x for path, x in all_values(package).items()}
            for one in package.design:
                own = changes.get(one.name, {})
                own |= {(run, body, path): rate for path, rate in one.values.items() if rate.any()}
    return independent(values, list(changes.values()), SAME, apart)


class Variant(NamedTuple):
    """A run with another number: its mechanism and its start."""

    built: BuiltMechanism
    y0: Array


def variant(spec: RunSpec, base: Model) -> Variant:
    """Return the mechanism of a run, treated like that of `base`, and its start.

    Raises
    ------
    InputError
        As `build` and `starting_state`.
    """
    solver = spec.mechanism.solver
    built = build(spec.mechanism, used_packages(spec.mechanism, spec.packages))
    names = built.joint_names, built.body_names
    spin = given_spin(solver)
    y0 = starting_state(built.model, built.start, solver.start, *names, spin, built.light)
    if solver.start == "quasi-static":  # a difference of two needs more digits than a run
        again = built.start._replace(positions=y0[: built.model.n_pos])
        y0 = quasi_static_state(built.model, again, y0, *names)
    model = treated(built.model, treatment_of(solver))._replace(redundant=base.redundant)
    return Variant(replace(built, model=model), y0)


def start_tangent(model: Model, y0: Array, minus: Array, plus: Array, h: float) -> Array:
    """Return the derivative of the start, (2 n_vel + n_aux,).

    Displacements along the velocity coordinates, then changes of velocities and auxiliary states.

    Parameters
    ----------
    model : arrays of the mechanism
    y0 : (n,) start of the run
    minus, plus : (n,) starts with the parameter less and plus h
    h : in the unit of the parameter
    """
    change = (plus - minus) / (2.0 * h)
    x = np.empty(model.n_vel)
    for a, j, m in zip(model.pos_start, model.vel_start, model.n_mode, strict=True):
        x[j : j + 3] = change[a : a + 3]
        x[j + 6 : j + 6 + m] = change[a + 7 : a + 7 + m]
        p, dp = y0[a + 3 : a + 7], change[a + 3 : a + 7]
        turn = p[0] * dp[1:] - dp[0] * p[1:] - np.cross(p[1:], dp[1:])
        x[j + 3 : j + 6] = 2.0 * turn / (p @ p)
    return np.concatenate([x, change[model.n_pos : -1]])


def check_variant(parameter: Parameter, variant: Variant, base: Model, t_end: float) -> None:
    """Check that a parameter changes nothing but numbers of the model.

    Parameters
    ----------
    variant : its mechanism less or plus h
    base : model of the run itself
    t_end : end of the run [s]

    Raises
    ------
    InputError
        Another count of equations, or another instant at which a law of time bends or jumps.
    """
    model = variant.built.model
    for name in ("n_pos", "n_vel", "n_constraint", "n_aux"):
        if getattr(model, name) != getattr(base, name):
            raise InputError(f"{parameter.name}: changes the equations, not only their numbers")
    for one, two in zip(breaks(model, t_end)[:3], breaks(base, t_end)[:3], strict=True):
        if one.shape != two.shape or not np.allclose(one, two, rtol=0.0, atol=1e-12 * t_end):
            raise InputError(
                f"{parameter.name}: moves the instant at which a law of time bends or jumps, for "
                "which sensitivities are not implemented; expected a number that moves none"
            )
