"""Rack: a rotation of one joint moves another one along."""

from .contract import Coupling, Number

RACK = Coupling(
    kind="rack",
    meaning="a pinion that moves a rack along",
    units=("rad", "m"),
    keys=(
        Number(
            "radius",
            "m",
            "of the pinion; negative: a positive rotation moves the rack back",
            required=True,
            not_zero=True,
        ),
    ),
    ratios=lambda values: (-values["radius"], 1.0),
    unit="m",
    order=4,
)
