"""Response to the loads that deformation adds: of geometric stiffening and second order."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..dynamics.residual import residuals
from ..math.arrays import Array, IntArray
from ..mechanism import BuiltMechanism, build
from ..package import ModalPackage
from ..run.outcome import RunSpec
from .base import Base
from .model import energy
from .responding import by_body, linear, quasi_static, responding, with_modes
from .response import embedded, samples

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
