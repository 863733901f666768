"""Gear pair: two rotations in a fixed ratio."""

from .contract import Coupling, Number

GEAR_PAIR = Coupling(
    kind="gear_pair",
    meaning="two rotations in a fixed ratio",
    units=("rad", "rad"),
    keys=(
        Number(
            "ratio",
            "",
            "rotation of the first joint over that of the second; negative: they turn in "
            "opposite directions, as two outer gears do",
            required=True,
            not_zero=True,
        ),
    ),
    ratios=lambda values: (1.0, -values["ratio"]),
    unit="rad",
    order=1,
)
