"""Scenes of the arena: one folder each, and the sheet that every runner gets.

A scene is `scene.toml`, with `scene.py` beside it where the case or the truth is computed
(docs/arena.md lists the keys). The sheet is plain JSON: rigid and modal bodies as they start,
joints, gravity, times and probe, so that no runner has to know our formats. Modal bodies have their
arrays in an `.npz` file.
"""

import json
import tomllib
from dataclasses import dataclass
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from plymotion.solver.math.arrays import Array

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
BUILD = Path("build/arena")
KINDS = {
    "mechanism": {"case", "t_end", "probe"},
    "modes": {"at", "values"},
    "section": {"file", "values"},
    "shell": {"file", "values"},
}
KEYS = {"title", "kind", "source", "licence", "truth"}
OPTIONAL = {
    "quick",
    "run",
    "packages",
    "changes",
    "every",
    "longest",
    "unit",
    "data",
    "ours",
    "note",
    "script",
}


def unit_matrices(stiff: float, rotary: float) -> tuple[Array, Array]:
    """K and M (6, 6) of a beam with EI = 1 and a mass of 1 per length.

    `stiff` against stretch and shear; `rotary` inertia of its two planes: 2 and 1 times.
    """
    from plymotion.preprocess.beam.line import SectionMass

    K = np.diag([stiff, stiff, stiff, 1.0, 1.0, 1.0])
    inertia = rotary * np.diag([2.0, 1.0, 1.0])
    return K, np.asarray(SectionMass(1.0, np.zeros(3), inertia).matrix())


def unit_beam(modes: list[dict[str, Any]], **keys: Any) -> dict[str, Any]:
    """The case of one beam of unit length on a wall, without segments."""
    from samples.segment_samples import cantilever

    found: dict[str, Any] = cantilever(1, 1.0)
    beam = found["bodies"]["beam"]
    del beam["segments"]
    beam |= {"elements": 20, "modes": [*modes, {"kind": "static-axial"}], **keys}
    return found


@dataclass(frozen=True)
class Scene:
    """One folder.

    Attributes
    ----------
    table : content of scene.toml
    script : scene.py or another, None without it; it may have `case(name)`, the text of a case, and
        `truth(times)`
    """

    name: str
    folder: Path
    table: dict[str, Any]
    script: ModuleType | None

    @property
    def motion(self) -> bool:
        """Whether its values are positions over time; else named numbers."""
        return bool(self.table["kind"] == "mechanism")

    @property
    def times(self) -> Array:
        """Times at which errors are measured [s]."""
        t_end, every = self.table["t_end"], self.table.get("every", 0.01)
        return np.arange(1, round(t_end / every) + 1) * every

    def sheet(self) -> dict[str, Any]:
        """What runners get; written to build/arena/sheets/NAME.json."""
        file = BUILD / "sheets" / f"{self.name}.json"
        file.parent.mkdir(parents=True, exist_ok=True)
        found = {
            key: self.table[key]
            for key in ("kind", "title", "data", "ours", "at")
            if key in self.table
        }
        found["name"] = self.name
        listed = self.table.get("values", self.table["truth"].get("values", {}))
        found["values"] = listed if isinstance(listed, dict) else dict.fromkeys(listed)
        if found["kind"] in ("mechanism", "modes"):
            from mechanism_sheet import mechanism

            found |= mechanism(self)
        else:
            found["file"] = str(self.path(self.table["file"]))
            if found["kind"] == "section":
                from section_cells import cells

                found["cells"] = cells(self.name, self.path(self.table["file"]))
        file.write_text(json.dumps(found), encoding="utf-8")
        return found | {"sheet": str(file)}

    def path(self, name: str) -> Path:
        """File of the scene's folder, or of the repository."""
        own = self.folder / name
        return own if own.exists() else ROOT / name

    def case(self) -> Path:
        """Case file; one that scene.py makes is written first."""
        if self.script is None or not hasattr(self.script, "case"):
            return self.path(self.table["case"])
        file = BUILD / "cases" / self.name / "case.toml"
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(self.script.case(self.name), encoding="utf-8")
        return file


def script(file: Path, name: str) -> ModuleType:
    """A Python file as a module."""
    spec = spec_from_file_location(name, file)
    if spec is None or spec.loader is None:
        raise SystemExit(f"{file}: cannot be imported")
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def read(folder: Path) -> Scene:
    """A scene from its folder. Raises SystemExit with file, key and what was expected."""
    file = folder / "scene.toml"
    try:
        table = tomllib.loads(file.read_text(encoding="utf-8"))
    except (OSError, tomllib.TOMLDecodeError) as error:
        raise SystemExit(f"{file}: {error}") from error
    kind = table.get("kind")
    if kind not in KINDS:
        raise SystemExit(f"{file}: kind = {kind!r}: expected one of {', '.join(KINDS)}")
    code = folder / table.get("script", "scene.py")
    module = script(code, f"scene_{folder.name.replace('-', '_')}") if code.exists() else None
    made = {name for name in ("case", "matrices") if hasattr(module, name)}
    wanted = KEYS | KINDS[kind] - ({"case"} if made else set())
    wanted -= {"probe"} if "matrices" in made else set()
    allowed = KEYS | KINDS[kind] | OPTIONAL
    if missing := wanted - set(table):
        raise SystemExit(f"{file}: {', '.join(sorted(missing))}: missing, expected in a {kind}")
    if unknown := set(table) - allowed:
        raise SystemExit(
            f"{file}: {', '.join(sorted(unknown))}: unknown; a {kind} may have "
            f"{', '.join(sorted(allowed))}"
        )
    return Scene(folder.name, folder, table, module)


def find(places: list[Path], words: tuple[str, ...] = ()) -> list[Scene]:
    """All scenes of some folders, or those whose names contain one of the words."""
    files = [file for place in places for file in sorted(place.glob("*/scene.toml"))]
    found = [file.parent for file in files]
    return [read(f) for f in found if not words or any(word in f.name for word in words)]
