"""Fields of a table from the keys that the file of a kind declares (math/keys.py)."""

from collections.abc import Mapping
from typing import Annotated, Any, Literal, TypeVar

from pydantic import AfterValidator, Field, create_model
from pydantic.fields import FieldInfo

from ...math.keys import Code, Curve, Direction, Expression, Expressions, Number, OfTime, Three
from ..common.table import Table, Vector, unit
from .curves import CurveTable
from .laws import LoadLaw
from .python_code import PythonCode

Kind = TypeVar("Kind", bound=Table)
Z = [0.0, 0.0, 1.0]
NONE = [0.0, 0.0, 0.0]


def _of_some_length(vector: list[float]) -> list[float]:
    if not any(vector):
        raise ValueError("expected a vector of non-zero length")
    return vector


def _not_zero(value: float | None) -> float | None:
    if value == 0.0:
        raise ValueError("expected a number other than 0")
    return value


GlobalDirection = Annotated[Vector, AfterValidator(_of_some_length)]
Constants = Annotated[list[Annotated[float, Field(ge=0)]], Field(min_length=3, max_length=3)]


Key = Number | Three | Direction | OfTime | Expression | Expressions | Curve | Code


def table_of(
    base: type[Kind], group: str, kind: str, meaning: str, fields: Mapping[str, Any]
) -> type[Kind]:
    """Return the table `[group.NAME]` of one kind: the keys of `base` and its own fields."""
    text = f'`[{group}.NAME]` with kind = "{kind}": {meaning}'
    name = f"{kind.title().replace('_', '')}{group.removesuffix('s').title()}"
    own: dict[str, Any] = {"kind": (Literal[kind], ...), **fields}
    return create_model(name, __base__=base, __doc__=text, **own)


def field_of(key: Key) -> tuple[Any, FieldInfo]:
    """Return type and field of a key, as `create_model` takes them."""
    if isinstance(key, Number):
        return _number(key)
    default: Any = None
    if isinstance(key, Expressions):
        texts: FieldInfo = Field(min_length=1, description=key.meaning)
        return list[str], texts
    if isinstance(key, Code):
        code: FieldInfo = Field(description=key.meaning)
        return PythonCode, code
    if isinstance(key, Curve):
        points: FieldInfo = Field(
            default=default, description=key.meaning, json_schema_extra=unit(key.unit)
        )
        return CurveTable | None, points
    if isinstance(key, Expression):
        given: Any = ... if key.required else key.default
        text: FieldInfo = Field(
            default=given, description=key.meaning, json_schema_extra=unit(key.unit)
        )
        return (str | None if given is None else str), text
    if isinstance(key, OfTime):
        return LoadLaw | None, Field(default=default, description=key.meaning)
    if isinstance(key, Three):
        kind, symbol, default = Constants, key.unit, NONE
    else:
        kind, symbol = GlobalDirection, "-"
        default = None if key.absent else Z
    default = ... if key.required else default
    found: FieldInfo = Field(
        default=default, description=key.meaning, json_schema_extra=unit(symbol)
    )
    return (kind | None if default is None else kind), found


def _number(key: Number) -> tuple[Any, FieldInfo]:
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
