"""Contract of a failure criterion: what its file supplies.

A criterion is one file of this folder with an object of class `Criterion`; table.py finds it.
It is then evaluated for every material with strengths of its kind: in sections and shells
(`plymotion section`, `plymotion shell`), and in the bodies of a run (`strength` of summary.json,
warning `ply-failure`). CONTRIBUTING.md has the recipe.

    assess(stress_M, strength) -> Verdict

takes stresses (..., 6) [Pa], components 11, 22, 33, 23, 13, 12 in material axes, 1 along the
fibre, 3 normal to the ply; of an isotropic material in any axes. The exposure of a verdict is 1 /
R, with R the smallest factor on the stress at which it fails. It is proportional to the stress, and
0 without stress. `exposure` and `governing` compute it from quadratic conditions.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ...math.arrays import Array, IntArray
from ...math.records import record
from ...package.common.materials import PlyStrength, YieldStrength


@record
class Verdict:
    """Result of a criterion for stresses (..., 6); the arrays have the shape (...)."""

    exposure: Array  # 1 / R: 0 without stress, 1 at failure, proportional to the stress [-]
    index: Array  # value of the governing condition, 1 at failure [-]
    shares: Array  # (..., n) of the n `modes`: that of the largest share governs
    modes: tuple[str, ...]

    @property
    def mode(self) -> IntArray:
        """Number of the mode that governs; a search asks for it at one point of many."""
        return np.argmax(np.nan_to_num(self.shares), axis=-1)

    @property
    def ratio(self) -> Array:
        """Strength ratio R: failure at R times the stress; margin of safety R - 1."""
        with np.errstate(divide="ignore", over="ignore"):
            return np.asarray(1.0 / self.exposure)


def exposure(quadratic: Array, linear: Array) -> Array:
    """1 / R of the condition quadratic R^2 + linear R = 1; 0 if no R > 0 fulfils it.

    Of two positive solutions, the smaller R is used. Both branches avoid the difference of nearly
    equal numbers.
    """
    a, b = np.asarray(quadratic, dtype=float), np.asarray(linear, dtype=float)
    under = b * b + 4.0 * a
    root = np.sqrt(np.maximum(under, 0.0))
    with np.errstate(divide="ignore", invalid="ignore"):
        factor = np.where(b >= 0.0, 0.5 * (b + root), 2.0 * a / (root - b))
    return np.asarray(np.where((under < 0.0) | ((a <= 0.0) & (b <= 0.0)), 0.0, factor))


def governing(modes: tuple[str, ...], exposures: list[Array], indices: list[Array]) -> Verdict:
    """The condition of the highest exposure at every point.

    Parameters
    ----------
    modes : names of the conditions
    exposures : exposure of each condition, arrays of one shape
    indices : failure index of each condition, arrays of that shape
    """
    highest, index = exposures[0], indices[0]
    for one, own in zip(exposures[1:], indices[1:], strict=True):
        index = np.where(one > highest, own, index)
        highest = np.maximum(highest, one)
    return Verdict(highest, index, np.stack(exposures, axis=-1), modes)


Assess = Callable[[Array, Any], Verdict]


class Criterion(NamedTuple):
    """A failure criterion.

    Attributes
    ----------
    name : in results and messages
    strength : class of its second argument, the strengths (package/common/materials.py)
    assess : see above
    convex_bound : f(stress_M, strength) -> (...), convex in the stress, proportional to it and
     never below the exposure. The search over a history uses it to exclude most points and times
     (search.py). None: the exposure itself is convex
    order : position in lists and results; criteria of equal order are sorted by name
    """

    name: str
    strength: type[PlyStrength] | type[YieldStrength]
    assess: Assess
    convex_bound: Callable[[Array, Any], Array] | None = None
    order: int = 100

    def bound(self, stress_M: Array, strength: Any) -> Array:
        """Return the convex bound of the exposure, (...)."""
        if self.convex_bound is None:
            return self.assess(stress_M, strength).exposure
        return self.convex_bound(stress_M, strength)
