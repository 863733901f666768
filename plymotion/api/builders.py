"""Functions of a case, one for each kind of body, joint, coupling and force: `case.revolute(...)`.

They are made from the tables of the case file (solver/inputs/case/tables), so that a new kind has
its function at once. builders.pyi, which `make docs` writes, gives them to editors.
"""

import inspect
from collections.abc import Callable, Iterator
from keyword import iskeyword
from textwrap import fill
from typing import Any, NamedTuple, get_args

from pydantic import BaseModel, ValidationError
from pydantic.fields import FieldInfo

from ..solver.errors import InputError, nearest
from ..solver.inputs.case.tables.kinds import (
    COUPLING_TABLES,
    FORCE_TABLES,
    JOINT_TABLES,
    CoordinateTable,
    LoadTable,
)
from ..solver.inputs.case.tables.laws import FOLDER
from ..solver.inputs.case.tables.schema import Body, GroundPoint, PointMass
from ..solver.inputs.common.input_table import bare_lines, members, unit, without_annotations
from ..solver.package.common.plain_data import plain
from .keys import Keys, kind_of

WIDTH = 84  # of docstrings
AXES = {
    sign + "xyz"[k]: [float(sign + "1") * (i == k) for i in range(3)]
    for k in range(3)
    for sign in ("", "-")
}
WORDS = {"bodies": "body", "joints": "joint", "couplings": "coupling", "forces": "force"}
WORDS |= {"ground": "point of the ground", "masses": "point mass"}
PAIRS = {"joints": "between", "forces": "between", "couplings": "joints"}


class Kind(NamedTuple):
    """A kind of a table of the case file, and its function."""

    group: str
    name: str  # of the function
    tag: str  # of `kind`; "" without
    model: type[BaseModel]
    first: tuple[str, ...]  # arguments by position, behind the name


def kinds() -> Iterator[Kind]:
    """Yield all kinds that have a function."""
    for tag, model in members(without_annotations(Body)).items():
        yield Kind("bodies", tag, tag, model, ())
    for group, models in (("joints", JOINT_TABLES), ("couplings", COUPLING_TABLES)):
        for model in models:
            yield Kind(group, *2 * (_tag(model),), model, ("one", "two"))
    for force in FORCE_TABLES:
        first = () if issubclass(force, CoordinateTable) else ("one", "two")
        first = ("at",) if issubclass(force, LoadTable) else first
        yield Kind("forces", *2 * (_tag(force),), force, first)
    yield Kind("ground", "point", "", GroundPoint, ("position",))
    yield Kind("masses", "mass", "", PointMass, ("mass", "at"))


def _tag(model: type[BaseModel]) -> str:
    return str(get_args(model.model_fields["kind"].annotation)[0])


def keys_of(kind: Kind) -> dict[str, FieldInfo]:
    """Return the keys of a kind by argument, without those by position."""
    own = PAIRS.get(kind.group) if kind.first == ("one", "two") else None
    fields = {}
    for name, field in kind.model.model_fields.items():
        key = name if iskeyword(field.alias or name) else field.alias or name
        if key not in ("kind", own, *kind.first):
            fields[key] = field
    return fields


def signature_of(kind: Kind) -> inspect.Signature:
    """Return the signature of the function of a kind."""
    by_place, by_name = inspect.Parameter.POSITIONAL_OR_KEYWORD, inspect.Parameter.KEYWORD_ONLY
    fields = sorted(keys_of(kind).items(), key=lambda item: not item[1].is_required())
    parameters = [inspect.Parameter(name, by_place) for name in ("self", "name", *kind.first)]
    for key, field in fields:
        default = inspect.Parameter.empty if field.is_required() else None
        parameters.append(inspect.Parameter(key, by_name, default=default))
    return inspect.Signature(parameters)


def text_of(kind: Kind) -> str:
    """Return the docstring of the function of a kind."""
    head = (inspect.getdoc(kind.model) or "").splitlines()[0].replace("`", "")
    head = head.split(": ", 1)[-1].rstrip(".")
    what = f'{WORDS[kind.group]} of kind "{kind.tag}"' if kind.tag else WORDS[kind.group]
    lines = [f"Add a {what}: {head}.", "", "Parameters", "----------"]
    lines.append("name : of the table in the case")
    if kind.first == ("one", "two"):
        lines.append(
            "one, two : names of joints"
            if kind.group == "couplings"
            else 'one, two : places, "BODY.INTERFACE" or "ground.POINT"'
        )
    fields = {k: f for k, f in kind.model.model_fields.items() if k in kind.first}
    for key, field in {**fields, **keys_of(kind)}.items():
        default = "" if field.is_required() or field.default is None else _default(field)
        meaning = f"{field.description or ''}{f' [{unit(field)}]' if unit(field) else ''}{default}"
        lines += [
            f"{key} :",
            *fill(meaning, WIDTH, initial_indent="    ", subsequent_indent="    ").splitlines(),
        ]
    return "\n".join([*lines, "", "Returns", "-------", "the table, with keys as attributes"])


def _default(field: FieldInfo) -> str:
    value = field.default
    return f"; default {value!r}" if isinstance(value, int | float | str | list) else ""


def _function(kind: Kind) -> Callable[..., Keys]:
    signature = signature_of(kind)
    pair = PAIRS.get(kind.group, "")
    annotations = {k: f.annotation for k, f in kind.model.model_fields.items()}
    directions = {k for k, a in annotations.items() if "list[float]" in str(a)}

    def add(self: Any, *values: Any, **named: Any) -> Keys:
        try:
            given = signature.bind(self, *values, **named).arguments
        except TypeError as error:
            wrong = next((k for k in named if k not in signature.parameters), "")
            hint = nearest(wrong, signature.parameters) if wrong else ""
            if "too many" in str(error):
                places = [p.name for p in signature.parameters.values() if p.kind != p.KEYWORD_ONLY]
                hint = f"; expected {', '.join(places[1:])}, and the others by name"
            raise InputError(f"Case.{kind.name}: {error}{hint}") from None
        del given["self"]
        name = given.pop("name")
        table = {"kind": kind.tag} if kind.tag else {}
        if kind.first == ("one", "two"):
            table[pair] = [given.pop("one"), given.pop("two")]
        for key, value in given.items():
            if value is None:
                continue
            short = AXES.get(value) if isinstance(value, str) and key in directions else None
            table[key] = value if short is None else short
        if kind.group == "bodies" and isinstance(table.get("interfaces"), dict):
            word = "position" if kind.tag == "rigid" else "at"
            table["interfaces"] = {
                point: where if isinstance(where, dict) else {word: where}
                for point, where in table["interfaces"].items()
            }
        if not self.table.get("parameters"):  # a text in place of a number is an expression
            try:
                kind.model.model_validate(plain(table), context={FOLDER: self.folder})
            except ValidationError as error:
                errors = bare_lines(error, kind.model, f"{kind.group}.{name}")
                raise InputError("\n".join(errors)) from None
        self.table.setdefault(kind.group, {})[name] = table
        groups = Keys(kind_of(kind.group), kind.group, kind.group, self.table, self.folder)
        return groups[name]

    add.__name__ = kind.name
    add.__qualname__ = f"Case.{kind.name}"
    add.__doc__ = text_of(kind)
    add.__signature__ = signature  # type: ignore[attr-defined]
    return add


class Builders:
    """The functions of all kinds."""

    __slots__ = ()


for _kind in kinds():
    if hasattr(Builders, _kind.name):
        raise ValueError(f"two kinds have the function {_kind.name}")
    setattr(Builders, _kind.name, _function(_kind))
