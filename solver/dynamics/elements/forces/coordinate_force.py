"""Force along a coordinate, given by an expression of a case."""

from .contract import CoordinateForce, Expression, Terms

COORDINATE_FORCE = CoordinateForce(
    kind="coordinate_force",
    turns=False,
    meaning="a force along a coordinate, by an expression",
    keys=(
        Expression(
            "expression",
            "N or N m",
            "force that pushes the coordinate up; reads `x`, its rate `v`, `t` and more, see "
            "expressions.md",
            required=True,
        ),
    ),
    terms=lambda values: Terms("expression"),
    order=4,
)
