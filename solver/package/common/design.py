"""Derivatives of the datasets of an object by design parameters, in its file and in memory.

In a file with the data group G the dataset `G/design/<name>/<path>` is the derivative of the
dataset `G/<path>` by the parameter <name>, per unit of the parameter as the user writes it. A path
that is absent has the derivative zero. Other producers may write the group (docs/format.md).
"""

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any, TypeVar

import h5py
import numpy as np

from ...errors import PackageError, did_you_mean
from ...math.arrays import Array
from ...math.records import record
from .container import get_text, set_text
from .dataset import Datasets, all_values, check_name, rebuilt
from .findings import Remark, finite
from .plain_data import json_text

Object = TypeVar("Object")
GROUP = "design"


@record
class Derivative:
    """Derivatives of the arrays of an object by one parameter.

    Attributes
    ----------
    name : of the parameter
    kind : "angle", "thickness" or "number"
    targets : tables {of, factor, offset}: the inputs of the object that the parameter sets
    values : derivative by path of the dataset below the data group, in its shape and unit per unit
        of the parameter; zero where a path is absent
    """

    name: str
    kind: str
    targets: tuple[Mapping[str, object], ...]
    values: dict[str, Array]


def moved(item: Object, steps: Mapping[str, float]) -> Object:
    """Return an object with all arrays moved along its derivatives: value + sum step derivative.

    Raises
    ------
    PackageError
        The object has no derivative by a parameter of `steps`.
    """
    whole: Any = item
    known = {one.name: one for one in whole.design}
    values = all_values(item)
    for name, step in steps.items():
        if name not in known:
            raise PackageError(
                f"no derivative by the design parameter {name!r}; the file has "
                f"{', '.join(known) or 'none'}{did_you_mean(name, known)}"
            )
        for path, rate in known[name].values.items():
            values[path] = np.asarray(values[path]) + step * rate
    return rebuilt(item, values)


# Five-point rule: exact for polynomials of degree 4, error h^4 f^(5) / 30.
# Two places: error h^2 f^(3) / 6.
PLACES, TWO_PLACES = (-2.0, -1.0, 1.0, 2.0), (-1.0, 1.0)


def difference(at: Sequence[Any], step: float) -> Any:
    """Derivative from the values at `PLACES` or `TWO_PLACES` times a step."""
    if len(at) == len(TWO_PLACES):
        return (at[1] - at[0]) / (2.0 * step)
    before_2, before, after, after_2 = at
    return (8.0 * (after - before) - (after_2 - before_2)) / (12.0 * step)


def differenced(at: Sequence[Mapping[Any, Any]], step: float) -> dict[Any, Array]:
    """Derivatives of arrays by path, from those at the places times a step; zeros are left out."""
    rates = {}
    for path, first in at[0].items():
        if np.asarray(first).dtype.kind == "f":
            rate = np.asarray(difference([np.asarray(values[path]) for values in at], step))
            if rate.any():
                rates[path] = rate
    return rates


def write_design(group: h5py.Group, design: Sequence[Derivative], where: str) -> None:
    """Write derivatives beside their datasets. Raises PackageError for what `validate` refuses.

    Parameters
    ----------
    group : data group of the object
    design : derivatives by parameter
    where : path of the group, for messages
    """
    known: Datasets = {}
    for index, one in enumerate(design):
        check_name(f"{where}/{GROUP}", one.name, one.name in (each.name for each in design[:index]))
        own = group.create_group(f"{GROUP}/{one.name}")
        own.attrs["index"] = np.int64(index)
        set_text(own, "kind", one.kind)
        set_text(own, "targets", json_text(f"{where}/{GROUP}/{one.name}", list(one.targets)))
        for path, rate in one.values.items():
            made = own.create_dataset(path, data=np.asarray(rate, dtype=np.float64))
            for message in _faults(group, known, made, path, rate):
                raise PackageError(f"{where}/{GROUP}/{one.name}/{path}: {message}")


def read_design(group: h5py.Group) -> tuple[Derivative, ...]:
    """Return the derivatives of a group that `design_findings` has checked."""
    derivatives = []
    for name, own in sorted(_groups(group).items(), key=lambda pair: _index(pair[1])):
        values = {path: np.asarray(d[()], dtype=np.float64) for path, d in _datasets(own).items()}
        kind, targets = get_text(own, "kind", "number"), _targets(own)
        derivatives.append(Derivative(name, kind, tuple(targets or ()), values))
    return tuple(derivatives)


def design_findings(group: h5py.Group) -> list[Remark]:
    """Compare the derivatives of a group with the datasets that they belong to."""
    bad: list[Remark] = []
    known: Datasets = {}

    def error(dataset: str, message: str) -> None:
        bad.append(Remark("error", dataset, message))

    for own in _groups(group).values():
        if _targets(own) is None:
            error(own.name, "attribute targets: expected a JSON list of tables")
        for path, rate in _datasets(own).items():
            for message in _faults(group, known, rate, path, rate[()]):
                error(rate.name, message)
    return bad


def _faults(
    group: h5py.Group, known: Datasets, rate: h5py.Dataset, path: str, values: Any
) -> list[str]:
    """What is wrong with a derivative, at most one fault; `known` members of the group by path."""
    if path not in known:
        known[path] = group.get(path)
    base, errors = known[path], list[str]()
    if not isinstance(base, h5py.Dataset) or base.dtype.kind != "f":
        return [f"expected the path of a dataset of numbers below {group.name}"]
    if rate.dtype.kind not in "fiu" or rate.shape != base.shape:
        wanted = f"expected numbers of the shape of {base.name}, {base.shape}"
        return [f"{wanted}, found {rate.dtype} {rate.shape}"]
    finite(path, values, lambda _, message: errors.append(message))
    return errors


def changed(
    design: Sequence[Derivative], change: Callable[[str, Any], Any], shapes: Mapping[str, str]
) -> tuple[Derivative, ...]:
    """Return derivatives with `change(shape, array)` of each array; `shapes` by path.

    Parameters
    ----------
    design : derivatives by parameter
    change : function of shape and array
    shapes : shapes by path, as in the format
    """
    return tuple(
        replace(one, values={p: change(shapes[p], rate) for p, rate in one.values.items()})
        for one in design
    )


def _groups(group: h5py.Group) -> dict[str, h5py.Group]:
    parent = group.get(GROUP, {})
    return {name: own for name, own in parent.items() if isinstance(own, h5py.Group)}


def _targets(group: h5py.Group) -> list[dict[str, object]] | None:
    """Return the targets of a parameter; None if they are of another form."""
    try:
        targets = json.loads(get_text(group, "targets", "[]"))
    except json.JSONDecodeError:
        return None
    tables = isinstance(targets, list) and all(isinstance(one, dict) for one in targets)
    return targets if tables else None


def _index(group: h5py.Group) -> int:
    return int(group.attrs.get("index", 0))


def _datasets(group: h5py.Group) -> dict[str, h5py.Dataset]:
    datasets: dict[str, h5py.Dataset] = {}

    def visit(path: str, item: h5py.HLObject) -> None:
        if isinstance(item, h5py.Dataset):
            datasets[path] = item

    group.visititems(visit)
    return datasets
