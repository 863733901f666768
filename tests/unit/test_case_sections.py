"""Sections of a case: shapes of one material, and described sections."""

import json
import re
import shutil
from pathlib import Path

import pytest

from plymotion.solver.errors import InputError
from plymotion.solver.inputs.case.load import load_case, source_files
from plymotion.solver.inputs.case.write import write_case


@pytest.fixture
def case(repository, tmp_path: Path) -> Path:
    """The case of the first steps, beside a copy of cases/sections."""
    shutil.copytree(repository / "cases/sections", tmp_path / "sections")
    file = tmp_path / "arm" / "case.toml"
    file.parent.mkdir()
    page = (repository / "docs/first-steps.md").read_text()
    file.write_text(re.search(r"```toml\n(.*?)```", page, re.DOTALL)[1])
    return file


def described(case: Path, name: str = "box-layup-2") -> Path:
    """Let the arm have a described section."""
    text = case.read_text()
    text = re.sub(
        r"\[sections\.bar\].*?\n\n",
        f'[sections.bar]\nfile = "../sections/{name}.toml"\n\n',
        text,
        flags=re.DOTALL,
    )
    case.write_text(re.sub(r'material = "carbon"\nply_angle_deg = 30\.0\n', "", text))
    return case


def section(case: Path, out: Path) -> dict:
    write_case(load_case(case), out)
    return json.loads((out / "bodies/arm.base.json").read_text())["section"]


def test_a_shape_takes_material_and_angle_from_the_body(case, tmp_path):
    spec = section(case, tmp_path / "out")
    assert spec["name"] == "bar"
    assert spec["mesh"]["script"] == "rectangle"
    assert spec["mesh"]["parameters"]["width"] == 0.040
    assert spec["regions"]["section"]["plies"] == [{"material": "carbon", "angle_deg": 30.0}]
    assert spec["regions"]["section"]["direction"] == {"vector": [1.0, 0.0]}
    assert spec["materials"]["carbon"]["E1"] == 129.2e9
    assert None not in spec["materials"]["carbon"].values()


def test_a_described_section_is_the_specification_of_its_file(case, tmp_path):
    from plymotion.solver.inputs.section.specification import load_section

    spec = section(described(case), tmp_path / "out")
    expected = load_section(tmp_path / "sections/box-layup-2.toml")
    assert spec.pop("name") == "bar"
    for key in ("name", "title"):
        del expected[key]
    assert spec == expected


def test_a_case_knows_the_files_of_its_sections(case, tmp_path):
    files = source_files(load_case(described(case)))
    assert [file.resolve() for file in files] == [tmp_path / "sections/box-layup-2.toml"]


def test_where_a_mesh_lies_does_not_change_the_body(case, tmp_path, monkeypatch):
    """Its content does."""
    file = tmp_path / "sections/own.msh"
    file.write_text('$MeshFormat\n4.1 0 8\n$PhysicalNames\n1\n2 1 "all"\n$EndPhysicalNames\n')
    text = (tmp_path / "sections/square.toml").read_text()
    mesh = re.sub(r"\[mesh\].*?\n\n", '[mesh]\nfile = "own.msh"\n\n', text, flags=re.DOTALL)
    (tmp_path / "sections/own.toml").write_text(mesh)
    described(case, "own")

    def inputs() -> str:
        write_case(load_case(case), tmp_path / "out")
        spec = json.loads((tmp_path / "out/bodies/arm.base.json").read_text())
        assert (Path.cwd() / spec["section"]["mesh"]["file"]).resolve() == file
        return spec["inputs_sha256"]

    monkeypatch.chdir(tmp_path)
    here = inputs()
    monkeypatch.chdir(tmp_path / "arm")
    assert inputs() == here
    file.write_text(file.read_text() + "\n")
    assert inputs() != here


BAD = {
    "no material": ('material = "carbon"\n', "", r"bodies\.arm\.material: missing; .*section bar"),
    "size": (
        "height = 0.010",
        "hieght = 0.010",
        r"bar\.hieght: unknown key; did you mean 'height'",
    ),
    "angle on walls": (
        'shape = "rectangle"',
        'shape = "box"\nwall = 0.001',
        r"bodies\.arm\.ply_angle_deg = 30: expected 0, a box has walls in several directions",
    ),
    "sizes": (
        'shape = "rectangle"',
        'shape = "box"\nwall = 0.1',
        r"sections\.bar\.wall_top = 0\.1: expected",
    ),
    "shape": (
        '"rectangle"',
        '"rectangel"',
        r'sections\.bar\.shape = "rectangel": .*or the key file',
    ),
}


@pytest.mark.parametrize("name", list(BAD))
def test_bad_shapes(name, case):
    old, new, expected = BAD[name]
    text = case.read_text()
    assert old in text
    case.write_text(text.replace(old, new, 1))
    with pytest.raises(InputError, match=expected):
        load_case(case)


def test_a_described_section_has_its_own_material(case):
    described(case)
    case.write_text(case.read_text().replace('kind = "beam"', 'kind = "beam"\nmaterial = "carbon"'))
    with pytest.raises(InputError, match=r"bodies\.arm\.material = carbon: expected no such key"):
        load_case(case)


def test_errors_of_a_described_section_name_both_files(case, tmp_path):
    file = tmp_path / "sections/box-layup-2.toml"
    file.write_text(file.read_text().replace("width", "widht"))
    with pytest.raises(InputError) as error:
        load_case(described(case))
    (line, missing) = str(error.value).splitlines()
    assert line.startswith(f"{case}: sections.bar.file: ")
    assert line.endswith("box-layup-2.toml: mesh.widht: unknown key; did you mean 'width'?")
    assert "box-layup-2.toml: mesh.width: missing; expected a value: outer width" in missing
