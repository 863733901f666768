"""The base of every table that a user writes."""

from typing import Annotated, Any

from pydantic import AfterValidator, BaseModel, ConfigDict, Field

from ...errors import printable


def usable_path(text: str) -> str:
    """Return a path. Raises ValueError if no message could show it in one line."""
    if not text or printable(text) != text:
        raise ValueError("expected a path without control characters")
    return text


def _of_some_length(vector: list[float]) -> list[float]:
    if not any(vector):
        raise ValueError("expected a vector of non-zero length")
    return vector


# Names become those of files, beside which temporary ones need room.
Name = Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9_-]*$", max_length=100)]
Word = Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9_]*$")]  # of an expression
Pair = Annotated[list[float], Field(min_length=2, max_length=2)]
FilePath = Annotated[str, AfterValidator(usable_path)]
Vector = Annotated[list[float], Field(min_length=3, max_length=3)]
Axis = Annotated[Vector, AfterValidator(_of_some_length)]


def entry(meaning: str, unit: str = "", default: Any = ..., **bounds: Any) -> Any:
    """Return a key of a table.

    Parameters
    ----------
    meaning : one line
    unit : in which a number is given
    default : of an optional key
    bounds : of pydantic's Field: gt, ge, lt, le, min_length, max_length, alias
    """
    extra: Any = {"unit": unit} if unit else None
    return Field(default=default, description=meaning, json_schema_extra=extra, **bounds)


def optional(meaning: str, unit: str = "", **bounds: Any) -> Any:
    """Return a key that may be absent, without a default; see `entry`."""
    return entry(meaning, unit, None, **bounds)


class Table(BaseModel):
    """A table of an input file: unknown keys are errors; true, false and "1" are no numbers.

    Validators are built when a table is first read: a command reads few of the many tables.
    """

    model_config = ConfigDict(
        extra="forbid", allow_inf_nan=False, frozen=True, strict=True, defer_build=True
    )


class Oriented(Table):
    """Reference point and axes of an interface."""

    position: Vector | None = optional(
        "reference point in the body frame; absent: centre of the group or faces", "m"
    )
    rotation_deg: Vector = entry(
        "rotation vector from body to interface axes", "deg", [0.0, 0.0, 0.0]
    )


class Around(Table):
    """`axis_about`: directions around an axis."""

    point: Vector = entry("on the axis", "m")
    direction: Axis = entry("of the axis, of any length", "-")


def plain_table(table: BaseModel) -> Any:
    """Return a table as plain data; keys that are absent and have no default are left out."""
    return table.model_dump(exclude_none=True)
