"""Derivatives of the package of a body by design parameters of its specification.

The package of a changed specification with the same discretisation is a function of the parameter.
All that is an explicit function of the input, of shapes and of matrices is differentiated along the
change by the five-point rule, with the code that makes the package; the modes, where a singular
problem is in between, by their own equations (modes/rates.py).
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any, TypeVar

import numpy as np

from ..solver.math.arrays import Array
from ..solver.package.body.package_schema import ModalPackage
from ..solver.package.common.dataset import all_values
from ..solver.package.common.design import Derivative, difference, differenced
from ..solver.package.common.plain_data import SpecError, expected
from .modes.rates import Change, ModeRates, mode_rates
from .modes.reduced import Modes, StaticLoad
from .modes.reference import Condition
from .parameters import Key, Parameter, read_parameters

Model = TypeVar("Model")
ANGLE_DEG = 0.2  # distance of the places of the five-point rule
RELATIVE = 3e-3  # the same of other numbers, relative to their scale
MOST_TURNED = 1e-2  # change of a mode from place to place, relative
# Numbers of a specification that may be design parameters.
SECTION = r"(?:section|stations\.\d+\.section)\."
OPEN = {
    "beam": (SECTION + r".+", "damping_ratio"),
    "shell": (
        r"shell\.laminates\.[^.]+\.(?:plies\.\d+\.(?:angle_deg|thickness)|offset)",
        r"shell\.regions\.[^.]+\.(?:thickness|offset)",
        r"shell\.materials\.[^.]+\.[^.]+",
        r"shell\.stiffeners\.[^.]+\.(?:stiffness|mass)\.\d\.\d",
        "damping_ratio",
    ),
}

MAY_BE = {
    "beam": "numbers of sections, damping_ratio",
    "shell": "angle_deg, thickness and offset of laminates and regions, constants of materials, "
    "stiffness and mass of stiffeners, damping_ratio",
}


def body_parameters(spec: Mapping[str, Any]) -> tuple[Parameter, ...]:
    """The design parameters of the specification of a body. Raises SpecError."""
    kind, design = spec["kind"], spec.get("design", {})
    return read_parameters(spec, design, OPEN[kind], MAY_BE[kind], _step, "", SpecError)


def _step(spec: Mapping[str, Any], keys: tuple[Key, ...], where: str) -> float:
    """Step of a target in its own unit. Raises SpecError."""
    if "stations" in spec and keys[0] == "section":
        path = ".".join(map(str, keys))
        raise SpecError(expected(where, path, "one of `stations`, which the beam has"))
    if keys[-1] == "angle_deg":
        return ANGLE_DEG
    above: Any = spec
    for key in keys[:-1]:
        matrix, above = above, above[key]
    scale = abs(float(above[keys[-1]]))
    if keys[-3:-2] in (("stiffness",), ("mass",)):  # an entry of a 6x6
        i, j = int(keys[-2]), int(keys[-1])
        scale = float(np.sqrt(abs(matrix[i][i] * matrix[j][j])))
    if keys[-1] == "offset":
        plies = above.get("plies", [above])
        scale = float(sum(ply["thickness"] for ply in plies))
    if not scale > 0.0:
        raise SpecError(expected(where, scale, "a number other than 0"))
    return RELATIVE * scale


def derivatives(
    parameters: Sequence[Parameter],
    condition: Condition,
    modes: Modes,
    at: Callable[[Parameter, float], Model],
    change: Callable[[Parameter, list[Model]], Change],
    package: Callable[[Model, Modes], ModalPackage],
    damping_ratio: float,
) -> tuple[Derivative, ...]:
    """Derivatives of the package of a body.

    Parameters
    ----------
    condition, modes : of the body
    at : the model with one parameter moved by a distance
    change : derivatives of the FE model, from the models at the places of the differences
    package : the package of a model with given modes
    damping_ratio : of every mode

    Raises
    ------
    ModeError : a parameter couples a mode with one that is not selected.
    """
    models = [[at(p, place * p.step) for place in p.places] for p in parameters]
    changes = [change(p, row) for p, row in zip(parameters, models, strict=True)]
    result = []
    rates = mode_rates(condition, modes, changes)
    for p, row, rate in zip(parameters, models, rates, strict=True):
        # modes of close frequencies turn fast: the five points must be near enough for them
        dX = rate.columns_B
        turn = np.einsum("ni,ni->i", dX, condition.M @ dX).max(initial=0.0)
        share = min(1.0, MOST_TURNED / max(float(np.sqrt(turn)) * p.step, MOST_TURNED))
        step = share * p.step
        if share < 1.0:
            row = [at(p, place * step) for place in p.places]
        packages = [
            all_values(package(model, _moved(modes, rate, place * step)))
            for model, place in zip(row, p.places, strict=True)
        ]
        values = differenced(packages, step)
        values |= _modal(modes, rate, damping_ratio, values)
        changing = {path: value for path, value in values.items() if value.any()}
        result.append(Derivative(p.name, p.kind, tuple(t.table for t in p.targets), changing))
    return tuple(result)


def of_parameters(
    parameters: Sequence[Parameter], rates: Sequence[Derivative], shares: Array
) -> tuple[Derivative, ...]:
    """Derivatives by parameters (p) from those by the few (r) that they are made of.

    Parameters
    ----------
    parameters : the p parameters
    rates : derivatives by r of them, or by combinations of them
    shares : (r, p) of the r in each parameter
    """
    every = dict[str, Array]()
    for path in dict.fromkeys(path for one in rates for path in one.values):
        rows = np.broadcast_arrays(*(one.values.get(path, 0.0) for one in rates))
        every[path] = np.tensordot(shares.T, rows, 1)
    return tuple(
        Derivative(
            p.name,
            p.kind,
            tuple(t.table for t in p.targets),
            {path: rows[k] for path, rows in every.items() if rows[k].any()},
        )
        for k, p in enumerate(parameters)
    )


def change_of_inputs(
    p: Parameter, at: Sequence[tuple[Condition, Sequence[StaticLoad], Array]]
) -> Change:
    """Derivatives of condition, static loads and unit loads, from those at the places."""
    n = at[0][0].K.shape[0]
    forces, accelerations = [], []
    for _, loads, unit in at:
        columns = [np.array([load.force_B for load in loads]).reshape(-1, n).T, unit]
        forces.append(np.hstack(columns))
        columns = [np.array([load.acceleration_B for load in loads]).reshape(-1, n).T, 0.0 * unit]
        accelerations.append(np.hstack(columns))
    K, M = ([getattr(condition, name) for condition, _, _ in at] for name in ("K", "M"))
    parts = [difference(part, p.step) for part in (K, M, forces, accelerations)]
    return Change(p.name, *parts)


def _moved(modes: Modes, rate: ModeRates, distance: float) -> Modes:
    return replace(
        modes,
        columns_B=modes.columns_B + distance * rate.columns_B,
        accelerations_B=modes.accelerations_B + distance * rate.accelerations_B,
    )


def _modal(
    modes: Modes, rate: ModeRates, ratio: float, values: dict[str, Array]
) -> dict[str, Array]:
    """Derivatives of modal matrices; `values` has the part of the damping by its ratio."""
    w = np.sqrt(modes.values)
    damping = 2.0 * ratio * rate.stiffness / np.add.outer(w, w)
    return {
        "modes/stiffness": rate.stiffness,
        "modes/damping": damping + values.get("modes/damping", 0.0),
        "modes/frequencies": np.diag(rate.stiffness) / (2.0 * w),
        **({} if modes.compliance is None else {"modes/compliance": rate.compliance}),
    }
