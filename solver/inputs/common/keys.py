"""Fields of a table from the keys that the file of a kind declares."""

from typing import Annotated, Any

from pydantic import AfterValidator, Field
from pydantic.fields import FieldInfo

from ...math.keys import Number
from .table import unit


def _not_zero(value: float | None) -> float | None:
    if value == 0.0:
        raise ValueError("expected a number other than 0")
    return value


def number_field(key: Number) -> tuple[Any, FieldInfo]:
    """Return type and field of a number, as `create_model` takes them."""
    default: Any = ... if key.required else key.default
    number: FieldInfo = Field(
        default=default,
        gt=key.above,
        ge=key.least,
        le=key.most,
        description=key.meaning,
        json_schema_extra=unit(key.unit),
    )
    kind: Any = int if key.integer else float
    if default is None:
        kind = kind | None
    return (Annotated[kind, AfterValidator(_not_zero)] if key.not_zero else kind), number
