"""A cantilever of unit length, EI and mass per length about a hub: Bernoulli's beam, no stretch."""

from scenes import unit_beam, unit_matrices

matrices = unit_matrices(1e8, 1e-10)


def table(modes: int) -> dict:
    """The case, with a number of flap modes."""
    found = unit_beam([{"kind": "bending-xz", "count": modes}], x2_axis=[0.0, 1.0, 0.0])
    hub = {"kind": "revolute", "between": ["ground.wall", "beam.root"], "axis": [0.0, 0.0, 1.0]}
    found["joints"] = {"hub": hub | {"drive": {"speed": 6.0}}}
    return found
