"""Signals made of other signals: a difference, also to another run, and a norm."""

from typing import Literal, Self

from pydantic import Field, model_validator

from ..common.table import Name, Table

RUN = (
    "name of another run, whose values at the same times are subtracted; in a sweep with the same "
    "changes. NaN after that run has ended"
)


class Measured(Table):
    """Keys of every signal."""

    divide_by: float | None = Field(
        default=None, gt=0, description="makes the signal dimensionless (in its unit)"
    )
    description: str = Field(default="", description="words for figures and tables")


class DifferenceSignal(Measured):
    """`[signals.NAME]` with kind = "difference": a signal minus another, or minus another run."""

    kind: Literal["difference"]
    of: Name = Field(description="name of a signal")
    minus: Name | None = Field(
        default=None, description="name of the signal that is subtracted; absent: `of`"
    )
    run: Name | None = Field(default=None, description=RUN)

    @model_validator(mode="after")
    def _of_two(self) -> Self:
        if self.minus is None and self.run is None:
            raise ValueError("expected `minus`, `run` or both")
        return self


class NormSignal(Measured):
    """`[signals.NAME]` with kind = "norm": square root of the sum of squares of signals."""

    kind: Literal["norm"]
    of: list[Name] = Field(min_length=1, description="names of signals of one unit")
    run: Name | None = Field(default=None, description=f"of their differences to it: {RUN}")
