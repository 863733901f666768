"""Section descriptions with a mesh of one's own: a Gmsh file or a script."""

import hashlib
import tomllib
from pathlib import Path

import pytest
from samples.section_texts import BOX, replaced

from plymotion.solver.errors import InputError
from plymotion.solver.inputs.section.specification import load_section, source_files


@pytest.fixture
def box(tmp_path: Path) -> Path:
    file = tmp_path / "box.toml"
    file.write_text(BOX)
    return file


MSH = """\
$MeshFormat
4.1 0 8
$EndMeshFormat
$PhysicalNames
3
1 3 "outer"
2 1 "core"
2 2 "top skin"
$EndPhysicalNames
"""


OWN = """
[regions."top skin"]
laminate = "skin"
direction = { curve = "outer" }

[regions.core]
material = "cfrp"
"""


@pytest.fixture
def own(box) -> Path:
    """A description with a mesh of its own, own.msh."""
    text = box.read_text()
    mesh, regions = text.index("[mesh]"), text.index("[regions.top]")
    text = text[:mesh] + '[mesh]\nfile = "own.msh"\n\n' + text[text.index("[materials") : regions]
    box.write_text(text + OWN)
    (box.parent / "own.msh").write_text(MSH)
    return box


def test_gmsh_meshes_are_handed_over(own, monkeypatch):
    replaced(own, ('"own.msh"', '"own.msh"\nscale = 1e-3'))
    spec = load_section(own)
    assert Path(spec["mesh"]["file"]).resolve() == own.parent / "own.msh"
    assert spec["mesh"]["sha256"] == hashlib.sha256(MSH.encode()).hexdigest()
    assert spec["mesh"]["scale"] == 1e-3
    assert spec["regions"]["top skin"]["direction"] == {"curve": "outer"}
    assert spec["regions"]["core"] == {"plies": [{"material": "cfrp", "angle_deg": 0.0}]}
    monkeypatch.chdir(own.parent)
    assert load_section(own)["mesh"]["file"] == "own.msh"  # relative to the working directory
    assert source_files(tomllib.loads(own.read_text()), own) == [own, own.parent / "own.msh"]


def test_all_stands_for_the_other_physical_surfaces(own):
    assert list(load_section(replaced(own, ("core", "all")))["regions"]) == ["core", "top skin"]


def test_a_script_has_parameters_and_the_content_of_what_it_includes(own):
    script = own.parent / "own.geo"
    script.write_text('Include "part.geo";\n')
    replaced(own, ('"own.msh"', '"own.geo"\nparameters = { radius = 0.02, rows = [0.5, 1.0] }'))
    hashes = set()
    for part in (None, "wall = 1;", "wall = 2;"):
        if part is not None:
            (own.parent / "part.geo").write_text(part)
        mesh = load_section(own)["mesh"]
        assert mesh["parameters"] == {"radius": 0.02, "rows": [0.5, 1.0]}
        hashes.add(mesh["sha256"])
    assert len(hashes) == 3


BAD_OWN = {
    "file": ('"own.msh"', '"on.msh"', r'mesh\.file = "on\.msh": there is no file'),
    "region": (
        "[regions.core]",
        "[regions.cor]",
        r"regions\.cor: own\.msh has no physical surface of this name; did you mean 'core'\?",
    ),
    "no region": ('[regions.core]\nmaterial = "cfrp"', "", r"regions\.core: missing; own\.msh has"),
    "curve": (
        'curve = "outer"',
        'curve = "otter"',
        r"direction\.curve = \"otter\": own\.msh has no curve of this name; did you mean 'outer'\?",
    ),
    "direction of a laminate": (
        'direction = { curve = "outer" }',
        "",
        r"regions\.top skin\.direction: missing, needed for the laminate \"skin\"",
    ),
    "direction of an angle": (
        "[regions.core]",
        "[regions.core]\nangle_deg = 20",
        r"regions\.core\.direction: missing, needed for the angle 20 deg",
    ),
    "parameters": (
        '"own.msh"',
        '"own.msh"\nparameters = { radius = 1 }',
        r"mesh\.parameters: expected with a \.geo script only",
    ),
    "region_data": ('"own.msh"', '"own.msh"\nregion_data = "id"', r'mesh\.region_data = "id": '),
}


@pytest.mark.parametrize("name", list(BAD_OWN))
def test_what_is_wrong_with_a_mesh_of_ones_own(name, own):
    old, new, expected = BAD_OWN[name]
    replaced(own, (old, new))
    with pytest.raises(InputError, match=expected):
        load_section(own)


def test_a_mesh_without_names_is_refused(own):
    (own.parent / "own.msh").write_text(MSH[: MSH.index("$PhysicalNames")])
    with pytest.raises(InputError, match=r'mesh\.file = "own\.msh": no physical surface'):
        load_section(own)


def test_all_regions_of_a_script_at_once(own):
    """Only gmsh knows their names: the table remains one for `all`."""
    (own.parent / "own.geo").write_text("")
    replaced(own, ("own.msh", "own.geo"), ("[regions.core]", "[regions.all]"))
    assert "all" in load_section(own)["regions"]
