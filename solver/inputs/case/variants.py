"""Variants: tables that are merged into a case, and may change the kind of a table."""

from copy import deepcopy
from functools import cache
from typing import Any, get_args

from ..common.messages import members, without_annotations
from ..section.mesh_table import shape
from .schema import Mechanism

Tables = dict[str, Any]


def merge(base: Tables, over: Tables, way: tuple[str, ...] = ()) -> None:
    """Merge tables of `over` into `base` in place; values and lists are replaced.

    A table of a mechanism whose kind changes keeps the keys that both kinds have.
    """
    for key, value in over.items():
        if isinstance(value, dict) and isinstance(base.get(key), dict):
            if len(way) == 1:
                _forget(way[0], base[key], value)
            merge(base[key], value, (*way, key))
        else:
            base[key] = deepcopy(value)


def _forget(group: str, table: Tables, over: Tables) -> None:
    """Remove from a table of `group` what the kind that `over` gives it does not have."""
    known = _keys(group)
    old, new = _kind(group, table), _kind(group, over)
    named = isinstance(old, str) and isinstance(new, str)  # a kind may be anything in a bad file
    if not named or old == new or old not in known or new not in known:
        return
    for key in list(table):
        if known[old].get(key, old) != known[new].get(key, new):
            del table[key]


def _kind(group: str, table: Tables) -> Any:
    return shape(table) if group == "sections" else table.get("kind")


@cache
def _keys(group: str) -> dict[Any, dict[str, Any]]:
    """Return the keys of every kind of a group with their types; empty for a group without."""
    field = Mechanism.model_fields.get(group)
    arguments = () if field is None else get_args(field.annotation)
    if len(arguments) != 2:
        return {}
    return {
        kind: {f.alias or name: f.annotation for name, f in model.model_fields.items()}
        for kind, model in members(without_annotations(arguments[-1])).items()
    }
