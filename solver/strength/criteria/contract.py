"""Contract of a failure criterion: what its file supplies.

A criterion is one file of this folder with an object of class `Criterion`; table.py finds it.
It is then evaluated for every material with strengths of its kind: in sections and shells
(`plymotion section`, `plymotion shell`), and in the bodies of a run (`strength` of summary.json,
warning `ply-failure`). CONTRIBUTING.md has the recipe.

    assess(stress_M, strength) -> Verdict

takes stresses (..., 6) [Pa], components 11, 22, 33, 23, 13, 12 in material axes, 1 along the
fibre, 3 normal to the ply; of an isotropic material in any axes. The exposure of a verdict is 1 /
R, with R the smallest factor on the stress at which it fails. It is proportional to the stress, and
0 without stress. `exposure` and `governing` of ray.py compute it from quadratic conditions.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from ...math.arrays import Array
from ...package.common.strengths import PlyStrength, YieldStrength
from .ray import Verdict

Assess = Callable[[Array, Any], Verdict]


@dataclass(frozen=True)
class Criterion:
    """A failure criterion.

    Attributes
    ----------
    name : in results and messages
    strength : class of its second argument, the strengths (package/common/strengths.py)
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
