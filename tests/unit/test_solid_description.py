"""Descriptions of solids: keys, references, and the specification that they become."""

from pathlib import Path
from typing import Any

import meshio
import numpy as np
import pytest

from plymotion.solver.errors import InputError
from plymotion.solver.inputs.case.load import load_case
from plymotion.solver.inputs.manual import with_keys
from plymotion.solver.inputs.solid_specification import solid_spec, solid_table
from plymotion.solver.package.common.plain_data import check_form
from plymotion.solver.package.specification import SolidSpecification

PLY = {
    **{"kind": "orthotropic", "E1": 120e9, "E2": 9e9, "E3": 9e9, "G12": 5e9, "G13": 5e9},
    **{"G23": 3e9, "nu12": 0.3, "nu13": 0.3, "nu23": 0.4, "rho": 1600.0},
}
PIN = {"bore": {"radius": 0.006, "point": [0.0, 0.0, 0.0], "direction": [0.0, 0.0, 1.0]}}


@pytest.fixture
def file(tmp_path: Path) -> Path:
    """A description beside a STEP file, whose content only the FE side reads."""
    (tmp_path / "part.step").write_text("ISO-10303-21;\nLENGTH_UNIT\n")
    return tmp_path / "part.toml"


def described(**more: Any) -> dict[str, Any]:
    """A description that is right."""
    return {
        "mesh": {"file": "part.step", "size": 0.004},
        "materials": {"steel": {"kind": "isotropic", "E": 210e9, "nu": 0.3, "rho": 7850.0}},
        "regions": {"all": {"material": "steel"}},
        **more,
    }


def test_a_cad_file_and_a_material_are_a_specification(file: Path) -> None:
    spec = solid_spec(file.with_name("part.step"), "steel", 0.003)
    check_form(spec, SolidSpecification)
    assert spec["solid"]["mesh"]["size"] == 0.003
    (material,) = spec["solid"]["materials"].values()
    assert (material["E"], material["nu"], material["rho"]) == (210e9, 0.3, 7850.0)
    own = solid_spec(file.with_name("part.step"), "1e9,0.4,1100", None)
    (material,) = own["solid"]["materials"].values()
    assert (material["E"], material["nu"], material["rho"]) == (1e9, 0.4, 1100.0)


def test_units_are_metres_and_unused_materials_stay_out(file: Path) -> None:
    (file.parent / "part.brep").write_text("DBRep_DrawableShape")
    table = described(mesh={"file": "part.brep", "unit": "in"})
    table["materials"]["ply"] = PLY
    _, solid = solid_table(table, file)
    assert solid["mesh"]["unit"] == 0.0254
    assert list(solid["materials"]) == ["steel"]


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"mesh": {"file": "no.step"}}, 'mesh.file = "no.step": there is no file'),
        ({"mesh": {"file": "part.step", "unit": "mm"}}, 'mesh.unit = "mm": expected none'),
        ({"mesh": {"file": "part.step", "size": 0.0}}, "mesh.size = 0.0"),
        ({"mesh": {"file": "part.step", "sise": 1.0}}, "mesh.sise: unknown key"),
        ({"mesh": {"file": "part.step", "parameters": {"n": 1.0}}}, "mesh.parameters: expected"),
        ({"regions": {"all": {"material": "stel"}}}, "did you mean 'steel'?"),
        ({"supports": ["pin"]}, 'supports = "pin": no such interface'),
        ({"interfaces": {"pin": {}}}, "expected one of bore, plane, at; found none"),
        ({"interfaces": {"pin": {**PIN, "at": "lug"}}}, "found bore and at"),
        (
            {"interfaces": {"pin": {"plane": {"point": [0.0] * 3, "normal": [0.0] * 3}}}},
            "interfaces.pin.plane",
        ),
        ({"interfaces": {"pin": PIN}, "loads": {"a": {"b": {"at": "pin"}}}}, "with `force`"),
        (
            {"interfaces": {"pin": PIN}, "loads": {"a": {"b": {"gravity": [0.0, 0.0, 1.0]}}}},
            "supports: missing",
        ),
        (
            {"materials": {"steel": PLY}},
            "regions.all.axis: missing, needed for the directions of an orthotropic material",
        ),
    ],
)
def test_what_is_wrong_is_said_with_file_and_key(
    change: dict[str, Any], words: str, file: Path
) -> None:
    with pytest.raises(InputError) as error:
        solid_table(described(**change), file)
    assert str(error.value).startswith(f"{file}: ")
    assert words in str(error.value)


def test_a_med_mesh_keeps_its_groups(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """MED counts the nodes of solid cells the other way round; gmsh then has volumes above 0."""
    monkeypatch.chdir(tmp_path)
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1]], dtype=float)
    cells, faces = np.array([[0, 2, 1, 3], [1, 2, 3, 4]]), np.array([[0, 1, 2], [0, 1, 3]])
    tags = [np.array([-1, -2]), np.array([-3, 0])]
    mesh = meshio.Mesh(
        points, [("tetra", cells), ("triangle", faces)], cell_data={"cell_tags": tags}
    )
    mesh.cell_tags = {-1: ["body"], -2: ["head"], -3: ["foot"]}
    meshio.write("part.med", mesh)
    table = described(mesh={"file": "part.med", "unit": "mm"})
    _, solid = solid_table(table, tmp_path / "part.toml")
    found = meshio.read(solid["mesh"]["file"])
    assert set(found.field_data) == {"body", "head", "foot"}
    x = found.points[np.concatenate([b.data for b in found.cells if b.type == "tetra"])]
    assert (np.linalg.det(x[:, 1:] - x[:, :1]) > 0.0).all()
    (triangles,) = (b.data for b in found.cells if b.type == "triangle")
    assert triangles.tolist() == [[0, 1, 2]]
    mesh.cell_tags = {-1: ["body"], -3: ["foot"]}
    meshio.write("part.med", mesh)
    with pytest.raises(InputError, match=r"solid cell 2 is in 0 sets \(none\)"):
        solid_table(table, tmp_path / "part.toml")


def test_a_body_has_the_interfaces_of_its_description(file: Path) -> None:
    """In metres, whatever the units of both files are; those of a case are in place of them."""
    text = 'units = "mm"\n[mesh]\nfile = "part.step"\n[materials.m]\nkind = "isotropic"\n'
    text += "E = 1e9\nnu = 0.3\nrho = 1e3\n[regions.all]\nmaterial = 'm'\n"
    pin = "bore = { radius = %g, point = [0, 0, 0], direction = [0, 0, 1] }\n"
    file.write_text(text + "[interfaces.root]\n" + pin % 6.0)
    case = file.with_name("case.toml")
    head = 'format = 1\ntitle = "a pin"\n'
    body = '[bodies.b]\nkind = "solid"\nsolid = "part.toml"\n'
    body += 'modes = [{ kind = "lowest", count = 1 }]\n'
    end = "[solver]\nt_end = 1.0\noutput_step = 0.1\n[runs.base]\n"
    for more, radius in (("", 0.006), ("[bodies.b.interfaces.root]\n" + pin % 0.5, 0.0127)):
        case.write_text(head + 'units = "in"\n' + body + more + end)
        places = load_case(case).bodies["base"]["b"].content["interfaces"]
        assert places["root"]["bore"]["radius"] == pytest.approx(radius, rel=1e-12)
    file.write_text(text)
    case.write_text(head + body + end)
    with pytest.raises(InputError, match=r"bodies\.b\.interfaces"):
        load_case(case)


def test_the_manual_is_that_of_the_models(repository: Path) -> None:
    """`make docs` has been run."""
    page = (repository / "docs" / "solid-description.md").read_text()
    assert with_keys(page, "solid") == page
