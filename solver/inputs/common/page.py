"""Tables of a reference page, generated from the models of an input file."""

from collections.abc import Iterable
from types import UnionType
from typing import Any, Union, get_args, get_origin

from annotated_types import Ge, Gt, Le, Lt, MaxLen, MinLen
from pydantic import BaseModel
from pydantic.fields import FieldInfo

_BOUNDS = {
    Gt: ("gt", ">"),
    Ge: ("ge", ">="),
    Lt: ("lt", "<"),
    Le: ("le", "<="),
    MinLen: ("min_length", "at least"),
    MaxLen: ("max_length", "at most"),
}
EXAMPLE_MATERIAL = """\
[materials.cfrp]
kind = "orthotropic"
E1 = 142e9
E2 = 9.8e9
E3 = 9.8e9
G12 = 6.0e9
G13 = 6.0e9
G23 = 4.8e9
nu12 = 0.42
nu13 = 0.42
nu23 = 0.42
rho = 1600.0
"""
HEAD = ["| key | type | unit | bounds | default | meaning |", "|---|---|---|---|---|---|"]


def chapters(models: Iterable[type[BaseModel]]) -> list[str]:
    """Return the lines of one chapter per model: its first line, its text, its keys."""
    out = []
    for model in models:
        first, _, rest = (model.__doc__ or "").partition("\n")
        out += [f"## {first.rstrip('.')}", ""]
        if rest.strip():
            out += [" ".join(rest.split()), ""]
        out += [*keys(model), ""]
    return out


def keys(model: type[BaseModel]) -> list[str]:
    """Return the lines of the table of a model's keys."""
    return [*HEAD, *(_row(info.alias or name, info) for name, info in model.model_fields.items())]


def required(model: type[BaseModel]) -> list[str]:
    """Return the keys without default, as code, except those that identify the kind of table."""
    return [
        f"`{name}`"
        for name, info in model.model_fields.items()
        if info.is_required() and name not in ("kind", "shape")
    ]


def _row(name: str, info: FieldInfo) -> str:
    extra = info.json_schema_extra if isinstance(info.json_schema_extra, dict) else {}
    unit = str(extra.get("unit", ""))
    default = "required" if info.is_required() else f"`{_plain(info.default)}`"
    meaning = info.description or ("kind of this table" if name in ("kind", "shape") else "")
    cells = [f"`{name}`", _type(info.annotation), unit, _bounds(info), default, meaning]
    return "| " + " | ".join(c.replace("|", "\\|") for c in cells) + " |"


def _plain(value: Any) -> str:
    if isinstance(value, BaseModel):
        return str(value.model_dump())
    return "absent" if value is None else str(value)


def _type(kind: Any) -> str:
    origin, arguments = get_origin(kind), get_args(kind)
    if isinstance(kind, type) and issubclass(kind, BaseModel):
        return "table"
    if origin is not None and str(origin).endswith("Literal"):
        return " or ".join(f'`"{a}"`' if isinstance(a, str) else f"`{a}`" for a in arguments)
    if origin is list:
        return f"list of {_type(arguments[0])}"
    if origin is dict:
        inner = _type(arguments[1])
        return f"named {inner}s" if inner == "table" else f"table of {inner}"
    if hasattr(kind, "__metadata__"):
        return _type(kind.__origin__)
    if arguments:
        names = [_type(a) for a in arguments if a is not type(None)]
        return " or ".join(dict.fromkeys(names))
    return {"float": "number", "int": "integer", "str": "text", "bool": "true or false"}.get(
        getattr(kind, "__name__", ""), "any"
    )


def _bounds(info: FieldInfo) -> str:
    words = _words((*info.metadata, *_inner(info.annotation)))
    kind = _item(info.annotation)
    if kind is not None:
        words += [f"each {word}" for word in _words(_inner(kind))]
    return ", ".join(words)


def _words(items: Iterable[Any]) -> list[str]:
    """Return bounds as texts; a least and a largest length that are equal as one."""
    found = [text for item in items if (text := _bound(item))]
    for text in list(found):
        most = text.replace("at least", "at most")
        if most != text and most in found:
            found[found.index(text)] = text.replace("at least", "exactly")
            found.remove(most)
    return found


def _inner(kind: Any) -> list[Any]:
    """Return the annotations of a type, and of the members of a union."""
    if hasattr(kind, "__metadata__"):
        found = []
        for item in kind.__metadata__:
            found += item.metadata if isinstance(item, FieldInfo) else [item]
        return found
    if get_origin(kind) in (Union, UnionType):
        return [item for member in get_args(kind) for item in _inner(member)]
    return []


def _item(kind: Any) -> Any:
    """Return the type of a list's items; None if it is not a list."""
    if hasattr(kind, "__metadata__"):
        return _item(kind.__origin__)
    if get_origin(kind) in (Union, UnionType):
        return next((item for a in get_args(kind) if (item := _item(a)) is not None), None)
    return get_args(kind)[0] if get_origin(kind) is list else None


def _bound(item: Any) -> str:
    """Return a bound as text; nothing for other annotations."""
    for kind, (key, text) in _BOUNDS.items():
        if isinstance(item, kind):
            return f"{text} {getattr(item, key):g}"
    return ""
