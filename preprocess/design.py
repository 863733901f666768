"""Derivatives of the package of a body by design parameters of its specification.

The package of a changed specification with the same discretisation is a function of the parameter.
All that is an explicit function of the input, of shapes and of matrices is differentiated along the
change by the five-point rule, with the code that makes the package; the modes, where a singular
problem is in between, by their own equations (modes/rates.py).
"""

import json
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeVar

import numpy as np

from ..solver.errors import did_you_mean
from ..solver.math.arrays import Array
from ..solver.package.body.schema import ModalPackage
from ..solver.package.common.dataset import all_values
from ..solver.package.common.design import PLACES, TWO_PLACES, Derivative, difference, differenced
from ..solver.package.common.plain_data import SpecError, expected
from .modes.rates import Change, ModeRates, mode_rates
from .modes.reduced import Modes, StaticLoad
from .modes.reference import Condition

Model = TypeVar("Model")
ANGLE_DEG = 0.2  # distance of the places of the five-point rule
RELATIVE = 3e-3  # the same of other numbers, relative to their scale
NEAR = 0.01  # times these distances, where the model moves along its derivatives
MOST_TURNED = 1e-2  # change of a mode from place to place, relative
KINDS = {"angle_deg": "angle", "thickness": "thickness"}
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


@dataclass(frozen=True)
class Target:
    """A number of a specification that a parameter sets, by its keys."""

    keys: tuple[str, ...]
    factor: float
    offset: float

    @property
    def path(self) -> str:
        """The keys with dots."""
        return ".".join(self.keys)

    @property
    def kind(self) -> str:
        """One of angle, thickness, number."""
        return KINDS.get(self.keys[-1], "number")


@dataclass(frozen=True)
class Parameter:
    """A design parameter of a body, and the step of its differences in its unit."""

    name: str
    targets: tuple[Target, ...]
    step: float
    places: tuple[float, ...] = PLACES

    def linear(self) -> "Parameter":
        """The same of a model that moves along its derivatives: two near places are enough."""
        return replace(self, step=NEAR * self.step, places=TWO_PLACES)

    def changed(self, spec: Any, distance: float, below: Sequence[str] = ()) -> Any:
        """A specification with the parameter moved, or the part of it below some keys."""
        out, n = json.loads(json.dumps(spec)), len(below)
        for target in self.targets:
            if target.keys[:n] == tuple(below):
                *way, last = target.keys[n:]
                place = out
                for key in way:
                    place = place[_row(place, key)]
                place[_row(place, last)] += target.factor * distance
        return out

    def below(self, keys: Sequence[str]) -> list[dict[str, Any]]:
        """The targets below some keys, as tables."""
        n = len(keys)
        return [
            {"of": list(t.keys[n:]), "factor": t.factor, "offset": t.offset}
            for t in self.targets
            if t.keys[:n] == tuple(keys)
        ]


def read_parameters(spec: dict[str, Any]) -> tuple[Parameter, ...]:
    """The design parameters of a specification with a checked form.

    Raises
    ------
    SpecError : a target that does not exist, is no number, or cannot be a design parameter.
    """
    found = []
    for name, tables in spec.get("design", {}).items():
        if not name or "/" in name or name == ".":
            raise SpecError(expected("design", name, "a name without '/'"))
        if not tables:
            raise SpecError(expected(f"design.{name}", tables, "at least one target"))
        targets, steps = [], []
        for row, table in enumerate(tables):
            where = f"design.{name}[{row}]"
            of = table["of"]
            keys = tuple(of.split(".") if isinstance(of, str) else of)
            target = Target(keys, float(table.get("factor", 1.0)), float(table.get("offset", 0.0)))
            if target.factor == 0.0:
                raise SpecError(expected(f"{where}.factor", 0.0, "a number other than 0"))
            steps.append(_size(spec, target, f"{where}.of") / abs(target.factor))
            targets.append(target)
        found.append(Parameter(name, tuple(targets), min(steps)))
    return tuple(found)


def _size(spec: dict[str, Any], target: Target, where: str) -> float:
    """Step of a target in its own unit. Raises SpecError."""
    place: Any = spec
    for count, key in enumerate(target.keys):
        try:
            above, place = place, place[_row(place, key)]
        except (KeyError, IndexError, TypeError, ValueError):
            known = list(place) if isinstance(place, dict) else []
            raise SpecError(
                f"{where} = {target.path!r}: no {key!r} in "
                f"{'.'.join(target.keys[:count]) or 'the specification'}{did_you_mean(key, known)}"
            ) from None
    patterns = OPEN[spec["kind"]]
    if "stations" in spec and target.keys[0] == "section":
        raise SpecError(expected(where, target.path, "one of `stations`, which the beam has"))
    path = ".".join(key.replace(".", "_") for key in target.keys)
    if not any(re.fullmatch(pattern, path) for pattern in patterns):
        text = f"a number that can be a design parameter ({MAY_BE[spec['kind']]})"
        raise SpecError(expected(where, target.path, text))
    if isinstance(place, bool) or not isinstance(place, int | float):
        raise SpecError(
            f"{where} = {target.path!r}: expected the path of a number, found {place!r}"
        )
    if target.kind == "angle":
        return ANGLE_DEG
    scale = abs(float(place))
    if target.keys[-3:-2] in (("stiffness",), ("mass",)):  # an entry of a 6x6
        matrix: Any = spec
        for key in target.keys[:-2]:
            matrix = matrix[_row(matrix, key)]
        i, j = int(target.keys[-2]), int(target.keys[-1])
        scale = float(np.sqrt(abs(matrix[i][i] * matrix[j][j])))
    if target.keys[-1] == "offset":
        plies = above.get("plies", [above])
        scale = float(sum(ply["thickness"] for ply in plies))
    if not scale > 0.0:
        raise SpecError(expected(where, place, "a number other than 0"))
    return RELATIVE * scale


def _row(place: Any, key: str) -> Any:
    return int(key) if isinstance(place, list) else key


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
    found = []
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
        kinds = {target.kind for target in p.targets}
        found.append(
            Derivative(
                p.name,
                kinds.pop() if len(kinds) == 1 else "number",
                tuple({**one, "of": ".".join(one["of"])} for one in p.below(())),
                {path: value for path, value in values.items() if value.any()},
            )
        )
    return tuple(found)


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
    modes: Modes, rate: ModeRates, ratio: float, found: dict[str, Array]
) -> dict[str, Array]:
    """Derivatives of modal matrices; `found` has the part of the damping by its ratio."""
    w = np.sqrt(modes.values)
    damping = 2.0 * ratio * rate.stiffness / np.add.outer(w, w)
    return {
        "modes/stiffness": rate.stiffness,
        "modes/damping": damping + found.get("modes/damping", 0.0),
        "modes/frequencies": np.diag(rate.stiffness) / (2.0 * w),
        **({} if modes.compliance is None else {"modes/compliance": rate.compliance}),
    }
