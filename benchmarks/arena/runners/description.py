"""Our descriptions of sections and shells at another mesh density, and the numbers of a scene."""

import json
import math
import tomllib
from pathlib import Path
from typing import Any

from common import Sheet

POSITIONS = {"EA": 0, "GA2": 1, "GA3": 2, "GJ": 3, "EI2": 4, "EI3": 5}


def read_toml(sheet: Sheet) -> dict[str, Any]:
    """The description of a scene, with the path of its mesh."""
    file = Path(sheet["file"])
    table = tomllib.loads(file.read_text(encoding="utf-8"))
    if "file" in table["mesh"]:
        table["mesh"]["file"] = str((file.parent / table["mesh"]["file"]).resolve())
    return table


def command(sheet: Sheet, setting: Sheet, folder: Path, python: str) -> list[str]:
    """Write a changed description beside the original one's meshes; return the command."""
    table = read_toml(sheet)
    mesh = table["mesh"]
    if sheet["kind"] == "section":
        mesh["density"] = setting["density"]
    else:
        for key in mesh["parameters"]:
            if key.startswith("n_"):
                mesh["parameters"][key] = setting["cells"]
        if "frequencies" in table:
            table["frequencies"] = {"count": 1, "error": False}
    file = folder / "scene.toml"
    file.write_text(toml(table), encoding="utf-8")
    out = ["--out", str(folder / "out"), "--json", "--no-figures", "--force", "--quiet"]
    extra = ["--no-estimate"] if sheet["kind"] == "section" else []
    return [python, "-m", "plymotion", sheet["kind"], str(file), *out, *extra]


def toml(value: Any, path: str = "") -> str:
    """A table of tables, lists and plain values as TOML."""
    plain = {k: v for k, v in value.items() if not isinstance(v, dict)}
    text = f"[{path}]\n" if path and (plain or not value) else ""
    text += "".join(f"{json.dumps(k)} = {_inline(v)}\n" for k, v in plain.items())
    for key, v in value.items():
        if isinstance(v, dict):
            text += toml(v, f"{path}.{json.dumps(key)}" if path else json.dumps(key))
    return text


def _inline(value: Any) -> str:
    if isinstance(value, list):
        return f"[{', '.join(map(_inline, value))}]"
    if isinstance(value, dict):
        return f"{{ {', '.join(f'{json.dumps(k)} = {_inline(v)}' for k, v in value.items())} }}"
    return json.dumps(value)


def numbers(sheet: Sheet, folder: Path) -> Sheet:
    """The scene's values from what the command printed."""
    told = (folder / "told.txt").read_text(encoding="utf-8")
    found = json.loads(told[told.index("{") : told.rindex("}") + 1])
    values = {}
    for name, path in sheet["values"].items():
        if sheet["kind"] == "section":
            k = POSITIONS[name]
            values[name] = found["K"][k][k]
            continue
        entry: Any = found
        for key in path:
            entry = entry[key]
        values[name] = abs(entry)
    return {"values": values, "solution_s": math.nan}
