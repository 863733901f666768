"""Rich packages with the quasi-static response to the loads that a base motion leaves on them."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any

import numpy as np

from ..dynamics.residual import residuals
from ..math.arrays import Array
from ..mechanism import build
from ..package import ModalPackage
from ..package.body.transform import rigid
from ..run.outcome import RunSpec
from .base import Base
from .model import Rich, with_values
from .response import SAMPLES, elastic_columns, embedded, modal_loads


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
    eta = {name: _quasi_static(package, p[:, columns[name]]) for name, package in packages.items()}
    more = _Stiffened(spec, base, mine, eta)
    return {
        name: Rich(package, eta[name], partial(more.of, name)) for name, package in packages.items()
    }


@dataclass(frozen=True)
class _Stiffened:
    """Response to the loads that deformation adds: of geometric stiffening and second order.

    The rich mechanism is put into the shape of the quasi-static response. What the base motion
    leaves there on the modes deforms the bodies further; the same again from this shape. The
    loads across a body under tension differ from all those of the base motion.

    Attributes
    ----------
    packages : of all bodies
    eta : quasi-static response (k, m), by body
    """

    spec: RunSpec
    base: Base
    packages: Mapping[str, ModalPackage]
    eta: Mapping[str, Array]

    def of(self, name: str) -> Array:
        """Return the further response of a body (s, m), of the size of s output times."""
        return self._all[name]

    @cached_property
    def _all(self) -> dict[str, Array]:
        built = build(linear(self.spec, stiffening=True), dict(self.packages))
        model, base = built.model, self.base
        rows = np.unique(np.linspace(0, len(base.t) - 1, SAMPLES).astype(np.int64))
        states, accelerations = (part[rows] for part in embedded(base, model))
        at = {name: i for i, name in enumerate(built.body_names)}
        columns = elastic_columns(model)
        q = {name: eta[rows] for name, eta in self.eta.items()}
        found: dict[str, list[Array]] = {name: [] for name in self.eta}
        for _ in range(2):
            y = states.copy()
            for name, shape in q.items():
                first = int(model.pos_start[at[name]]) + 7
                y[:, first : first + shape.shape[1]] = shape
            left = residuals(model, base.t[rows], y, accelerations, base.multipliers[rows])
            for name, package in ((name, self.packages[name]) for name in q):
                change = _quasi_static(package, left[:, columns[at[name]]])
                size = _energy(package, change)
                change *= min(1.0, _energy(package, q[name]) / max(size, 1e-300))
                found[name].append(change)
                q[name] = q[name] + change
        # As many output times as in the response of the base motion.
        weight = np.sqrt(len(base.t) / len(rows))
        return {name: weight * np.concatenate(parts) for name, parts in found.items()}


def _energy(package: ModalPackage, q: Array) -> float:
    return float(np.sqrt(((q @ package.stiffness) * q).sum()))


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
