"""Modes that respond to loads; rich packages with the quasi-static response of a base motion."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any

import numpy as np

from ....dynamics.evaluation.variations import residuals
from ....dynamics.model.model import Model
from ....math.arrays import Array, IntArray
from ....mechanism.build import build
from ....mechanism.built import BuiltMechanism
from ....package import ModalPackage
from ....package.body.selection import changed_basis, rigid
from ....run.inputs import RunSpec
from ..plan import FAINT, Base, Rich, energy, with_values
from .response import elastic_columns, embedded, modal_loads, samples


def responding(
    packages: Mapping[str, ModalPackage], loads: Mapping[str, Array]
) -> dict[str, IntArray]:
    """Return the modes that respond to loads (k, m) by body, of those in `packages`."""
    size = {
        name: np.sqrt(np.diag(package.stiffness))
        * np.abs(quasi_static(package, loads[name])).max(axis=0, initial=0.0)
        for name, package in packages.items()
    }
    largest = max((float(s.max(initial=0.0)) for s in size.values()), default=0.0)
    return {name: np.flatnonzero(s > FAINT * largest) for name, s in size.items()}


def with_modes(
    packages: Mapping[str, ModalPackage], modes: Mapping[str, IntArray]
) -> dict[str, ModalPackage]:
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


def linear(spec: RunSpec, *, stiffening: bool = False) -> Any:
    """Return the mechanism of a run with geometric stiffening or without."""
    solver = with_values(spec.mechanism.solver, geometric_stiffening=stiffening)
    return with_values(spec.mechanism, solver=solver)


PROBES = 4  # output times at which the modes that the loads act on are found


@dataclass(frozen=True)
class Further:
    """Response to the loads that deformation adds, of all bodies.

    The rich mechanism is put into the shape of the quasi-static response. What the base motion
    leaves there on the modes deforms the bodies further; the same again from this shape. The
    loads across a body under tension differ from all those of the base motion.

    Attributes
    ----------
    packages : of all bodies
    eta : quasi-static response (k, m), by body
    modes : those that respond to the base motion, by body
    """

    spec: RunSpec
    base: Base
    packages: Mapping[str, ModalPackage]
    eta: Mapping[str, Array]
    modes: Mapping[str, IntArray]

    def of(self, name: str) -> Array:
        """Return the further response of a body (s, m), of the size of s output times."""
        return self._all[name]

    @cached_property
    def _all(self) -> dict[str, Array]:
        rows = samples(self.base)
        modes = self._responding(rows)
        packages = with_modes({n: self.packages[n] for n in modes}, modes)
        built = build(linear(self.spec, stiffening=True), {**self.packages, **packages})
        q = {name: self.eta[name][np.ix_(rows, kept)] for name, kept in modes.items()}
        found: dict[str, list[Array]] = {name: [] for name in modes}
        for _ in range(2):
            left = by_body(built, self._left(built, rows, q))
            for name, package in packages.items():
                change = quasi_static(package, left[name])
                size = energy(package, change)
                change *= min(1.0, energy(package, q[name]) / max(size, 1e-300))
                found[name].append(change)
                q[name] = q[name] + change
        # As many output times as in the response of the base motion.
        weight = np.sqrt(len(self.base.t) / len(rows))
        out = {}
        for name, kept in modes.items():
            out[name] = np.zeros((2 * len(rows), self.packages[name].n_mode))
            out[name][:, kept] = weight * np.concatenate(found[name])
        return out

    def _responding(self, rows: IntArray) -> dict[str, IntArray]:
        """Return the modes that respond to the base motion or to the loads that it adds.

        Stretching of a beam that bends alone, for instance. The cost of these loads grows with the
        fourth power of the number of modes.
        """
        if all(len(kept) == self.packages[name].n_mode for name, kept in self.modes.items()):
            return dict(self.modes)
        built = build(linear(self.spec, stiffening=True), dict(self.packages))
        mine = {name: self.packages[name] for name in self.modes}
        bent = np.zeros(len(rows))
        for name, package in mine.items():
            q = self.eta[name][rows]
            bent += ((q @ package.stiffness) * q).sum(axis=1)
        some = rows[np.argsort(-bent, kind="stable")[:PROBES]]
        left = self._left(built, some, {name: self.eta[name][some] for name in mine})
        more = responding(mine, by_body(built, left))
        return {name: np.union1d(kept, more[name]) for name, kept in self.modes.items()}

    def _left(self, built: BuiltMechanism, rows: IntArray, q: Mapping[str, Array]) -> Array:
        """Return what the base motion leaves (s, n_vel) at output times with modes q (s, m)."""
        base, model = self.base, built.model
        y, accelerations = (part[rows] for part in embedded(base, model))
        for i, name in enumerate(built.body_names):
            if name in q:
                first = int(model.pos_start[i]) + 7
                y[:, first : first + q[name].shape[1]] = q[name]
        return residuals(model, base.t[rows], y, accelerations, base.multipliers[rows])


def without_second_order(model: Model) -> Model:
    """Return a model with the same bodies without geometric stiffening, sharing all other tables.

    The same as to assemble it again, at a fraction of the time.
    """
    nothing, none = np.zeros(0), np.zeros(model.n_body + 1, dtype=np.int64)
    return model._replace(
        second_start=none,
        third_start=none,
        fourth_start=none,
        Z=nothing,
        Z_used=np.zeros_like(model.Z_used),
        G3=nothing,
        G4=nothing,
        marker_second=np.full_like(model.marker_second, -1),
        marker_H=nothing,
        marker_H_used=np.zeros_like(model.marker_H_used),
        carried_start=none,
        carried_marker=np.zeros(0, dtype=np.int64),
        carried_mass=nothing,
    )


@dataclass(frozen=True)
class Loaded:
    """Rich packages with their response, and the mechanism with the modes that respond.

    Attributes
    ----------
    built : linear
    stiffened : the same with geometric stiffening; None if no body has second-order data
    modes : rows of the package whose modes are in `built`, by body
    p : (k, n_vel) loads that the base motion leaves in `built`
    """

    rich: dict[str, Rich]
    built: BuiltMechanism
    stiffened: BuiltMechanism | None
    modes: dict[str, IntArray]
    p: Array


def loaded(
    spec: RunSpec,
    base: Base,
    packages: Mapping[str, ModalPackage],
    fixed: Mapping[str, ModalPackage],
) -> Loaded:
    """Return rich packages, by body, with their response along the base; `fixed` are the others.

    Modes that do not respond, as those across the plane of a planar motion, have zeros there.
    """
    mine = {**fixed, **packages}
    built, stiffened = build(linear(spec), mine), None
    left = modal_loads(base, built.model, telling_times(base))
    modes = responding(packages, by_body(built, left))
    fewer = with_modes(packages, modes)
    if any(package.second_order is not None for package in fewer.values()):
        stiffened = build(linear(spec, stiffening=True), {**fixed, **fewer})
        built = replace(stiffened, model=without_second_order(stiffened.model))
    elif any(fewer[name] is not packages[name] for name in packages):
        built = build(linear(spec), {**fixed, **fewer})
    p = modal_loads(base, built.model)
    on = by_body(built, p)
    eta = {name: np.zeros((len(p), package.n_mode)) for name, package in packages.items()}
    for name, package in fewer.items():
        eta[name][:, modes[name]] = quasi_static(package, on[name])
    further = Further(spec, base, mine, eta, modes)
    rich = {n: Rich(package, eta[n], partial(further.of, n)) for n, package in packages.items()}
    return Loaded(rich, built, stiffened, modes, p)


def fixed_packages(spec: RunSpec, base: Base, names: list[str]) -> dict[str, ModalPackage]:
    """Return the packages of flexible bodies that a plan is not about, as the base has them."""
    return {
        name: spec.packages[name] if base.model.n_mode[i] else rigid(spec.packages[name])
        for i, name in enumerate(spec.mechanism.bodies)
        if name in spec.packages and name not in names
    }
