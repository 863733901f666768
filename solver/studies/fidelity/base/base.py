"""The base of a plan: a run with as little flexibility as the mechanism allows."""

from dataclasses import dataclass, replace

import numpy as np

from ....dynamics.evaluation import series
from ....dynamics.model.model import Model
from ....errors import InputError
from ....math.arrays import Array
from ....mechanism import BuiltMechanism
from ....package import ModalPackage
from ....package.body.selection import (
    axial_load,
    inertia_loads,
    interface_load,
    vibrations,
    with_statics,
)
from ....package.body.transform import rigid
from ....package.specification import DIRECTIONS
from ....run.integration import complete
from ....run.outcome import RunSpec
from ....run.preparation import prepare
from .model import DAMPED, with_values

BASE_RTOL = 1e-4


@dataclass(frozen=True)
class Base:
    """A motion with its accelerations and multipliers at the output times.

    Attributes
    ----------
    built : the mechanism, with the packages of the base
    t, y : (k,), (k, n)
    accelerations, multipliers : (k, n_vel), (k, n_c)
    reason : why the bodies are not rigid in it; "" if they are
    """

    built: BuiltMechanism
    t: Array
    y: Array
    accelerations: Array
    multipliers: Array
    reason: str = ""

    @property
    def model(self) -> Model:
        """The model of the base."""
        return self.built.model


def base_motion(spec: RunSpec, names: list[str]) -> Base:
    """Return the motion with rigid bodies `names`; if that cannot move, with their least flexible.

    Raises
    ------
    InputError
        The mechanism cannot move with flexible bodies either.
    """
    try:
        found, reason = _motion(spec, {name: rigid(spec.packages[name]) for name in names})
    except InputError as error:
        found, reason = None, str(error).splitlines()[0]
    if found is not None:
        return found
    least = {name: least_flexible(spec.packages[name]) for name in names}
    found, why = _motion(spec, least)
    if found is None:
        raise InputError(f"fidelity: no motion to plan from, rigid or flexible: {why}")
    return replace(found, reason=reason)


def _motion(spec: RunSpec, packages: dict[str, ModalPackage]) -> tuple[Base | None, str]:
    solver = with_values(
        spec.mechanism.solver,
        rtol=BASE_RTOL,
        geometric_stiffening=False,
        on_invalid="warn",
        atol_position=None,
        atol_velocity=None,
    )
    mechanism = with_values(spec.mechanism, solver=solver)
    prepared = prepare(mechanism, {**spec.packages, **packages})
    solution = complete(prepared).solution
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
