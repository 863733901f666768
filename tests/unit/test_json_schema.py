"""`plymotion schema`: all input files of the repository are valid by it, and mistakes are not."""

import json
import tomllib
from copy import deepcopy
from pathlib import Path
from typing import Any

import pytest
from jsonschema import Draft202012Validator
from jsonschema.exceptions import best_match

from plymotion.solver.__main__ import main
from plymotion.solver.inputs.json_schema import KINDS, json_schema

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="module")
def validators() -> dict[str, Draft202012Validator]:
    """A validator of each kind of file, once its schema is valid itself."""
    schemas = {kind: json_schema(kind) for kind in KINDS}
    for schema in schemas.values():
        Draft202012Validator.check_schema(schema)
    return {kind: Draft202012Validator(schema) for kind, schema in schemas.items()}


def kind_of(table: dict[str, Any]) -> str:
    """The kind of a file by its keys; empty for files of another format."""
    if "runs" in table:
        return "case"
    if "mesh" not in table or "regions" not in table:
        return ""
    if "interfaces" in table:
        return "solid"
    shell = {"loads", "supports", "frequencies", "stiffeners", "elements"} & table.keys()
    return "shell" if shell else "section"


FILES = sorted(
    file
    for folder in ("cases", "solver/commands/starters", "benchmarks", "tests")
    for file in (ROOT / folder).rglob("*.toml")
    if "build" not in file.parts
)


def test_all_files_of_the_repository_are_valid(validators: dict[str, Draft202012Validator]) -> None:
    found: dict[str, int] = {}
    wrong = []
    for file in FILES:
        table = tomllib.loads(file.read_text("utf-8"))
        if kind := kind_of(table):
            found[kind] = found.get(kind, 0) + 1
            if error := best_match(validators[kind].iter_errors(table)):
                wrong.append(f"{file.relative_to(ROOT)}: {error.json_path}: {error.message}")
    assert not wrong
    assert found["case"] >= 15
    assert found["section"] >= 14
    assert found["shell"] >= 5
    assert found["solid"] >= 1


MISTAKES: list[tuple[str, str, list[str], Any]] = [  # kind, file, keys, value
    ("case", "cases/slider-crank/case.toml", ["gravty"], [0.0, 0.0, 0.0]),
    ("case", "cases/slider-crank/case.toml", ["gravity"], [0.0, -9.81]),
    ("case", "cases/slider-crank/case.toml", ["solver", "rtol"], 2.0),
    ("case", "cases/slider-crank/case.toml", ["solver", "integrator"], "rk4"),
    ("case", "cases/slider-crank/case.toml", ["runs", "a b"], {}),
    ("section", "cases/sections/tube.toml", ["mesh", "outer_radius"], -1.0),
    ("section", "cases/sections/tube.toml", ["mesh", "wal"], 1.0),
    ("section", "cases/sections/tube.toml", ["materials"], {}),
    ("shell", "cases/shells/box-beam.toml", ["elements"], {"plate": "mindlin"}),
]


@pytest.mark.parametrize(("kind", "file", "keys", "value"), MISTAKES, ids=lambda v: str(v)[:30])
def test_mistakes_are_found(
    validators: dict[str, Draft202012Validator], kind: str, file: str, keys: list[str], value: Any
) -> None:
    table = tomllib.loads((ROOT / file).read_text("utf-8"))
    assert validators[kind].is_valid(table)
    changed = here = deepcopy(table)
    for key in keys[:-1]:
        here = here.setdefault(key, {})
    here[keys[-1]] = value
    assert not validators[kind].is_valid(changed)


@pytest.mark.parametrize(
    ("keys", "value"),
    [
        (["sweeps", "s"], {"run": "r", "vary": {"bodies.a.length": [1.0, 2.0]}}),
        (["sweeps", "s"], {"run": "r", "vary": {"x": {"from": 0.0, "to": 1, "count": 3}}}),
        (["bodies", "a"], {"kind": "rigid"}),  # the rest may come from a variant
    ],
)
def test_no_false_alarm(
    validators: dict[str, Draft202012Validator], keys: list[str], value: Any
) -> None:
    case = {"format": 1, "title": "t", "runs": {"r": {}}, keys[0]: {keys[1]: value}}
    assert best_match(validators["case"].iter_errors(case)) is None


def test_the_command_prints_texts_with_units(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["schema"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found == json_schema("case")
    beam = found["$defs"]["BeamBody"]["properties"]
    assert beam["length"]["exclusiveMinimum"] == 0
    assert beam["length"]["description"].endswith("which has a length [m]")
    assert main(["schema", "solid"]) == 0
    assert json.loads(capsys.readouterr().out) == json_schema("solid")
