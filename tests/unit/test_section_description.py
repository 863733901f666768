"""Section descriptions: expansion, and one message line for each error."""

import json
import re
import tomllib
from pathlib import Path

import pytest
from samples.section_texts import BOX, replaced

from plymotion.solver.errors import InputError
from plymotion.solver.inputs.manual import page_keys, with_keys
from plymotion.solver.inputs.section.description import Laminate
from plymotion.solver.inputs.section.specification import load_section

READY = {
    "airfoil",
    "box-cus-15",
    "box-layup-1",
    "box-layup-2",
    "box-layup-3",
    "box-layup-3-as-printed",
    "channel",
    "disc",
    "i-beam",
    "pendulum-arm",
    "square",
    "strip-30",
    "tube",
    "two-cell",
}


@pytest.fixture
def box(tmp_path: Path) -> Path:
    file = tmp_path / "box.toml"
    file.write_text(BOX)
    return file


def angles(region: dict) -> list[float]:
    return [ply["angle_deg"] for ply in region["plies"]]


def test_ready_descriptions_are_valid(repository):
    files = sorted((repository / "cases/sections").glob("*.toml"))
    assert {file.stem for file in files} == READY
    for file in files:
        spec = load_section(file)
        assert spec["name"] == file.stem
        json.dumps(spec, allow_nan=False)
        strong = {"strength" in material for material in spec["materials"].values()}
        assert strong == {True} or not file.stem.startswith("box")


def test_boxes_have_the_lay_ups_of_the_paper(repository):
    """Table I of the paper; 0 deg outermost in lay-up 2, as the published stiffness requires."""

    def of(name: str) -> dict[str, list[float]]:
        spec = load_section(repository / f"cases/sections/{name}.toml")
        assert spec["convention"] == "contour"
        for region in spec["regions"].values():
            assert [ply["thickness"] for ply in region["plies"]] == [0.000127] * 6
        return {name: angles(region) for name, region in spec["regions"].items()}

    walls = ("top", "right", "bottom", "left")
    assert of("box-layup-1") == dict.fromkeys(walls, [0] * 6)
    assert of("box-layup-2") == dict.fromkeys(walls, [0, 30] * 3)
    assert of("box-cus-15") == dict.fromkeys(walls, [15] * 6)
    layup_3 = {"top": [15] * 6, "bottom": [-15] * 6, "left": [-15, 15] * 3, "right": [15, -15] * 3}
    assert of("box-layup-3") == layup_3
    assert of("box-layup-3-as-printed") == {**layup_3, "right": [15] * 6}


def test_walls_get_plies_directions_and_rows(box):
    spec = load_section(box)
    assert list(spec) == ["name", "title", "convention", "mesh", "materials", "regions"]
    assert spec["mesh"]["script"] == "box"
    assert spec["mesh"]["parameters"]["wall_left"] == 0.000762
    rows = spec["mesh"]["parameters"]["rows"]
    for ply in range(1, 7):  # each ends on a mesh line
        assert min(abs(row - ply / 6) for row in rows) < 1e-9
    directions = {name: region["direction"]["vector"] for name, region in spec["regions"].items()}
    assert directions == {"top": [1, 0], "right": [0, -1], "bottom": [-1, 0], "left": [0, 1]}
    assert angles(spec["regions"]["top"]) == [0, 30, 0, 30, 0, 30]
    assert angles(spec["regions"]["left"]) == [-15, -15, 15, 15, -15, -15]
    assert spec["regions"]["left"]["plies"][0] == {
        "material": "cfrp",
        "angle_deg": -15.0,
        "thickness": 0.000127,
    }
    assert "strength" not in spec["materials"]["cfrp"]


def test_repeat_comes_before_symmetric():
    short = Laminate(material="a", angles_deg=[0, 30], repeat=2, symmetric=True)
    assert angles({"plies": short.stack()}) == [0, 30, 0, 30, 30, 0, 30, 0]
    assert all("thickness" not in ply for ply in short.stack())


def test_thickness_of_a_wall_follows_from_its_plies(box):
    given = load_section(box)["mesh"]
    followed = load_section(replaced(box, ("wall = 0.000762\n", "")))["mesh"]
    assert followed == given


def test_plies_too_thick_for_a_floating_point_number(box):
    with pytest.raises(InputError, match="its 6 plies are inf m thick in all"):
        load_section(replaced(box, ("ply_thickness = 0.000127", "ply_thickness = 1e308")))


def test_plies_without_thickness_share_the_wall(box):
    spec = load_section(replaced(box, ("ply_thickness = 0.000127\n", "")))
    assert all("thickness" not in ply for ply in spec["regions"]["top"]["plies"])


def test_convention_may_be_left_out_without_angles(box):
    replaced(box, ('convention = "contour"\n', ""), ("[0, 30]", "[0, 0]"))
    replaced(box, ("angle_deg = -15.0", "angle_deg = 0"), ("angle_deg = 15.0", "angle_deg = 0"))
    assert load_section(box)["convention"] == "contour"


def test_only_what_is_used_is_in_the_specification(box):
    before = load_section(box)
    with box.open("a") as stream:
        stream.write(
            '\n[materials.spare]\nkind = "isotropic"\nE = 1e9\nnu = 0.3\nrho = 1.0\n'
            '[laminates.spare]\nmaterial = "spare"\nangles_deg = [45]\n'
        )
    assert load_section(box) == before


def test_direction_and_degree_may_be_given(box):
    top = '[regions.top]\nlaminate = "skin"\n'
    replaced(box, (top, top + "direction = { vector = [-2, 0] }\n"), ("width", "degree = 3\nwidth"))
    spec = load_section(box)
    assert spec["regions"]["top"]["direction"] == {"vector": [-2, 0]}
    assert spec["mesh"]["degree"] == 3


BAD = {
    "version": ("format = 1", "format = 2", "format = 2: value should be 1"),
    "toml": ("[mesh]", "[mesh", "not valid TOML"),
    "key": ("width = 0", "widht = 0", "mesh.widht: unknown key; did you mean 'width'?"),
    "missing": ("height = 0.0136\n", "", "mesh.height: missing"),
    "size": ("height = 0.0136", "height = -1", "mesh.height = -1: value should be greater than 0"),
    "shape": ('"box"', '"bxo"', r'mesh.shape = "bxo": expected one of .*; did you mean \'box\'\?'),
    "no mesh": ('shape = "box"\n', "", "mesh.shape: missing; .* or the key file"),
    "fit": (
        "height = 0.0136",
        "height = 0.001",
        r"mesh\.wall_top = 0\.000762: expected, with wall",
    ),
    "convention": (
        'convention = "contour"\n',
        "",
        r'convention: missing; expected "contour" or "cartesian": regions\.top has a ply at 30 deg',
    ),
    "other convention": ('"contour"', '"contuor"', 'convention = "contuor": value should be'),
    "laminate": (
        'laminate = "skin"',
        'laminate = "skim"',
        r"regions\.top\.laminate = \"skim\": no such laminate; did you mean 'skin'\?",
    ),
    "material of plies": (
        'material = "cfrp"\nangles',
        'material = "cfpr"\nangles',
        r"laminates\.skin = \"cfpr\": no such material; did you mean 'cfrp'\?",
    ),
    "material of a region": (
        'laminate = "skin"',
        'material = "cfk"',
        r'regions\.top\.material = "cfk": no such material; ',
    ),
    "wall": (
        "[regions.top]",
        "[regions.tpo]",
        r"regions\.tpo: a box has no such wall; did you mean 'top'\?",
    ),
    "wall without region": ("[regions.all]", "[regions.left]", r"regions\.right: missing; a box"),
    "thickness": (
        "repeat = 3",
        "repeat = 2",
        r"regions\.top: its 4 plies are 0\.000508 m thick in all, expected mesh\.wall = 0\.000762",
    ),
    "mixed thickness": (
        "angle_deg = 15.0, thickness = 0.000127",
        "angle_deg = 15.0",
        r"laminates\.side = .*: expected `thickness` in all plies or in none",
    ),
    "both forms": (
        "symmetric = true",
        "angles_deg = [0]",
        r"laminates\.side = .*: expected either `plies` or the short form",
    ),
    "no form": ('material = "cfrp"\nangles', "angles", r"laminates\.skin = .*: expected `plies`,"),
    "angle": ("[0, 30]", "[0, 130]", r"laminates\.skin\.angles_deg\.1 = 130: .*equal to 90"),
    "laminate and material": (
        'laminate = "skin"',
        'laminate = "skin"\nmaterial = "cfrp"',
        r"regions\.top = .*: expected either `laminate` or `material`",
    ),
    "angle of a laminate": (
        'laminate = "skin"',
        'laminate = "skin"\nangle_deg = 3',
        r"regions\.top = .*: expected `angle_deg` with `material` only",
    ),
    "two directions": (
        'laminate = "skin"',
        'laminate = "skin"\ndirection = { vector = [1, 0], circle = [0, 0] }',
        r"regions\.top\.direction = .*: expected one of `vector`, `curve`, `circle`",
    ),
    "no length": (
        'laminate = "skin"',
        'laminate = "skin"\ndirection = { vector = [0, 0] }',
        r"regions\.top\.direction = .*: expected a vector of non-zero length",
    ),
    "a modulus in GPa": ("E1 = 142e9", "E1 = 142", r"cfrp\.E1 = 142: expected Pa.*in GPa\?"),
    "elastic constants": ("nu12 = 0.42", "nu12 = 4.2", r"materials\.cfrp\.nu12 = 4\.2: expected"),
    "strength": (
        "rho = 1600.0",
        "rho = 1600.0\nstrength = { Xt = 1e9, Xc = 1e9, Yt = 4e7, Yc = 2e8, S21 = 8e7 }",
        r"materials\.cfrp\.strength\.S21: unknown key; did you mean 'S2",
    ),
}


@pytest.mark.parametrize("name", list(BAD))
def test_what_is_wrong_is_said_in_a_line(name, box):
    old, new, expected = BAD[name]
    with pytest.raises(InputError) as error:
        load_section(replaced(box, (old, new)))
    lines = str(error.value).splitlines()
    assert all(line.startswith(f"{box}: ") for line in lines)
    assert any(re.search(expected, line) for line in lines), str(error.value)


def test_errors_come_together(box):
    replaced(box, ('convention = "contour"\n', ""), ("nu12 = 0.42", "nu12 = 4.2"))
    replaced(box, ("repeat = 3", "repeat = 2"), ("[regions.top]", "[regions.top]\n[regions.tip]"))
    replaced(box, ("[regions.tip]", '[regions.tip]\nmaterial = "cfpr"\n[regions.bottom]'))
    with pytest.raises(InputError) as error:
        load_section(replaced(box, ("[regions.top]\n", '[regions.top]\nlaminate = "skin"\n')))
    found = str(error.value)
    for word in ("nu12", "convention", "regions.top: its 4 plies", "regions.tip: a box", '"cfpr"'):
        assert word in found


STRIP = """
format = 1
title = "strip"
{along}
[mesh]
shape = "strip"
width = {width}
height = {height}
{rows}
[materials.m]
kind = "isotropic"
E = 70e9
nu = 0.3
rho = 2700.0
[regions.section]
material = "m"
"""
TWIST = "initial_curvature = [0.3, 0.0, 0.0]"


@pytest.mark.parametrize(
    ("along", "width", "height", "rows", "columns_and_rows"),
    [
        (TWIST, 1.0, 1e-3, "", (None, 2)),
        (TWIST, 1e-3, 1.0, "", (2, None)),
        (TWIST, 1.0, 1e-3, "elements_3 = 5", (None, 5)),
        ("", 1.0, 1e-3, "", (None, 10)),
        (TWIST, 1.0, 0.1, "", (None, 10)),
    ],
)
def test_thin_twisted_strips_have_two_elements_across(
    tmp_path, along, width, height, rows, columns_and_rows
):
    file = tmp_path / "strip.toml"
    file.write_text(STRIP.format(along=along, width=width, height=height, rows=rows))
    parameters = load_section(file, tmp_path)["mesh"]["parameters"]
    for key, expected in zip(("columns", "rows"), columns_and_rows, strict=True):
        assert len(parameters[key]) == expected or (expected is None and len(parameters[key]) > 20)


def test_missing_file(tmp_path):
    with pytest.raises(InputError, match="no such section description"):
        load_section(tmp_path / "box.toml")


def test_page_is_current(repository):
    """docs/section-description.md is what `make docs` writes."""
    page = (repository / "docs/section-description.md").read_text()
    assert with_keys(page, "section") == page


def test_every_key_has_unit_and_meaning():
    rows = [r for r in page_keys("section") if r.startswith("| `") and r.count("|") >= 7]
    assert len(rows) > 90
    for row in rows:
        cells = [cell.strip() for cell in row.split("|")]
        assert cells[-2], f"no meaning: {row}"
        assert cells[3] or cells[2] not in ("number", "list of number"), f"no unit: {row}"


def test_examples_of_the_page_are_valid(tmp_path, repository):
    page = (repository / "docs/section-description.md").read_text()
    first, second = re.findall(r"```toml\n(.*?)```", page, re.DOTALL)
    file = tmp_path / "first.toml"
    file.write_text(first)
    assert list(load_section(file)["regions"]) == ["top", "right", "bottom", "left"]
    (tmp_path / "half-round.geo").write_text(re.search(r"```\n(// half.*?)```", page, re.DOTALL)[1])
    materials = first[first.index("[materials") : first.index("[laminates")]
    file.write_text(
        'format = 1\ntitle = "own"\nconvention = "contour"\n'
        + second
        + materials
        + '[materials.aluminium]\nkind = "isotropic"\nE = 70e9\nnu = 0.3\nrho = 2700.0\n'
        '[laminates.shell]\nmaterial = "cfrp"\nangles_deg = [45, -45]\nsymmetric = true\n'
    )
    assert list(load_section(file)["regions"]) == ["arch", "plate"]
    assert set(tomllib.loads(second)) == {"mesh", "regions"}
