"""Contract of a motion of a place, a kind of signal: what its file supplies.

A motion is one file of this folder with an object of class `Motion`; table.py finds it. Cases then
have it as `kind` of `[signals.NAME]` with `at` and `component`; checks, messages, reference page,
figures and differences of signals follow. CONTRIBUTING.md has the recipe.
"""

from collections.abc import Callable
from typing import Any, NamedTuple, Protocol

from ....math.arrays import Array


class Places(Protocol):
    """Motion of markers at k times, global: what a motion is made from (Recording has it)."""

    model: Any  # arrays of the mechanism, as model.gravity_G (3,) [m/s2]
    t: Array  # (k,) [s]

    def position(self, marker: int) -> Array:
        """Return the origin (k, 3) [m]."""

    def axes(self, marker: int) -> Array:
        """Return the axes in columns (k, 3, 3)."""

    def velocity(self, marker: int) -> Array:
        """Return the velocity of the origin (k, 3) [m/s]."""

    def spin(self, marker: int) -> Array:
        """Return the angular velocity (k, 3) [rad/s]."""

    def acceleration(self, marker: int) -> Array:
        """Return the acceleration of the origin (k, 3) [m/s2]."""


class Motion(NamedTuple):
    """A motion of a place.

    Attributes
    ----------
    kind : name in the case file
    meaning : words of the reference page, with the axes of the components
    unit : of the values
    vectors : f(places, marker) -> (k, 3); `marker` has the place and the axes of the
     interface, which are parallel to the global axes at the start
    order : position in lists; motions of equal order are sorted by kind
    """

    kind: str
    meaning: str
    unit: str
    vectors: Callable[[Places, int], Array]
    order: int = 100
