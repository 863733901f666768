"""Rich packages with the quasi-static response to the loads that a base motion leaves on them."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from ..math.arrays import Array
from ..mechanism import build
from ..package import ModalPackage
from ..package.body.transform import rigid
from ..run.outcome import RunSpec
from .base import Base
from .model import Rich, with_values
from .response import elastic_columns, modal_loads


def loaded(
    spec: RunSpec,
    base: Base,
    packages: Mapping[str, ModalPackage],
    fixed: Mapping[str, ModalPackage],
) -> dict[str, Rich]:
    """Return rich packages, by body, with their response along the base; `fixed` are the others."""
    mine = {**fixed, **packages}
    built = build(linear(spec), mine)
    p = modal_loads(base, built.model)
    columns = dict(zip(built.body_names, elastic_columns(built.model), strict=False))
    return {
        name: Rich(package, _quasi_static(package, p[:, columns[name]]))
        for name, package in packages.items()
    }


def _quasi_static(package: ModalPackage, p: Array) -> Array:
    return np.asarray(np.linalg.solve(package.stiffness, p.T).T)


def fixed_packages(spec: RunSpec, base: Base, names: list[str]) -> dict[str, ModalPackage]:
    """Return the packages of flexible bodies that a plan is not about, as the base has them."""
    return {
        name: spec.packages[name] if base.model.n_mode[i] else rigid(spec.packages[name])
        for i, name in enumerate(spec.mechanism.bodies)
        if name in spec.packages and name not in names
    }


def linear(spec: RunSpec, *, stiffening: bool = False) -> Any:
    """Return the mechanism of a run with geometric stiffening or without."""
    solver = with_values(spec.mechanism.solver, geometric_stiffening=stiffening)
    return with_values(spec.mechanism, solver=solver)
