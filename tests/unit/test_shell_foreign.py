"""Surface meshes of other programs as arrays: both kinds of cells, sets, refusals."""

from pathlib import Path

import numpy as np
import pytest

from plymotion.solver.errors import InputError
from plymotion.solver.inputs.shell_specification import shell_arrays

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
    target, content = shell_arrays(deck, "mesh.file")
    assert target.name == f"wing-{content[:12]}.npz"
    with np.load(target) as data:
        assert data["cells"].tolist() == [[0, 1, 4, 3], [1, 2, 5, -1], [1, 5, 4, -1]]
        assert data["points"].shape == (6, 3)  # without the node of no cell
        assert data["points"][2].tolist() == [2.0, 0.0, 0.1]
        assert [str(data["regions"][row]) for row in data["region"]] == ["skin", "flap", "flap"]
        assert data["curve:root"].tolist() == [[0, 3]]
        assert data["point:corner"].tolist() == [2]
    again = shell_arrays(deck, "mesh.file")
    assert again == (target, content)


def test_refusals(deck: Path) -> None:
    deck.write_text(DECK.replace("S4", "S8R").replace("1, 1, 2, 5, 4", "1, 1, 2, 5, 4, 1, 2, 5, 4"))
    with pytest.raises(InputError, match=r"cells are of type quad8, expected triangle and quad"):
        shell_arrays(deck, "mesh.file")
    deck.write_text(DECK + "*ELSET, ELSET=both\n2, 3\n")
    with pytest.raises(InputError, match=r"cell 2 is in 2 sets .*expected exactly one"):
        shell_arrays(deck, "mesh.file")
