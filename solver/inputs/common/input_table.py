"""The base of every table that a user writes, and pydantic's errors as messages.

A message has one line: file, key, value, expectation.
"""

import re
from collections.abc import Iterable, Sequence
from functools import cache
from types import UnionType
from typing import Annotated, Any, ClassVar, Literal, Self, TypeVar, Union, get_args, get_origin

from annotated_types import MaxLen, MinLen
from pydantic import (
    AfterValidator,
    BaseModel,
    ConfigDict,
    Field,
    Tag,
    ValidationError,
    ValidationInfo,
    model_validator,
)
from pydantic.fields import FieldInfo

from ...errors import InputError, counted, few, nearest, printable
from .units import unit_of, with_metres


def usable_path(text: str) -> str:
    """Return a path. Raises ValueError if no message could show it in one line."""
    if not text or printable(text) != text:
        raise ValueError("expected a path without control characters")
    if len(text) > 1000 or max(map(len, text.encode().split(b"/"))) > 255:  # as Linux has them
        raise ValueError("expected at most 1000 characters, and 255 bytes in each name")
    return text


def _of_some_length(vector: list[float]) -> list[float]:
    if not any(vector):
        raise ValueError("expected a vector of non-zero length")
    return vector


# Names become those of files, beside which temporary ones need room.
NAME = "^[A-Za-z][A-Za-z0-9_"
Name = Annotated[str, Field(pattern=NAME + "-]*$", max_length=100)]
Word = Annotated[str, Field(pattern=NAME + "]*$")]  # of an expression
Pair = Annotated[list[float], Field(min_length=2, max_length=2)]
FilePath = Annotated[str, AfterValidator(usable_path)]
Vector = Annotated[list[float], Field(min_length=3, max_length=3)]
Axis = Annotated[Vector, AfterValidator(_of_some_length)]


MOST_KEYS = 12  # of a table that a message lists


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
    """Return a key that may be absent, without a default; see `entry`.

    Parameters
    ----------
    meaning : what the key means
    unit : its unit
    bounds : bounds of its value, as of `entry`
    """
    return entry(meaning, unit, None, **bounds)


class Table(BaseModel):
    """A table of an input file: unknown keys are errors; true, false and "1" are no numbers.

    Validators are built when a table is first read: a command reads few of the many tables.
    """

    model_config = ConfigDict(
        extra="forbid", allow_inf_nan=False, frozen=True, strict=True, defer_build=True
    )

    # Keys within that are lengths, such as "table.values", though not by their own unit.
    more_lengths: ClassVar[tuple[str, ...]] = ()
    one_of: ClassVar[tuple[str, ...]] = ()  # keys of which exactly one is given

    @model_validator(mode="before")
    @classmethod
    def _lengths_in_metres(cls, data: Any, info: ValidationInfo) -> Any:
        unit = unit_of(info)
        return data if unit == "m" else with_metres(data, unit, _lengths(cls))

    @model_validator(mode="after")
    def _one_is_given(self) -> Self:
        given = [key for key in self.one_of if getattr(self, key) is not None]
        if self.one_of and len(given) != 1:
            if len(self.one_of) == 2:
                raise ValueError("expected either `{}` or `{}`".format(*self.one_of))
            named = " and ".join(given) or "none"
            raise ValueError(f"expected one of {', '.join(self.one_of)}; found {named}")
        return self


def unit(field: FieldInfo) -> str:
    """Return the unit of a key, "" for none."""
    extra = field.json_schema_extra
    return str(extra.get("unit", "")) if isinstance(extra, dict) else ""


@cache
def _lengths(model: type[BaseModel]) -> list[str]:
    """Return the keys of a table that are lengths."""
    own = [f.alias or name for name, f in model.model_fields.items() if unit(f) == "m"]
    return [*own, *getattr(model, "more_lengths", ())]


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
FEW = 8  # words that a message lists
_DECIMAL = re.compile(r"0\.0{6,}\d+")  # a limit like 1e-30, which pydantic writes out
_WITH_UNIT = re.compile(r"[-+]?[\d.]+(e[-+]?\d+)? *[A-Za-zµ°%]+[A-Za-z\d/^*-]*")  # "70 GPa"


def lines(error: ValidationError, model: type[BaseModel], where: str) -> list[str]:
    """Return one message per finding of `error`, sorted; `where` names file and run.

    Parameters
    ----------
    error : error of pydantic
    model : model that was checked
    where : file and run
    """
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


def bare_lines(error: ValidationError, model: type[BaseModel], under: str = "") -> list[str]:
    """Return the same without a file: messages that begin with the key, `under` that of a table.

    Parameters
    ----------
    error : error of pydantic
    model : model that was checked
    under : path of the table that was checked
    """
    expected: dict[str, list[str]] = {}  # key and value: what is expected, by member of a union
    unknown: dict[tuple[Any, ...], list[str]] = {}  # table: keys that it does not have
    items = error.errors()
    for item in items:
        path, kind = follow(model, item["loc"])
        if item["type"] == "extra_forbidden":
            unknown.setdefault(item["loc"][:-1], []).append(str(path[-1]))
        elif not _is_whole(item, items):
            head, text = _line(item, model, path, kind)
            expected.setdefault(head, []).append(text)
    for table, names in unknown.items():
        path, kind = follow(model, table)
        key = printable(".".join(map(str, path)))
        *others, own = _kinds_with(names, model, table)
        alike = [name for name in names if any(name in known for known in _keys(kind))]
        tag = next((t for t in ("kind", "shape") if t in _fields(kind)), "")
        if len(names) > 1 and others and not alike:  # the kind is wrong, not the keys
            expected = {head: v for head, v in expected.items() if not head.startswith(f"{key}.")}
            text = f"{', '.join(map(printable, names))} are keys of {few(others, ' or ')}"
            expected[f'{key}.{tag} = "{own}"' if tag else f"{key}.{own}"] = [text]
            continue
        for name in names:
            *others, own = _kinds_with([name], model, table)
            hint = meant(name, _keys(kind))
            plural = name.removesuffix("s") in _keys(kind)  # "runs" for "run"
            if table and name in ("units", *_keys(model)) and name not in MEANT and not plural:
                hint = ": it belongs at the top of the file, above the first table"
            common = name in MEANT and hint.startswith("; did")
            meant_here = common or "." in hint or any(name in known for known in _keys(kind))
            if name in others:  # the key that stands for a kind
                hint = f": expected {tag or own} or {name}, not both"
            elif others and not meant_here:
                has = "has" if len(others) == 1 else "have"
                hint = f" of {own}; {few(others)} {has} it"
            expected[printable(f"{key}.{name}" if key else name)] = [f"unknown key{hint}"]
    keys = {head: ".".join(filter(None, (under, head))) for head in expected}
    return sorted(
        f"{keys[k]}: {_joined(texts)}".removeprefix(": ") for k, texts in expected.items()
    )


# Common words, and what they are in a file; with a dot the key of another table. Words that a table
# does not know are not proposed for it.
WORDS = """
b: width
h: height
k: stiffness
c: damping
damping: restitution
p kp: proportional
i ki: integral
d kd: derivative
moi: inertia
density rho: rho air_density
length width n_length n_width: parameters
normal reference_axis: axis
fix: fixed
edge curve body node: at
e young: E E1
g: G12 gravity
nu nu21 poisson: nu nu12
circle: ellipse
pipe: tube
diameter: radius outer_radius
thickness: wall
coordinate: joint
direction: component
axis vector: direction
parent child: between
velocity omega: speed
angle: angle_deg ply_angle_deg rotation_deg start_deg joint
angles: angles_deg
layup lay_up laminate plies: layup laminate sections.NAME.description
bending: bending-xy
bernoulli euler_bernoulli: classical
component: coordinate
second_order geometric_stiffening: solver.geometric_stiffening
ball: spherical
hinge pin: revolute
slider: prismatic
weld: fixed
bodies places: between
damper: spring
torsional_spring: rotary_spring
pid: controller
plane ground floor: contact
force sine sin function: expression
motor actuator: drive
steps points: count x2
rk4 rk45 ode45: rk5
bdf: gear
lhs: latin-hypercube
num n: count
start: from
friction mu: coefficient
contact normal_force: force
loads: forces
magnitude value: law
target reference: setpoint
max: bounds upper to
min: bounds lower from
average mean: rms
displacement: deflection
stress strain: ply_stress
torque: moment reaction
moment: torque reaction
weight: mass
algorithm method optimizer optimiser: driver integrator
newmark: generalized-alpha
tolerance: rtol
dt: output_step
duration time end_time stop_time: t_end
static: equilibrium
constraint constraints limits: subject_to
maximize: maximise
minimize objective: minimise
"""
MEANT = {
    word: meaning.split()
    for words, _, meaning in (line.partition(":") for line in WORDS.splitlines())
    for word in words.split()
}


def meant(word: str, known: Iterable[str]) -> str:
    """Return "; did you mean 'x'?" for a common word or the nearest one; else some known words."""
    known = list(known)
    for ours in MEANT.get(re.sub(r"\W", "_", word.lower()), ()):
        if ours in known or "." in ours:
            return f"; did you mean {ours!r}?"
    return nearest(word, known, MOST_KEYS)


def _kinds_with(names: Sequence[str], model: type[BaseModel], table: tuple[Any, ...]) -> list[Any]:
    """Return the other kinds of a table that have all these keys, and its own kind."""
    kinds = members(follow(model, table[:-1])[1]) if table else {}
    if not kinds:
        return [""]
    return [*(n for n, kind in kinds.items() if set(names) <= set(_keys(kind))), table[-1]]


def _is_whole(item: Any, items: Sequence[Any]) -> bool:
    """Return whether an error is of a list as another member of a union; its items have errors."""
    way = item["loc"][:-1]
    return isinstance(item.get("input"), list) and any(
        other["loc"][: len(way)] == way and len(other["loc"]) > len(way) + 1 for other in items
    )


def _joined(texts: Sequence[str]) -> str:
    """Return what the members of a union expect in one text."""
    first, *rest = dict.fromkeys(texts)
    return " or ".join([first, *(re.sub("^(expected|value should be) ", "", t) for t in rest)])


def _line(item: Any, model: type[BaseModel], path: list[Any], kind: Any) -> tuple[str, str]:
    """Return key and value of an error, and what is expected."""
    key = printable(".".join(str(part) for part in path))
    field = _field(model, item["loc"])
    if item["type"] == "missing":
        return key, f"missing; expected {_expected(path, kind, field)}"
    if item["type"] in ("union_tag_not_found", "union_tag_invalid"):
        discriminator = str(item["ctx"]["discriminator"]).strip("'()")
        choices = members(kind)
        tags = sorted(t for t, m in choices.items() if discriminator in m.model_fields)
        expected = "expected one of " + ", ".join(f'"{tag}"' for tag in tags)
        expected += "".join(f", or the key {tag}" for tag in choices if tag not in tags)
        if item["type"] == "union_tag_not_found":
            return f"{key}.{discriminator}", f"missing; {expected}"
        value = item["ctx"]["tag"]
        hint = meant(value, tags)
        hint = hint if hint.startswith("; did") else ""
        return f'{key}.{discriminator} = "{value}"', f"{expected}{hint}"
    text = item["msg"].removeprefix("Value error, ")
    text = _DECIMAL.sub(lambda m: f"{float(m[0]):g}", text[0].lower() + text[1:])
    if not path:  # a contradiction of the whole file, whose text names the keys
        return "", text
    value = item.get("input")
    inner = re.match(r"([\w.-]+( = [^:]*)?): ", text)
    if isinstance(value, dict) and inner is not None:  # about a key of the table
        return f"{key}.{inner[1]}", text[inner.end() :]
    numbers = _of_numbers(field)
    if item["type"] == "list_type" or (numbers and item["type"] in ("too_short", "too_long")):
        rows = _field(model, item["loc"][:-1]) if isinstance(path[-1], int) else None
        if rows and rows.description:  # once for all rows
            return key.rpartition(".")[0], f"expected a list of lists: {rows.description}"
        text = f"expected a list{numbers}"
        text += f': ["{value}"]' if isinstance(value, str) and not numbers else ""
        text += ", such as [{ ... }]" if isinstance(value, dict) else ""
    elif item["type"] == "string_type" and field is not None and field.description:
        text = f"expected a text in quotes: {field.description.partition(';')[0]}"
    elif item["type"] == "string_pattern_mismatch" and item["ctx"]["pattern"].startswith(NAME):
        text = "expected a name of letters A to Z, digits and _, a letter first"
    elif item["type"] == "string_pattern_mismatch" and field is not None and field.description:
        text = f"expected {field.description.partition(';')[0]}"
    elif item["type"] in ("bool_type", "bool_parsing"):
        text = "expected true or false"
    elif item["type"] == "too_short":
        text = f"expected at least {counted(item['ctx']['min_length'], 'entry', 'entries')}"
    elif item["type"] in ("model_type", "model_attributes_type", "dict_type"):
        text = f"expected a table{_with_keys(kind)}"
    elif item["type"] in ("float_type", "int_type") and isinstance(value, str):
        unit = _unit(field)
        text += f" [{unit}]" * bool(unit)
        if is_number(value):
            text += ", without quotes"
        elif _WITH_UNIT.fullmatch(value):
            text += ", without quotes and without a unit"
        elif "parameters" in model.model_fields and path[0] != "parameters":
            text += ", or an expression of [parameters]" + item.get("ctx", {}).get("why", "")
    hint = ""
    if _one_of_words(kind):
        hint = meant(str(value), get_args(kind))
        hint = hint if hint.startswith("; did") else ""
    return f"{key} = {_short(value)}", f"{text.replace('input', 'value')}{hint}"


def _field(model: type[BaseModel], location: tuple[Any, ...]) -> FieldInfo | None:
    """Return the field of a key, None for an item of a list or of named tables."""
    _, table = follow(model, location[:-1])
    return _fields(table).get(str(location[-1])) if location else None


def _unit(field: FieldInfo | None) -> str:
    return "" if field is None else unit(field).replace("-", "")


def _of_numbers(field: FieldInfo | None) -> str:
    """Return how many numbers a list of a fixed length has, with an example."""
    if field is None:
        return ""
    of_an_option = [a for kind in get_args(field.annotation) for a in get_args(kind)[1:]]
    inner = [m for a in of_an_option if isinstance(a, FieldInfo) for m in a.metadata]
    bounds = [*field.metadata, *inner]
    least = [m.min_length for m in bounds if isinstance(m, MinLen)]
    most = [m.max_length for m in bounds if isinstance(m, MaxLen)]
    if least != most or not most:
        return ""
    if without_annotations(field.annotation) != list[float]:
        return f" of {most[0]}: {field.description}"
    return f" of {most[0]} numbers, such as {[0.0] * (most[0] - 1) + [1.0]}"


def _with_keys(kind: Any) -> str:
    fields = _fields(kind)
    asked = [name for name, field in fields.items() if field.is_required()]
    if asked:
        return f" with {', '.join(asked)}"
    return "".join(f", such as {{ {name} = ... }}" for name in list(fields)[:1])


def _expected(path: list[Any], kind: Any, field: FieldInfo | None) -> str:
    """Return what a missing key should have: a table, named tables or a value."""
    named = get_origin(kind) is dict
    if not named and not (isinstance(kind, type) and issubclass(kind, BaseModel)):
        if _one_of_words(kind) and len(get_args(kind)) <= FEW:
            return f"one of {', '.join(map(repr, get_args(kind)))}"
        meaning = re.split(r"[;:.] ", (field.description if field else "") or "")[0]
        unit = _unit(field)
        return "a value" + f": {meaning}" * bool(meaning) + f" [{unit}]" * bool(unit)
    if not all(isinstance(part, str) for part in path):  # in a list
        return "a table"
    where = f"a table [{printable('.'.join(path))}{'.NAME' if named else ''}]"
    return where + ("" if named else _with_keys(kind))


def is_number(text: str) -> bool:
    """Return whether a text is a number."""
    try:
        float(text)
    except ValueError:
        return False
    return True


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
    kinds: dict[Any, Any] = {}
    for member in get_args(kind):
        names = [a.tag for a in getattr(member, "__metadata__", ()) if isinstance(a, Tag)]
        bare = without_annotations(member)
        if not names and isinstance(bare, type) and issubclass(bare, BaseModel):
            tags = [f.annotation for n, f in bare.model_fields.items() if n in ("kind", "shape")]
            names = [name for tag in tags if get_origin(tag) is Literal for name in get_args(tag)]
        kinds.update(dict.fromkeys(names or [getattr(bare, "__name__", str(bare))], bare))
    return kinds


def _fields(kind: Any) -> dict[str, FieldInfo]:
    """Return the fields of a table of this type by their keys."""
    if not (isinstance(kind, type) and issubclass(kind, BaseModel)):
        return {}
    return {field.alias or name: field for name, field in kind.model_fields.items()}


def _keys(kind: Any) -> list[str]:
    """Return the keys that are known in a table of this type."""
    return sorted(_fields(kind))
