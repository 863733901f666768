"""Which modes respond to loads, and the mechanism with these alone."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from ....math.arrays import Array, IntArray
from ....mechanism import BuiltMechanism
from ....package import ModalPackage
from ....package.body.transform import changed_basis
from ....run.outcome import RunSpec
from ..base.base import Base
from ..base.model import FAINT, with_values
from .response import elastic_columns, samples


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
