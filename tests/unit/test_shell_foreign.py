"""Surface meshes of other programs for gmsh: both kinds of cells, sets, refusals."""

from pathlib import Path

import pytest

from plymotion.solver.errors import InputError
from plymotion.solver.inputs.section.foreign import gmsh_mesh

DECK = """*NODE
1, 0., 0., 0.
2, 1., 0., 0.
3, 2., 0., 0.1
4, 0., 1., 0.
5, 1., 1., 0.
6, 2., 1., 0.1
9, 5., 5., 5.
*ELEMENT, TYPE=S4, ELSET=skin
1, 1, 2, 5, 4
*ELEMENT, TYPE=S3, ELSET=flap
2, 2, 3, 6
3, 2, 6, 5
*ELEMENT, TYPE=B31, ELSET=root
4, 1, 4
*NSET, NSET=corner
3
"""


@pytest.fixture
def deck(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    pytest.importorskip("meshio")
    monkeypatch.chdir(tmp_path)
    file = tmp_path / "wing.inp"
    file.write_text(DECK)
    return file


def test_triangles_quadrilaterals_and_sets(deck: Path) -> None:
    meshio = pytest.importorskip("meshio")
    target = gmsh_mesh(deck, "mesh.file", Path("build"), 2, ())
    assert target.parent == Path("build")
    mesh = meshio.read(target)
    name_of = {int(tag): name for name, (tag, _) in mesh.field_data.items()}
    found = [
        (name_of[int(tag)], block.type, (nodes + 1).tolist())
        for block, tags in zip(mesh.cells, mesh.cell_data["gmsh:physical"], strict=True)
        for nodes, tag in zip(block.data, tags, strict=True)
    ]
    assert sorted(found) == [
        ("corner", "vertex", [3]),
        ("flap", "triangle", [2, 3, 6]),
        ("flap", "triangle", [2, 6, 5]),
        ("root", "line", [1, 4]),
        ("skin", "quad", [1, 2, 5, 4]),
    ]
    assert mesh.points[2].tolist() == [2.0, 0.0, 0.1]
    written = target.stat().st_mtime_ns
    assert gmsh_mesh(deck, "mesh.file", Path("build"), 2, ()) == target
    assert target.stat().st_mtime_ns == written


def test_refusals(deck: Path) -> None:
    deck.write_text(DECK.replace("S4", "S8R").replace("1, 1, 2, 5, 4", "1, 1, 2, 5, 4, 1, 2, 5, 4"))
    with pytest.raises(InputError, match=r"cells are of type quad8, expected triangle and quad"):
        gmsh_mesh(deck, "mesh.file", Path("build"), 2, ())
    deck.write_text(DECK + "*ELSET, ELSET=both\n2, 3\n")
    with pytest.raises(InputError, match=r"cell 2 is in 2 sets .*expected exactly one"):
        gmsh_mesh(deck, "mesh.file", Path("build"), 2, ())
    with pytest.raises(InputError, match=r"cell 1 is in 0 sets .*expected exactly one"):
        gmsh_mesh(deck, "mesh.file", Path("build"), 2, ("flap",))


@pytest.mark.parametrize(
    ("regions", "expected"),
    [
        (("skin", "flap"), {"skin": 1, "flap": 2}),
        (("flap", "all"), {"other cells": 1, "flap": 2}),
        (("all",), {"other cells": 3}),
    ],
)
def test_of_sets_that_overlap_those_of_the_description_count(
    deck: Path, regions: tuple[str, ...], expected: dict[str, int]
) -> None:
    """As a set of all cells, which most decks have."""
    meshio = pytest.importorskip("meshio")
    deck.write_text(DECK + "*ELSET, ELSET=EALL\n1, 2, 3\n")
    mesh = meshio.read(gmsh_mesh(deck, "mesh.file", Path("build"), 2, regions))
    tags = [
        tag
        for block, tags in zip(mesh.cells, mesh.cell_data["gmsh:physical"], strict=True)
        for tag in tags
        if block.dim == 2
    ]
    numbers = {name: int(tag) for name, (tag, dim) in mesh.field_data.items() if dim == 2}
    assert {name: tags.count(tag) for name, tag in numbers.items()} == expected
