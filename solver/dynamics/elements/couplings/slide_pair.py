"""Slide pair: two displacements in a fixed ratio."""

from .contract import Coupling, Number

SLIDE_PAIR = Coupling(
    kind="slide_pair",
    meaning="two displacements in a fixed ratio, as the fingers of a gripper",
    units=("m", "m"),
    keys=(
        Number(
            "ratio",
            "",
            "displacement of the first joint over that of the second",
            required=True,
            not_zero=True,
        ),
    ),
    ratios=lambda values: (1.0, -values["ratio"]),
    unit="m",
    order=5,
)
