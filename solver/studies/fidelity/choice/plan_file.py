"""A plan as a TOML file: it is written, may be edited, and is read again."""

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ....errors import InputError, nearest, printable
from ....inputs.common.text_file import read_toml
from ....package.common.temporary import write_text
from ....package.common.toml_text import toml_value
from ....run.inputs_digest import plan_sha256, text_sha256
from ..base.plan import BodyPlan, Plan

FORMAT = 1
BOUNDS_RTOL = 1e-15, 0.1  # those of the solver
MOST_SHAPES = 20
MESHES = "model", "check"
BODY_KEYS: dict[str, type] = {
    "vibrations": list,
    "static_shapes": int,
    "ringing": bool,
    "mesh": str,
}
KEYS: dict[str, type] = {
    "format": int,
    "inputs_sha256": str,
    "rtol": float,
    "geometric_stiffening": bool,
    "bodies": dict,
}
WORDS: dict[type, str] = {
    list: "a list",
    int: "an integer",
    float: "a number",
    bool: "true or false",
    str: "text",
    dict: "a table",
}
Known = Mapping[str, Mapping[str, tuple[str, ...]]]
Table = Mapping[str, Any]


def write_plan(file: Path, plan: Plan, remarks: list[str]) -> None:
    """Write a plan as TOML with remarks, under a temporary name that is then renamed.

    Another plan of this name, which may have been edited, is kept as NAME.previous.toml.
    """
    lines = [*(f"# {printable(remark)}" for remark in remarks), "format = 1"]
    lines += [f'inputs_sha256 = "{plan.inputs_sha256}"', f"rtol = {plan.rtol:.6g}"]
    lines += [f"geometric_stiffening = {str(plan.stiffening).lower()}"]
    lines += [] if plan.bodies else ["", "[bodies]"]
    for name, body in plan.bodies.items():
        lines += [
            "",
            f"[bodies.{name}]",
            f"vibrations = {toml_value(list(body.vibrations))}",
            f"static_shapes = {body.static}",
            f"ringing = {str(body.ringing).lower()}",
            f'mesh = "{body.mesh}"',
        ]
    text = "\n".join(lines) + "\n"
    if file.is_file() and (there := plan_sha256(file)) and there != text_sha256(text):
        os.replace(file, file.with_suffix(".previous.toml"))
    write_text(file, text)


def kept_plan(file: Path, known: Known, digest: str) -> Plan | None:
    """Read a plan if it is there and was made for the inputs of this digest; see `read_plan`.

    A plan of other inputs may name bodies and vibrations that are no more: it is not looked at.
    """
    if not file.exists():
        return None
    table = read_toml(file, "plan")
    _typed(f"{file}: ", table, {"inputs_sha256": str})
    return plan_of_table(file, table, known) if table["inputs_sha256"] == digest else None


def read_plan(file: Path, known: Known) -> Plan:
    """Read a plan.

    Parameters
    ----------
    known : labels of the vibrations of each flexible body, by mesh

    Raises
    ------
    InputError
        File, key, value and expectation of what is wrong.
    """
    return plan_of_table(file, read_toml(file, "plan"), known)


def plan_of_table(file: Path, table: Table, known: Known) -> Plan:
    """Return the plan of the content of a file; see `read_plan`."""
    _known(f"{file}: ", table, KEYS)
    _typed(f"{file}: ", table, KEYS)
    if table["format"] != FORMAT:
        raise InputError(f"{file}: format = {_shown(table['format'])}: expected {FORMAT}")
    least, most = BOUNDS_RTOL
    if not least <= table["rtol"] <= most:
        value = _shown(table["rtol"])
        raise InputError(f"{file}: rtol = {value}: expected from {least:g} to {most:g}")
    where = f"{file}: bodies"
    bodies = {name: _body(where, name, each, known) for name, each in table["bodies"].items()}
    for name in known:
        if name not in bodies:
            raise InputError(f"{where}.{name}: missing; expected a table for each flexible body")
    rtol, stiffening = float(table["rtol"]), table["geometric_stiffening"]
    return Plan(bodies, stiffening, rtol, table["inputs_sha256"])


def _body(where: str, name: str, entry: Any, known: Known) -> BodyPlan:
    where = f"{where}.{name}"
    if name not in known:
        raise InputError(f"{where}: no such flexible body{nearest(name, known)}")
    if not isinstance(entry, dict):
        raise InputError(f"{where} = {_shown(entry)}: expected a table")
    _known(f"{where}.", entry, BODY_KEYS)
    _typed(f"{where}.", entry, BODY_KEYS)
    static, mesh, labels = entry["static_shapes"], entry["mesh"], entry["vibrations"]
    if not 0 <= static <= MOST_SHAPES:
        value = _shown(static)
        raise InputError(f"{where}.static_shapes = {value}: expected 0 to {MOST_SHAPES}")
    if mesh not in MESHES:
        raise InputError(f'{where}.mesh = {_shown(mesh)}: expected "model" or "check"')
    for i, label in enumerate(labels):
        if label not in known[name][mesh]:
            hint = nearest(label, known[name][mesh]) if isinstance(label, str) else ""
            raise InputError(f"{where}.vibrations = {_shown(label)}: no such vibration{hint}")
        if label in labels[:i]:
            raise InputError(f"{where}.vibrations = {_shown(label)}: twice; expected it once")
    return BodyPlan(tuple(labels), static, entry["ringing"], mesh)


def _known(where: str, table: Table, keys: Table) -> None:
    for key in table:
        if key not in keys:
            raise InputError(f"{where}{key}: unknown key{nearest(key, keys)}")


def _typed(where: str, table: Table, keys: Mapping[str, type]) -> None:
    for key, kind in keys.items():
        if key not in table:
            raise InputError(f"{where}{key}: missing; expected {WORDS[kind]}")
        value = table[key]
        fits = isinstance(value, int | float) if kind is float else isinstance(value, kind)
        if not fits or (kind is not bool and isinstance(value, bool)):
            raise InputError(f"{where}{key} = {_shown(value)}: expected {WORDS[kind]}")


def _shown(value: Any) -> str:
    """Return a value as TOML has it, cut where it is long."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, int) and value.bit_length() > 200:  # no decimals of an endless number
        return f"an integer of {value.bit_length()} bits"
    text = f'"{value}"' if isinstance(value, str) else repr(value)
    return text if len(text) <= 80 else f"{text[:80]}..."
