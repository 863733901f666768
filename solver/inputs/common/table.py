"""The base of every table that a user writes, and pydantic's errors as messages.

A message has one line: file, key, value, expectation.
"""

import re
from types import UnionType
from typing import Annotated, Any, Literal, TypeVar, Union, get_args, get_origin

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, Tag, ValidationError

from ...errors import InputError, did_you_mean, nearest, printable


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


Model = TypeVar("Model", bound=BaseModel)
_WORDS = {"model_type": "expected a table", "dict_type": "expected a table"}
_DECIMAL = re.compile(r"0\.0{6,}\d+")  # a limit like 1e-30, which pydantic writes out
_WORDS |= {"model_attributes_type": "expected a table", "list_type": "expected a list"}


def lines(error: ValidationError, model: type[BaseModel], where: str) -> list[str]:
    """Return one message per finding of `error`, sorted; `where` names file and run."""
    return [f"{where}: {line}" for line in bare_lines(error, model)]


def validated(model: type[Model], table: Any, where: object, **context: Any) -> Model:
    """Return a table as its model.

    Parameters
    ----------
    where : names the file in messages
    context : of validators

    Raises
    ------
    InputError
        One line per error: file, key, value, expectation.
    """
    try:
        return model.model_validate(table, context=context)
    except ValidationError as error:
        raise InputError("\n".join(lines(error, model, str(where)))) from error


def bare_lines(error: ValidationError, model: type[BaseModel]) -> list[str]:
    """Return the same without a file: messages that begin with the key."""
    return sorted({_line(item, model) for item in error.errors()})


def _line(item: Any, model: type[BaseModel]) -> str:
    path, kind = follow(model, item["loc"])
    key = printable(".".join(str(part) for part in path))
    if item["type"] == "extra_forbidden":
        _, table = follow(model, item["loc"][:-1])
        return f"{key}: unknown key{nearest(str(path[-1]), _keys(table))}"
    if item["type"] == "missing":
        return f"{key}: missing; expected {_expected(path, kind)}"
    if item["type"] in ("union_tag_not_found", "union_tag_invalid"):
        discriminator = str(item["ctx"]["discriminator"]).strip("'()")
        choices = members(kind)
        tags = sorted(t for t, m in choices.items() if discriminator in m.model_fields)
        expected = "expected one of " + ", ".join(f'"{tag}"' for tag in tags)
        expected += "".join(f", or the key {tag}" for tag in choices if tag not in tags)
        if item["type"] == "union_tag_not_found":
            return f"{key}.{discriminator}: missing; {expected}"
        value = item["ctx"]["tag"]
        hint = nearest(value, tags)
        hint = hint if hint.startswith("; did") else ""
        return f'{key}.{discriminator} = "{value}": {expected}{hint}'
    text = _WORDS.get(item["type"], item["msg"]).removeprefix("Value error, ")
    text = _DECIMAL.sub(lambda m: f"{float(m[0]):g}", text[0].lower() + text[1:])
    if not path:  # a contradiction of the whole file, whose text names the keys
        return text
    hint = did_you_mean(str(item["input"]), get_args(kind)) if _one_of_words(kind) else ""
    return f"{key} = {_short(item.get('input'))}: {text.replace('input', 'value')}{hint}"


def _expected(path: list[Any], kind: Any) -> str:
    """Return what a missing key should have: a table, named tables or a value."""
    named = get_origin(kind) is dict
    if not named and not (isinstance(kind, type) and issubclass(kind, BaseModel)):
        return "a value"
    if not all(isinstance(part, str) for part in path):  # in a list
        return "a table"
    return f"a table [{printable('.'.join(path))}{'.NAME' if named else ''}]"


def _one_of_words(kind: Any) -> bool:
    return get_origin(kind) is Literal and all(isinstance(word, str) for word in get_args(kind))


def _short(value: Any) -> str:
    try:
        text = f'"{printable(value)}"' if isinstance(value, str) else repr(value)
    except ValueError:  # an integer, or a list of one, in thousands of digits
        return "a number of thousands of digits"
    return text if len(text) < 60 else text[:57] + "..."


def follow(model: Any, location: tuple[Any, ...]) -> tuple[list[Any], Any]:
    """Return the keys of a location as the user wrote them, and the type at this location.

    pydantic inserts the names of union members between the keys; they are removed.
    """
    path: list[Any] = []
    kind = without_annotations(model)
    for part in location:
        named = members(kind)
        if named:  # the name of a union's member, no key
            kind = without_annotations(named.get(part))
            continue
        path.append(part)
        origin, arguments = get_origin(kind), get_args(kind)
        if isinstance(kind, type) and issubclass(kind, BaseModel):
            field = kind.model_fields.get(str(part))
            kind = without_annotations(field.annotation) if field is not None else None
        elif origin is dict:
            kind = without_annotations(arguments[1])
        elif origin is list:
            kind = without_annotations(arguments[0])
        else:
            kind = None
    return path, kind


def without_annotations(kind: Any) -> Any:
    """Return a type without annotations and without "or None"."""
    if get_origin(kind) is Annotated:
        return without_annotations(get_args(kind)[0])
    if get_origin(kind) in (Union, UnionType):
        rest = [a for a in get_args(kind) if a is not type(None)]
        if len(rest) == 1:
            return without_annotations(rest[0])
    return kind


def members(kind: Any) -> dict[Any, Any]:
    """Return the members of a union by the names that pydantic gives them; empty for no union."""
    if get_origin(kind) not in (Union, UnionType):
        return {}
    found: dict[Any, Any] = {}
    for member in get_args(kind):
        names = [a.tag for a in getattr(member, "__metadata__", ()) if isinstance(a, Tag)]
        bare = without_annotations(member)
        if not names and isinstance(bare, type) and issubclass(bare, BaseModel):
            tags = [f.annotation for n, f in bare.model_fields.items() if n in ("kind", "shape")]
            names = [name for tag in tags if get_origin(tag) is Literal for name in get_args(tag)]
        found.update(dict.fromkeys(names or [getattr(bare, "__name__", str(bare))], bare))
    return found


def _keys(kind: Any) -> list[str]:
    """Return the keys that are known in a table of this type."""
    known = isinstance(kind, type) and issubclass(kind, BaseModel)
    return sorted(f.alias or n for n, f in kind.model_fields.items()) if known else []
