"""The reference page of the case file, generated from the schema."""

from typing import Any, get_args, get_origin

from annotated_types import Ge, Gt, Le, Lt, MaxLen, MinLen
from pydantic import BaseModel
from pydantic.fields import FieldInfo

from . import schema

_ORDER: tuple[type[BaseModel], ...] = (
    schema.CaseFile,
    schema.Mechanism,
    schema.IsotropicMaterial,
    schema.OrthotropicMaterial,
    schema.RectangleSection,
    schema.EllipseSection,
    schema.BeamBody,
    schema.RigidBody,
    schema.PackageBody,
    schema.Reference,
    schema.ModeChoice,
    schema.BeamInterface,
    schema.PointInterface,
    schema.GroundPoint,
    schema.RevoluteJoint,
    schema.FixedJoint,
    schema.Drive,
    schema.PointMass,
    schema.Signal,
    schema.Solver,
    schema.Run,
    schema.Figure,
)


def reference_page() -> str:
    """Return docs/case-reference.md."""
    out = [
        "# The case file",
        "",
        "A case is `cases/<name>/case.toml`. This page is generated from solver/case/schema.py "
        "by `make docs`.",
        "",
        "A *run* is the case with some *variants* merged over it, in order: tables are merged, "
        "values and lists are replaced. Units are SI; degrees only in keys that end in `_deg`. "
        "Unknown keys are errors.",
        "",
    ]
    for model in _ORDER:
        first, _, rest = (model.__doc__ or "").partition("\n")
        out += [f"## {first.rstrip('.')}", ""]
        if rest.strip():
            out += [" ".join(rest.split()), ""]
        out += ["| key | type | unit | bounds | default | meaning |", "|---|---|---|---|---|---|"]
        for name, info in model.model_fields.items():
            out.append(_row(name, info))
        out.append("")
    return "\n".join(out)


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
    return {"float": "number", "int": "integer", "str": "text"}.get(
        getattr(kind, "__name__", ""), "any"
    )


def _bounds(info: FieldInfo) -> str:
    words = []
    for item in info.metadata:
        if isinstance(item, Gt):
            words.append(f"> {item.gt}")
        elif isinstance(item, Ge):
            words.append(f">= {item.ge}")
        elif isinstance(item, Lt):
            words.append(f"< {item.lt}")
        elif isinstance(item, Le):
            words.append(f"<= {item.le}")
        elif isinstance(item, MinLen):
            words.append(f"at least {item.min_length}")
        elif isinstance(item, MaxLen):
            words.append(f"at most {item.max_length}")
    return ", ".join(words)
