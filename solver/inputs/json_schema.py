"""JSON schemas of the files that a user writes, from the models that check them.

Editors complete and check TOML by them (docs/runs.md), and the manuals show their keys (manual.py).
"""

from collections.abc import Callable, Iterable, Mapping
from typing import Any

from pydantic import BaseModel
from pydantic.json_schema import models_json_schema

from .case.tables.schema import CaseFile, Mechanism
from .section.description import SectionDescription
from .shell import ShellDescription
from .solid import SolidDescription

Json = dict[str, Any]  # a JSON schema
DRAFT = "https://json-schema.org/draft/2020-12/schema"
CASE = "case"
FILES: dict[str, type[BaseModel]] = {
    "section": SectionDescription,
    "shell": ShellDescription,
    "solid": SolidDescription,
}
KINDS = (CASE, *FILES)


def tables(models: Iterable[type[BaseModel]]) -> tuple[list[Json], Json]:
    """Return the schemas of some models, and those of all tables that they refer to, by name.

    TOML has no null: it is left out of types and defaults.
    """
    models = list(models)
    refs, schema = models_json_schema([(model, "validation") for model in models])
    known: Json = {name: _plain(table) for name, table in schema["$defs"].items()}
    return [known[referred(refs[model, "validation"])] for model in models], known


def referred(schema: Mapping[str, Any]) -> str:
    """Return the name of the table that a schema refers to, "" for none."""
    return str(schema.get("$ref", "")).rpartition("/")[2]


def json_schema(kind: str) -> Json:
    """Return the JSON schema of a file of one of KINDS.

    A variant of a case may give any key of the mechanism. So none is required there, and a table
    has to be valid for one of its kinds.
    """
    if kind != CASE:
        (top,), known = tables([FILES[kind]])
        known = {name: _shown(table) for name, table in known.items() if name != top["title"]}
        top = _shown(top)
    else:
        (file, mechanism), known = tables([CaseFile, Mechanism])
        of_file = reached(file, known, {})
        known = {
            name: _shown(table) if name in of_file else _partial(_shown(table))
            for name, table in known.items()
            if table not in (file, mechanism)
        }
        top = _shown(file)
        top["properties"] = {**top["properties"], **_partial(_shown(mechanism))["properties"]}
    return {"$schema": DRAFT, **top, "title": f"Plymotion {kind}", "$defs": known}


def reached(schema: Any, known: Json, collected: Json) -> Json:
    """Add the tables to which a schema refers, and those to which they refer, to `collected`.

    Parameters
    ----------
    schema : a schema, or a part of one
    known : schemas of all tables by name
    collected : schemas that are reached, added to
    """
    name = referred(schema) if isinstance(schema, dict) else ""
    if name and name not in collected:
        collected[name] = known[name]
        reached(known[name], known, collected)
    for item in schema.values() if isinstance(schema, dict) else schema:
        if isinstance(item, dict | list):
            reached(item, known, collected)
    return collected


def _changed(schema: Any, change: Callable[[Json], Json], *, named: bool = False) -> Any:
    """Return a schema with `change` of each schema in it; the values of `named` are schemas."""
    if isinstance(schema, list):
        return [_changed(item, change) for item in schema]
    if not isinstance(schema, dict):
        return schema
    inner = {
        key: _changed(item, change, named=not named and key == "properties")
        for key, item in schema.items()
    }
    return inner if named else change(inner)


def _plain(schema: Json) -> Json:
    return dict(_changed(schema, _without_null))


def _without_null(schema: Json) -> Json:
    options = [each for each in schema.get("anyOf", ()) if each != {"type": "null"}]
    if len(options) == 1:
        schema = {**options[0], **{k: v for k, v in schema.items() if k != "anyOf"}}
    elif options:
        schema = {**schema, "anyOf": options}
    names = schema.get("patternProperties")
    if names:  # names of another form are errors
        ((pattern, inner),) = names.items()
        own = {"pattern": pattern, **schema.get("propertyNames", {})}
        schema = {**schema, "additionalProperties": inner, "propertyNames": own}
    dropped = {"patternProperties", "discriminator"}
    if "properties" not in schema:
        dropped.add("title")
    if schema.get("default", "") is None:
        dropped.add("default")
    return {key: value for key, value in schema.items() if key not in dropped}


def _shown(schema: Json) -> Json:
    """Return a schema with the units in the texts that editors show."""

    def change(schema: Json) -> Json:
        unit = schema.get("unit")
        if not isinstance(unit, str):
            return schema
        text = schema["description"] + (f" [{unit}]" if unit != "-" else "")
        return {**{k: v for k, v in schema.items() if k != "unit"}, "description": text}

    return dict(_changed(schema, change))


def _partial(schema: Json) -> Json:
    """Return a schema whose tables may lack any key, and have expressions in place of numbers."""

    def change(schema: Json) -> Json:
        reduced = {key: value for key, value in schema.items() if key != "required"}
        if reduced.get("type") in ("number", "integer"):
            reduced["type"] = [reduced["type"], "string"]
        if "oneOf" in reduced:
            reduced["anyOf"] = reduced.pop("oneOf")
        return reduced

    return dict(_changed(schema, change))
