"""Contract of a motion of a place, a kind of signal: what its file supplies.

A motion is one file of this folder with an object of class `Motion`; table.py finds it. Cases then
have it as `kind` of `[signals.NAME]` with `at` and `component`; checks, messages, reference page,
figures and differences of signals follow. CONTRIBUTING.md has the recipe.
"""

from collections.abc import Callable
from dataclasses import dataclass

from ....math.arrays import Array
from ..recovery import Recording


@dataclass(frozen=True)
class Motion:
    """A motion of a place.

    Attributes
    ----------
    kind : name in the case file
    meaning : words of the reference page, with the axes of the components
    unit : of the values
    vectors : f(recording, marker) -> (k, 3) at the times of a recording; `marker` has the place and
     the axes of the interface, which are parallel to the global axes at the start
    order : position in lists; motions of equal order are sorted by kind
    """

    kind: str
    meaning: str
    unit: str
    vectors: Callable[[Recording, int], Array]
    order: int = 100
