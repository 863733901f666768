"""Belt: two rotations by pulleys of given radii."""

from .contract import Coupling, Number

BELT = Coupling(
    kind="belt",
    meaning="two rotations by a belt that does not slip",
    units=("rad", "rad"),
    keys=(
        Number("radius_1", "m", "of the pulley of the first joint", required=True, above=0.0),
        Number(
            "radius_2",
            "m",
            "of the pulley of the second joint; negative: the belt is crossed",
            required=True,
            not_zero=True,
        ),
    ),
    ratios=lambda values: (values["radius_1"], -values["radius_2"]),
    unit="m",
    order=2,
)
