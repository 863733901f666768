"""An ensemble: models of one structure as one model whose numbers have a leading axis.

Members share bodies, modes, joints, forces and tables of indices; masses, invariants,
markers, laws and parameters are each member's own. The step loop runs over that axis.
"""

import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, get_type_hints

import numpy as np

from ..dynamics.constraints.treatment import Treatment
from ..dynamics.model import Model
from ..dynamics.order import Order
from ..dynamics.plan import Plan
from ..integrators.choice import make_integrator
from ..integrators.generic import Solution, integrate
from ..math.arrays import Array
from .preparation import Watch

FIELDS = get_type_hints(Model)  # name -> int, float or an array type


@dataclass(frozen=True)
class Ensemble:
    """Stacked models; `model` holds (k, ...) in place of every float and array of floats."""

    model: Model
    count: int


def structure(model: Model) -> str:
    """Return what members of one ensemble have in common: whole numbers, and shapes of arrays."""
    parts: list[Any] = []
    for name, value in _items(model):
        if _is_own(name, value):
            parts.append([name, np.shape(value)])
        else:
            parts.append([name, np.asarray(value).tolist()])
    return json.dumps(parts)


def stack_models(models: Sequence[Model]) -> Ensemble:
    """Stack models of one structure.

    Raises
    ------
    ValueError
        Another number of bodies, modes or joints in one of them; names what differs.
    """
    first = models[0]
    for k, model in enumerate(models):
        for (name, one), (_, other) in zip(_items(first), _items(model), strict=True):
            same = np.shape(one) == np.shape(other)
            if same and not _is_own(name, one):
                same = np.array_equal(one, other)
            if not same:
                raise ValueError(f"member {k}: {name} differs in structure from that of member 0")
    stacked = [
        np.stack([np.asarray(model[i], dtype=float) for model in models])
        if _is_own(name, value)
        else value
        for i, (name, value) in enumerate(zip(first._fields, first, strict=True))
    ]
    return Ensemble(Model._make(stacked), len(models))


def member(ensemble: Ensemble, k: int) -> Model:
    """Return one member's model; its arrays are views of the ensemble's."""
    found: list[Any] = []
    values: tuple[Any, ...] = ensemble.model
    for name, value in zip(Model._fields, values, strict=True):
        if FIELDS[name] is float:
            found.append(float(value[k]))
        elif isinstance(value, np.ndarray) and value.dtype.kind == "f":
            found.append(value[k])
        else:
            found.append(value)
    return Model._make(found)


def integrate_members(
    models: Sequence[Model],
    y0s: Sequence[Array],
    solver: dict[str, Any],
    times: Array,
    watches: Sequence[Watch],
    treatment: Treatment,
) -> list[Solution | Exception]:
    """Integrate members of one structure, all with the same settings and output times.

    A member that ends in an error leaves that error in its place and the others alone. The list
    ends early where the user interrupts (Ctrl-C); its last entry may then be interrupted.

    Each member runs through its own integrator: the compiled step loops (marching.py) take many
    steps in one call, so that one more loop around the members would save less than 1 %.

    Parameters
    ----------
    models : prepared for `treatment`
    y0s : start (n,) of each
    solver : `[solver]` of the case as plain data
    times : (n_t,) output times [s]
    watches : what looks at every step of each member and may stop it
    """
    ensemble = stack_models(models)
    found: list[Solution | Exception] = []
    for k, (y0, watch) in enumerate(zip(y0s, watches, strict=True)):
        try:
            integrator = make_integrator(member(ensemble, k), y0, solver, treatment)
            solution = integrate(integrator, times, watch)
        except KeyboardInterrupt:
            break
        except Exception as error:
            found.append(error)
            continue
        found.append(solution)
        if solution.status == "interrupted":
            break
    return found


def _items(model: Model | Plan | Order) -> Iterator[tuple[str, Any]]:
    """Yield names and values of all fields, those of the plan in its place."""
    for name, value in zip(model._fields, model, strict=True):
        if isinstance(value, Plan | Order):
            yield from ((f"{name}.{part}", inside) for part, inside in _items(value))
        else:
            yield name, value


def _is_own(name: str, value: Any) -> bool:
    """Say whether a field is a member's own: a float, or an array of floats."""
    if isinstance(value, np.ndarray):
        return value.dtype.kind == "f"
    return FIELDS.get(name) is float
