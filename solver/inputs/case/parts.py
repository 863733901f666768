"""A checked mechanism in the bodies that are built: beams of several segments are divided."""

from .body_specs import BodySpec, BodySpecs
from .check import cross_check
from .schema import Mechanism
from .segments import in_segments


def in_parts(
    mechanism: Mechanism, specs: BodySpecs
) -> tuple[Mechanism, dict[str, BodySpec], list[str]]:
    """Return the mechanism with divided beams, its flexible bodies, and one line per finding."""
    bodies, found = cross_check(mechanism, specs)
    divided = mechanism if found else in_segments(mechanism)
    if divided is not mechanism:
        bodies, found = cross_check(divided, specs)
    return divided, bodies, found
