"""The base motion of a plan, as rigid as its mechanism allows; modes that respond to its loads, and
rich packages with their quasi-static response."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cache, cached_property
from typing import Any

import numpy as np

from ....dynamics.evaluation import series
from ....dynamics.evaluation.variations import residuals
from ....errors import InputError
from ....math.arrays import Array, IntArray
from ....mechanism.build import build
from ....mechanism.built_mechanism import BuiltMechanism
from ....package import ModalPackage
from ....package.body.selection import (
    axial_load,
    changed_basis,
    inertia_loads,
    interface_load,
    rigid,
    vibrations,
    with_statics,
)
from ....package.specification import DIRECTIONS
from ....results.codes import BUDGET_USED
from ....run.inputs import RunSpec
from ....run.preparation import complete, prepare
from ...tolerances import FAINT
from ..plan import DAMPED, Base, Rich, energy, with_solver, with_values
from .response import Indicators, elastic_columns, embedded, modal_loads, samples

BASE_RTOL = 1e-4
Packages = Mapping[str, ModalPackage]


class BudgetError(InputError):
    """Planning alone takes more than the budget."""


def base_motion(spec: RunSpec, names: list[str], seconds: float = np.inf) -> Base:
    """Return the motion with rigid bodies `names`; if that cannot move, with their least flexible.

    Parameters
    ----------
    spec : a run with `[fidelity]`
    names : bodies that are rigid
    seconds : CPU time after which a run stops

    Raises
    ------
    InputError
        The mechanism cannot move with flexible bodies either, or not within the time.
    """
    try:
        base, reason = _motion(spec, {name: rigid(spec.packages[name]) for name in names}, seconds)
    except BudgetError:
        raise
    except InputError as error:
        base, reason = None, str(error).splitlines()[0]
    if base is not None:
        return base
    least = {name: least_flexible(spec.packages[name]) for name in names}
    base, why = _motion(spec, least, seconds)
    if base is None:
        raise InputError(f"fidelity: no motion to plan from, rigid or flexible: {why}")
    return replace(base, reason=reason)


def _motion(
    spec: RunSpec, packages: dict[str, ModalPackage], seconds: float
) -> tuple[Base | None, str]:
    mechanism = with_solver(spec.mechanism, BASE_RTOL, stiffening=False, on_invalid="warn")
    prepared = prepare(mechanism, {**spec.packages, **packages})
    solution = complete(prepared, seconds).solution
    if solution.code == BUDGET_USED.name:
        raise BudgetError(
            f"fidelity.budget = {spec.fidelity.budget:g}: a plan needs the motion of rigid bodies, "
            f"which stopped at t = {solution.t[-1]:.4g} s: {solution.message}. Expected a larger "
            "budget, or a shorter run"
        )
    if solution.status != "finished":
        return None, f"{solution.status} at t = {solution.t[-1]:.4g} s: {solution.message}"
    rates, multipliers = series.along_solution(prepared.model, solution.t, solution.y)
    n, m = prepared.model.n_pos, prepared.model.n_vel
    return Base(prepared.built, solution.t, solution.y, rates[:, n : n + m], multipliers), ""


def least_flexible(package: ModalPackage) -> ModalPackage:
    """Return a body with its lowest vibration and the damped static shapes of all loads."""
    loads = [inertia_loads(package).T, axial_load(package)[None]]
    loads += [
        interface_load(package, place.name, direction)[None]
        for place in package.interfaces
        for direction in DIRECTIONS
    ]
    columns = np.concatenate(loads).T
    return with_statics(package, vibrations(package)[:1], columns, (), DAMPED)


def responding(packages: Packages, loads: Mapping[str, Array]) -> dict[str, IntArray]:
    """Return the modes that respond to loads (k, m) by body, of those in `packages`."""
    size = {
        name: np.sqrt(np.diag(package.stiffness))
        * np.abs(quasi_static(package, loads[name])).max(axis=0, initial=0.0)
        for name, package in packages.items()
    }
    largest = max((float(s.max(initial=0.0)) for s in size.values()), default=0.0)
    return {name: np.flatnonzero(s > FAINT * largest) for name, s in size.items()}


def with_modes(packages: Packages, modes: Mapping[str, IntArray]) -> dict[str, ModalPackage]:
    """Return packages with some of their modes."""
    return {
        name: package
        if len(modes[name]) == package.n_mode
        else changed_basis(package, np.eye(package.n_mode)[:, modes[name]])
        for name, package in packages.items()
    }


def telling_times(base: Base) -> IntArray:
    """Return output times that show which modes respond.

    Some in equal steps, and those at which an acceleration, velocity or multiplier is largest:
    a short load moves the bodies.
    """
    model = base.model
    velocities = base.y[:, model.n_pos : model.n_pos + model.n_vel]
    histories = np.column_stack([base.accelerations, velocities, base.multipliers])
    return np.unique(np.concatenate([samples(base), np.abs(histories).argmax(axis=0)]))


def by_body(built: BuiltMechanism, p: Array) -> dict[str, Array]:
    """Return the part (k, m) of loads (k, n_vel) on the modes of each body."""
    columns = elastic_columns(built.model)
    return {name: p[:, columns[i]] for i, name in enumerate(built.body_names)}


def quasi_static(package: ModalPackage, p: Array) -> Array:
    """Return K^-1 p, (k, m)."""
    return np.asarray(np.linalg.solve(package.stiffness, p.T).T)


def built_with(spec: RunSpec, packages: Packages, *, stiffening: bool = False) -> BuiltMechanism:
    """Return the mechanism of a run with other packages.

    Parameters
    ----------
    spec : the run
    packages : of all flexible bodies, by name
    stiffening : with geometric stiffening
    """
    solver = with_values(spec.mechanism.solver, geometric_stiffening=stiffening)
    mechanism: Any = with_values(spec.mechanism, solver=solver)
    return build(mechanism, dict(packages))


PROBES = 4  # output times at which the modes that the loads act on are found


def _further(
    spec: RunSpec,
    base: Base,
    packages: Packages,
    eta: Mapping[str, Array],
    modes: Mapping[str, IntArray],
) -> dict[str, Array]:
    """Return the response (s, m) to the loads that deformation adds, by body.

    The rich mechanism is put into the shape of the quasi-static response. What the base motion
    leaves there on the modes deforms the bodies further; the same again from this shape. The
    loads across a body under tension differ from all those of the base motion. It has the size of
    the response at s output times.

    Parameters
    ----------
    packages : of all bodies
    eta : quasi-static response (k, m), by body
    modes : those that respond to the base motion, by body
    """

    def left(built: BuiltMechanism, rows: IntArray, q: Mapping[str, Array]) -> dict[str, Array]:
        """Loads of the base motion at output times with modes q (s, m), by body."""
        y, accelerations = (part[rows] for part in embedded(base, built.model))
        for i, name in enumerate(built.body_names):
            if name in q:
                first = int(built.model.pos_start[i]) + 7
                y[:, first : first + q[name].shape[1]] = q[name]
        t, multipliers = base.t[rows], base.multipliers[rows]
        return by_body(built, residuals(built.model, t, y, accelerations, multipliers))

    rows, mine = samples(base), {name: packages[name] for name in modes}
    if any(len(kept) < mine[name].n_mode for name, kept in modes.items()):
        # The loads make more modes respond, such as stretching of a beam that bends alone. Their
        # cost grows with the fourth power of the number of modes: the others are left out.
        bent = [
            ((eta[n][rows] @ one.stiffness) * eta[n][rows]).sum(axis=1) for n, one in mine.items()
        ]
        some = rows[np.argsort(-np.sum(bent, axis=0), kind="stable")[:PROBES]]
        built = built_with(spec, packages, stiffening=True)
        more = responding(mine, left(built, some, {name: eta[name][some] for name in mine}))
        modes = {name: np.union1d(kept, more[name]) for name, kept in modes.items()}
    fewer = with_modes(mine, modes)
    built = built_with(spec, {**packages, **fewer}, stiffening=True)
    q = {name: eta[name][np.ix_(rows, kept)] for name, kept in modes.items()}
    changes = {name: np.zeros((2, len(rows), package.n_mode)) for name, package in mine.items()}
    for again in range(2):
        loads = left(built, rows, q)
        for name, package in fewer.items():
            change = quasi_static(package, loads[name])
            size = energy(package, change)
            change *= min(1.0, energy(package, q[name]) / max(size, 1e-300))
            changes[name][again][:, modes[name]] = change
            q[name] = q[name] + change
    # As many output times as in the response of the base motion.
    weight = np.sqrt(len(base.t) / len(rows))
    return {n: weight * each.reshape(2 * len(rows), each.shape[2]) for n, each in changes.items()}


@dataclass(frozen=True)
class Loaded:
    """Rich packages with their response, and the mechanism with the modes that respond.

    Attributes
    ----------
    built : linear
    packages : of the bodies in it
    modes : rows of the package whose modes are in `built`, by body
    p : (k, n_vel) loads that the base motion leaves in `built`
    """

    rich: dict[str, Rich]
    built: BuiltMechanism
    packages: dict[str, ModalPackage]
    modes: dict[str, IntArray]
    p: Array


def loaded(spec: RunSpec, base: Base, packages: Packages, names: list[str]) -> Loaded:
    """Return the rich packages of bodies `names` with their response along the base.

    Modes that do not respond, as those across the plane of a planar motion, have zeros there.
    Flexible bodies that a plan is not about are as the base has them.

    Parameters
    ----------
    spec : the run, with the packages of bodies that the plan is not about
    base : its base motion
    packages : rich ones, of `names` at least
    names : flexible bodies that the plan is about
    """
    fixed = {
        name: spec.packages[name] if base.model.n_mode[i] else rigid(spec.packages[name])
        for i, name in enumerate(spec.mechanism.bodies)
        if name in spec.packages and name not in names
    }
    packages = {name: packages[name] for name in names}
    mine = {**fixed, **packages}
    built = built_with(spec, mine)
    modes = responding(
        packages, by_body(built, modal_loads(base, built.model, telling_times(base)))
    )
    fewer = with_modes(packages, modes)
    built = built_with(spec, {**fixed, **fewer})
    p = modal_loads(base, built.model)
    on = by_body(built, p)
    eta = {name: np.zeros((len(p), package.n_mode)) for name, package in packages.items()}
    for name, package in fewer.items():
        eta[name][:, modes[name]] = quasi_static(package, on[name])

    @cache
    def further() -> dict[str, Array]:
        return _further(spec, base, mine, eta, modes)

    rich = {name: Rich(name, packages[name], eta[name], further) for name in names}
    return Loaded(rich, built, {**fixed, **fewer}, modes, p)


@dataclass(frozen=True)
class Study:
    """The base motion, the rich packages with their quasi-static response, the indicators.

    Attributes
    ----------
    of_check : returns the rich packages of the check, which indicators do not need
    cpu : seconds of the base motion and of the indicators
    """

    base: Base
    model: dict[str, Rich]
    of_check: Callable[[], Loaded]
    indicators: Indicators
    cpu: dict[str, float]

    @cached_property
    def check(self) -> dict[str, Rich]:
        """The rich packages of the check."""
        return self.of_check().rich
