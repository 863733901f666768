"""The base of every table that a user writes."""

from typing import Annotated, Any

from pydantic import AfterValidator, BaseModel, ConfigDict, Field

from ...errors import printable


def usable_path(text: str) -> str:
    """Return a path. Raises ValueError if no message could show it in one line."""
    if not text or printable(text) != text:
        raise ValueError("expected a path without control characters")
    return text


# Names become those of files, beside which temporary ones need room.
Name = Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9_-]*$", max_length=100)]
Word = Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9_]*$")]  # of an expression
Pair = Annotated[list[float], Field(min_length=2, max_length=2)]
FilePath = Annotated[str, AfterValidator(usable_path)]
Vector = Annotated[list[float], Field(min_length=3, max_length=3)]


class Table(BaseModel):
    """A table of an input file: unknown keys are errors; true, false and "1" are no numbers.

    Validators are built when a table is first read: a command reads few of the many tables.
    """

    model_config = ConfigDict(
        extra="forbid", allow_inf_nan=False, frozen=True, strict=True, defer_build=True
    )


def plain_table(table: BaseModel) -> Any:
    """Return a table as plain data; keys that are absent and have no default are left out."""
    return table.model_dump(exclude_none=True)


def unit(name: str) -> dict[str, Any]:
    """Return the unit of a key for the reference page."""
    return {"unit": name}
