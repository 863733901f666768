"""Shell bodies of a case: what goes to the preprocessor, and what is refused before it."""

import json
from pathlib import Path
from typing import Any

import pytest

from plymotion.solver.errors import InputError
from plymotion.solver.inputs.case.load import load_case, source_files
from plymotion.solver.inputs.case.write import write_case
from plymotion.solver.package.common.plain_data import inputs_sha256

DESCRIPTION = """
format = 1
title = "Plate"
[mesh]
file = "plate.py"
parameters = { n = 4 }
[materials.steel]
kind = "isotropic"
E = 210e9
nu = 0.3
rho = 7850.0
[regions.plate]
material = "steel"
thickness = 0.002
[supports.root]
at = "left"
fixed = "all"
[frequencies]
count = 6
"""
CASE = """
format = 1
title = "A falling plate"
gravity = [0.0, -9.81, 0.0]
[bodies.plate]
kind = "shell"
shell = "plate.toml"
modes = [{ kind = "lowest", count = 4 }]
[bodies.plate.interfaces]
root = { at = "left" }
tip = { at = "right", link = "average", rotation_deg = [0.0, 0.0, 90.0] }
[signals.tip]
kind = "position"
at = "plate.tip"
component = "y"
[solver]
t_end = 0.1
output_step = 0.01
[runs.fall]
"""


@pytest.fixture
def case(tmp_path: Path) -> Path:
    (tmp_path / "plate.toml").write_text(DESCRIPTION)
    (tmp_path / "plate.py").write_text("def build(gmsh, parameters):\n    pass\n")
    (tmp_path / "case.toml").write_text(CASE)
    return tmp_path / "case.toml"


def _spec(case: Path) -> dict[str, Any]:
    out = case.parent / "build"
    write_case(load_case(case), out)
    (file,) = (out / "bodies").glob("*.json")
    found: dict[str, Any] = json.loads(file.read_text())
    return found


def test_specification_has_the_shell_and_nothing_that_holds_or_loads_it(case: Path) -> None:
    spec = _spec(case)
    assert (spec["body"], spec["kind"], spec["mass_form"]) == ("plate", "shell", "consistent")
    assert set(spec["shell"]) == {"mesh", "materials", "laminates", "regions", "elements"}
    assert "mass_form" not in spec["shell"]["elements"]
    assert spec["shell"]["mesh"]["parameters"] == {"n": 4}
    assert spec["reference"] == {"kind": "clamped", "at": "root"}
    assert spec["interfaces"]["tip"] == {
        "at": "right",
        "link": "average",
        "rotation_deg": [0.0, 0.0, 90.0],
    }


def test_second_order_is_passed_on_where_it_is_asked_for(case: Path) -> None:
    assert "second_order" not in _spec(case)
    case.write_text(
        CASE.replace('shell = "plate.toml"', 'shell = "plate.toml"\nsecond_order = true')
    )
    assert _spec(case)["second_order"] is True


def test_hash_is_that_of_the_content(case: Path) -> None:
    before = _spec(case)
    digest = before.pop("inputs_sha256")
    assert inputs_sha256(before) == digest
    moved = json.loads(json.dumps(before))
    moved["shell"]["mesh"]["file"] = "elsewhere/plate.py"
    assert inputs_sha256(moved) == digest
    (case.parent / "plate.py").write_text("def build(gmsh, parameters):\n    return\n")
    assert _spec(case)["inputs_sha256"] != digest


def test_parameters_of_the_body_come_before_those_of_the_description(case: Path) -> None:
    case.write_text(CASE.replace('shell = "plate.toml"', 'shell = "plate.toml"\nparameters.n = 9'))
    assert _spec(case)["shell"]["mesh"]["parameters"] == {"n": 9}


def test_a_case_knows_description_and_mesh(case: Path) -> None:
    assert {file.name for file in source_files(load_case(case))} == {"plate.toml", "plate.py"}


@pytest.mark.parametrize(
    ("script", "text"),
    [("plate.py", "import sizes, os\n"), ("plate.py", "from sizes import B\n"),
     ("plate.geo", 'Include "sizes.py";\n')],
)  # fmt: skip
def test_files_that_a_script_reads_are_noticed(case: Path, script: str, text: str) -> None:
    """A case was up to date after an edit of one; the digest of imports stayed."""
    other = case.parent / "sizes.py"
    other.write_text("B = 1.0\n")
    (case.parent / script).write_text(text)
    (case.parent / "plate.toml").write_text(DESCRIPTION.replace("plate.py", script))
    assert "sizes.py" in {file.name for file in source_files(load_case(case))}
    before = _spec(case)["shell"]["mesh"]["sha256"]
    other.write_text("B = 2.0\n")
    assert _spec(case)["shell"]["mesh"]["sha256"] != before


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('"plate.toml"', '"plat.toml"', "bodies.plate.shell"),
        ('root = { at = "left" }', 'foot = { at = "left" }', 'reference.at = "root" (the default)'),
        ('{ at = "left" }', '{ at = "left", link = "average" }', "carries the body frame"),
        ('kind = "lowest", count = 4', 'kind = "torsion", count = 4', "modes.0.kind"),
        ('kind = "lowest", count = 4', 'kind = "spinning-xz", count = 4', "modes.0.kind"),
        ('"lowest", count = 4', '"attachment", at = "tpi"', "no such interface"),
        ('link = "average"', 'link = "rigit"', "interfaces.tip.link"),
        ('kind = "shell"', 'kind = "shell"\nsection = "x"', "bodies.plate.section: unknown key"),
        (
            'kind = "position"\nat = "plate.tip"\ncomponent = "y"',
            'kind = "resultant"\nbody = "plate"\nx = 0.1\ncomponent = "F1"',
            "expected a beam",
        ),
    ],
)
def test_what_is_wrong_is_named(case: Path, old: str, new: str, words: str) -> None:
    assert old in CASE
    case.write_text(CASE.replace(old, new))
    with pytest.raises(InputError) as error:
        load_case(case)
    assert words in str(error.value)


def test_errors_of_the_description_name_the_body(case: Path) -> None:
    file = case.parent / "plate.toml"
    file.write_text(DESCRIPTION.replace("thickness = 0.002", "thicknes = 0.002"))
    with pytest.raises(InputError, match="thicknes"):
        load_case(case)
