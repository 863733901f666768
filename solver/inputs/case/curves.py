"""Curves y(x) in a case file."""

from typing import Literal

from pydantic import Field, model_validator

from ...math.curves import curve
from ..common.table import Table, unit
from .laws import Times


class CurveTable(Table):
    """`force_displacement`, `force_velocity`: points of a curve.

    Beyond its ends it goes on straight.
    """

    x: Times = Field(description="ascending", json_schema_extra=unit("m, rad, m/s, rad/s"))
    y: Times = Field(description="as many as x", json_schema_extra=unit("N or N m"))
    interpolation: Literal["spline", "linear"] = Field(
        default="spline", description="cubic spline, or straight lines"
    )

    @model_validator(mode="after")
    def _usable(self) -> "CurveTable":
        curve(self.x, self.y)
        return self
