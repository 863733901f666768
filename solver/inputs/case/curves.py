"""Curves y(x) in a case file."""

from typing import Any, Literal

from pydantic import Field, ValidationInfo, model_validator

from ...math.curves import Extrapolation, Interpolation, curve, curve_of_table
from ...math.packed import column
from ..common.table import FilePath, Table, unit
from .columns import Times
from .laws import with_columns


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
        curve(column(self.x), column(self.y))
        return self


class TablePoints(Table):
    """`[tables.NAME]`: a curve through points, which expressions call as `NAME(...)`."""

    file: FilePath | None = Field(
        default=None,
        description="instead of `x` and `y`: a text file of two columns, separated by commas; path "
        "relative to the case file",
    )
    x: Times | None = Field(default=None, description="ascending")
    y: Times | None = Field(default=None, description="as many as x")
    interpolation: Interpolation = Field(
        default="cubic",
        description="straight lines; a cubic spline; or a cubic without overshoot between points "
        "(pchip)",
    )
    extrapolation: Extrapolation = Field(
        default="linear", description="beyond both ends: straight on, or the value of the end"
    )

    @model_validator(mode="before")
    @classmethod
    def _from_file(cls, data: Any, info: ValidationInfo) -> Any:
        return with_columns(data, info, ("x", "y"))

    @model_validator(mode="after")
    def _usable(self) -> "TablePoints":
        if self.x is None or self.y is None:
            raise ValueError("expected `x` and `y`, or `file`")
        curve_of_table(column(self.x), column(self.y), self.interpolation, self.extrapolation)
        return self
