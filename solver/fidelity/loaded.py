"""Rich packages with the quasi-static response to the loads that a base motion leaves on them."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from ..dynamics.linear_bodies import without_second_order
from ..math.arrays import Array, IntArray
from ..mechanism import BuiltMechanism, build
from ..package import ModalPackage
from ..package.body.transform import rigid
from ..run.outcome import RunSpec
from .base import Base
from .further import Further
from .model import Rich
from .responding import by_body, linear, quasi_static, responding, telling_times, with_modes
from .response import modal_loads


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
