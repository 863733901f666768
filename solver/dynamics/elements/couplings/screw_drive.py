"""Screw drive: a rotation of one joint moves another one along."""

from math import pi

from .contract import Coupling, Number

SCREW_DRIVE = Coupling(
    kind="screw_drive",
    meaning="a rotation that moves another joint along, as spindle and nut",
    units=("rad", "m"),
    keys=(
        Number(
            "lead",
            "m",
            "displacement of the second joint for one turn of the first; negative: left-handed",
            required=True,
            not_zero=True,
        ),
    ),
    ratios=lambda values: (-values["lead"] / (2.0 * pi), 1.0),
    unit="m",
    order=3,
)
