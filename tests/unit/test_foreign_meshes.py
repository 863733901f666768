"""Meshes of other programs: regions and curves by name, arrays for the preprocessor."""

import hashlib
import json
from pathlib import Path

import numpy as np
import pytest

from plymotion.solver.errors import InputError
from plymotion.solver.inputs.section import foreign
from plymotion.solver.inputs.section.foreign import read_foreign
from plymotion.solver.inputs.section.specification import load_section

ABAQUS = """\
*NODE
1, 0., 0., 0.
2, 1., 0., 0.
3, 2., 0., 0.
4, 0., 1., 0.
5, 1., 1., 0.
6, 2., 1., 0.
99, 7., 7., 7.
*ELEMENT, TYPE=CPS4, ELSET=EALL
10, 1, 2, 5, 4
11, 2, 3, 6, 5
*ELSET, ELSET=left
10
*ELSET, ELSET=right
11
"""

SQUARES = np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0], [0, 1, 0], [1, 1, 0], [2, 1, 0]], dtype=float)
QUADS = np.array([[0, 1, 4, 3], [1, 2, 5, 4]])

DESCRIPTION = """\
format = 1
title = "Two materials"

[mesh]
file = "{file}"

[materials.steel]
kind = "isotropic"
E = 210e9
nu = 0.3
rho = 7850.0

[materials.foam]
kind = "isotropic"
E = 1e8
nu = 0.3
rho = 80.0

[regions.{first}]
material = "steel"

[regions.{second}]
material = "foam"
"""


def describe(folder: Path, file: str, first: str, second: str, more: str = "") -> Path:
    path = folder / "two.toml"
    text = DESCRIPTION.format(file=file, first=first, second=second)
    path.write_text(text.replace("[materials.steel]", more + "\n[materials.steel]", 1))
    return path


def arrays(spec: dict) -> dict:
    file = Path(spec["mesh"]["arrays"])
    assert spec["mesh"]["sha256"] == hashlib.sha256(file.read_bytes()).hexdigest()
    with np.load(file) as stored:
        return {name: stored[name] for name in stored.files}


def write(path: Path, cells: list, points: np.ndarray = SQUARES, **data) -> None:
    import meshio  # it takes long, and is loaded by the process that needs it

    meshio.write(path, meshio.Mesh(points, cells, **data))


@pytest.fixture
def abaqus(tmp_path: Path) -> Path:
    (tmp_path / "two.inp").write_text(ABAQUS)
    return tmp_path


def test_element_sets_become_regions(abaqus):
    spec = load_section(describe(abaqus, "two.inp", "left", "right"), abaqus / "out")
    found = arrays(spec)
    assert str(found["cell_type"]) == "quad"
    assert found["cells"].tolist() == QUADS.tolist()
    assert np.array_equal(found["points"], SQUARES[:, :2])  # without the node of no element
    assert found["region"].tolist() == [0, 1]
    assert found["region_names"].tolist() == ["left", "right"] == list(spec["regions"])
    assert Path(spec["mesh"]["arrays"]).resolve().parent == abaqus / "out"
    json.dumps(spec)


def test_all_takes_the_cells_of_no_other_region(abaqus):
    spec = load_section(describe(abaqus, "two.inp", "all", "right"), abaqus)
    found = arrays(spec)
    assert found["region_names"][found["region"]].tolist() == ["all", "right"]
    # it has no cells: the preprocessor gets no empty region
    spec = load_section(describe(abaqus, "two.inp", "all", "EALL"), abaqus)
    assert list(spec["regions"]) == ["EALL"]


def test_the_same_mesh_is_the_same_file(abaqus):
    description = describe(abaqus, "two.inp", "left", "right")
    first = load_section(description, abaqus)["mesh"]
    assert load_section(description, abaqus)["mesh"] == first
    (abaqus / "two.inp").write_text(ABAQUS.replace("2, 1., 0.", "2, 1.1, 0."))
    assert load_section(description, abaqus)["mesh"]["sha256"] != first["sha256"]


@pytest.mark.parametrize(
    ("first", "second", "expected"),
    [
        ("left", "rihgt", r"regions\.rihgt: two\.inp has no such region; did you mean 'right'"),
        ("left", "EALL", r"regions\.EALL: 1 of its cells in two\.inp are in region left too"),
    ],
)
def test_wrong_regions(abaqus, first, second, expected):
    with pytest.raises(InputError, match=expected):
        load_section(describe(abaqus, "two.inp", first, second), abaqus)


def test_cells_without_region(abaqus):
    text = ABAQUS.replace("*ELSET, ELSET=right\n11", "*ELSET, ELSET=right\n10")
    (abaqus / "two.inp").write_text(text.replace("*ELSET, ELSET=left\n10\n", ""))
    description = describe(abaqus, "two.inp", "right", "unused")
    text = description.read_text()
    description.write_text(text[: text.index("[regions.unused]")])
    with pytest.raises(InputError, match=r"regions: 1 of 2 cells .* they are in EALL: expected"):
        load_section(description, abaqus)


def test_integer_cell_data_names_regions_by_value(tmp_path):
    write(tmp_path / "two.vtu", [("quad", QUADS)], cell_data={"mat": [np.array([7, 9])]})
    found = arrays(load_section(describe(tmp_path, "two.vtu", "mat-7", "mat-9"), tmp_path))
    assert found["region"].tolist() == [0, 1]


def test_several_cell_data_need_a_choice(tmp_path):
    data = {"mat": [np.array([7, 9])], "part": [np.array([1, 1])]}
    write(tmp_path / "two.vtu", [("quad", QUADS)], cell_data=data)
    with pytest.raises(InputError, match=r"mesh\.region_data: missing; .* mat, part"):
        load_section(describe(tmp_path, "two.vtu", "mat-7", "mat-9"), tmp_path)
    more = 'region_data = "mat"'
    spec = load_section(describe(tmp_path, "two.vtu", "mat-7", "mat-9", more), tmp_path)
    assert list(spec["regions"]) == ["mat-7", "mat-9"]
    more = 'region_data = "mta"'
    with pytest.raises(InputError, match=r'mesh\.region_data = "mta": .* did you mean \'mat\''):
        load_section(describe(tmp_path, "two.vtu", "mat-7", "mat-9", more), tmp_path)


def test_groups_of_a_med_file_are_regions_and_curves(tmp_path):
    import meshio

    mesh = meshio.Mesh(SQUARES[:, :2], [("quad", QUADS), ("line", np.array([[4, 3], [5, 4]]))])
    mesh.cell_data = {"cell_tags": [np.array([-6, -7]), np.array([-8, -8])]}
    mesh.cell_tags = {-6: ["skin"], -7: ["core"], -8: ["outer"]}
    mesh.point_tags = {}
    meshio.write(tmp_path / "two.med", mesh)
    description = describe(tmp_path, "two.med", "skin", "core")
    with description.open("a") as stream:
        stream.write('direction = { curve = "outer" }\n')
    found = arrays(load_section(description, tmp_path))
    assert found["region"].tolist() == [0, 1]
    assert found["lines"].tolist() == [[4, 3], [5, 4]]
    assert found["curve_names"][found["curve"]].tolist() == ["outer", "outer"]
    description.write_text(description.read_text().replace('"outer"', '"inner"'))
    with pytest.raises(InputError, match=r'curve = "inner": two\.med has no curve of this name'):
        load_section(description, tmp_path)


def test_a_mesh_without_sets_is_one_region(tmp_path):
    write(tmp_path / "two.vtu", [("quad", QUADS)])
    mesh = read_foreign(tmp_path / "two.vtu", "mesh.file")
    assert {name: mask.tolist() for name, mask in mesh.sets.items()} == {"section": [True, True]}


def test_eight_node_cells_get_the_middle_that_keeps_their_shape(tmp_path):
    """The bilinear-quadratic functions of the eight nodes, at the middle of a bent cell."""
    corners = np.array([[0, 0], [2, 0.2], [2.1, 1.5], [-0.1, 1.0]])
    sides = 0.5 * (corners + np.roll(corners, -1, axis=0)) + np.array([[0, -0.1]])
    points = np.column_stack([np.concatenate([corners, sides]), np.zeros(8)])
    write(tmp_path / "one.vtu", [("quad8", np.arange(8)[None])], points=points)
    mesh = read_foreign(tmp_path / "one.vtu", "mesh.file")
    assert mesh.cell_type == "quad9"
    assert mesh.cells.tolist() == [[*range(9)]]
    shape = np.array([-0.25] * 4 + [0.5] * 4)  # N_i(0, 0)
    assert mesh.points[8] == pytest.approx(shape @ points[:, :2])


@pytest.mark.parametrize("kind", ["triangle", "triangle6", "quad", "quad9"])
def test_clockwise_cells_are_turned(tmp_path, kind):
    """Middle nodes stay between their corners."""
    count = 3 if kind.startswith("triangle") else 4
    angle = -2 * np.pi * np.arange(count) / count
    corners = np.column_stack([np.cos(angle), np.sin(angle)])
    middles = 0.5 * (corners + np.roll(corners, -1, axis=0))
    nodes = {3: [corners], 6: [corners, middles], 4: [corners], 9: [corners, middles, [[0, 0]]]}
    points = np.concatenate(nodes[int(kind[-1]) if kind[-1].isdigit() else count])
    write(
        tmp_path / "one.vtu",
        [(kind, np.arange(len(points))[None])],
        points=np.column_stack([points, np.zeros(len(points))]),
    )
    mesh = read_foreign(tmp_path / "one.vtu", "mesh.file")
    x = mesh.points[mesh.cells[0]]
    ring = x[:count]
    area = np.sum(ring[:, 0] * np.roll(ring[:, 1], -1) - ring[:, 1] * np.roll(ring[:, 0], -1))
    assert area > 0.5
    if len(x) > count:
        assert x[count : 2 * count] == pytest.approx(0.5 * (ring + np.roll(ring, -1, axis=0)))


def test_meshes_that_are_no_section(tmp_path, monkeypatch):
    lifted = SQUARES + np.array([0, 0, 1.0]) * (SQUARES[:, :1] > 1)
    cube = np.array([[x, y, z] for z in (0, 1) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))], float)
    write(tmp_path / "lifted.vtu", [("quad", QUADS)], points=lifted)
    write(tmp_path / "mixed.vtu", [("quad", QUADS[:1]), ("triangle", QUADS[1:, :3])])
    write(tmp_path / "solid.vtu", [("hexahedron", np.arange(8)[None])], points=cube)
    (tmp_path / "broken.vtu").write_text("<VTKFile")
    (tmp_path / "two.xyz").write_text("")
    cut = {  # the readers of meshio never return
        "cut.bdf": "CEND\nBEGIN BULK\n",
        "cut.tec": 'VARIABLES = "X", "Y"\nZONE NODES=3, ELEMENTS=1,\n'
        "DATAPACKING=BLOCK, ZONETYPE=FETRIANGLE\n0.0 1.0\n",
    }
    for name, text in cut.items():
        (tmp_path / name).write_text(text)
    monkeypatch.setattr(foreign, "READ_S", 0.2)
    deck = "*NODE\n1,0.,0.\n2,1.,0.\n3,1.,1.\n*ELEMENT, TYPE=CPS3\n1,1,2,3\n"
    (tmp_path / "short.inp").write_text(deck + "*ELEMENT, TYPE=CPS3\n")
    (tmp_path / "set.inp").write_text(deck.replace("CPS3", "CPS3, ELSET"))
    su2 = "NELEM= 1\n5 0 1 2 0\nNPOIN= 3\n0 0 0\n1 0 1\n0 1 2\n"  # without NDIME= 2
    (tmp_path / "flat.su2").write_text(su2)
    for file, expected in {
        "flat.su2": "meshio cannot read it: its nodes have neither two nor three coordinates",
        "lifted.vtu": "third coordinates from 0 to 1: expected a flat mesh",
        "mixed.vtu": r"cells of several types \(1 quad, 1 triangle\)",
        "solid.vtu": "its cells are of type hexahedron, expected plane cells",
        "broken.vtu": "meshio cannot read it",
        **dict.fromkeys(cut, "meshio cannot read it: its reader does not end"),
        "short.inp": "meshio cannot read it: nodes of its cells of type triangle are missing",
        "set.inp": "meshio cannot read it: one of its sets has no name",
        "two.xyz": "meshio cannot read it: Could not deduce",
    }.items():
        description = describe(tmp_path, file, "left", "right")
        with pytest.raises(InputError, match=expected) as error:
            load_section(description, tmp_path)
        assert f'{description}: mesh.file = "{file}": ' in str(error.value)
    assert not list(tmp_path.glob("*.npz"))
