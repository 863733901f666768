"""Messages about wrong input files of VABS and BECAS, and what is read from sound ones."""

from pathlib import Path

import numpy as np
import pytest

from plymotion.solver.errors import InputError
from plymotion.solver.inputs.section.becas_input import read_becas
from plymotion.solver.inputs.section.other_codes import is_of_another_code
from plymotion.solver.inputs.section.per_cell import ABSENT, QUADRILATERAL, TRIANGLE
from plymotion.solver.inputs.section.vabs_input import read_vabs

SOUND = """0 0           ! old format
1 0 0
1 0 0 0
0.1, 0.0, -0.2        # twist and curvature
6 2 2
1 0.0 0.0
2 1.0D0 0.0
3 1 1
4 0 1
5 2 0
6 2 1
1 1 2 3 4 0 0 0 0 0
2 2 5 3 0 0 0 0 0 0
1 2 30. 10. 540. 0 0 0 0 0 0 0
2 1 0. 10. 20. 30. 0 0 0 0 0 0
1 0
70e9 0.3
2700.
2 1
1e9 2e9 3e9
4e8 5e8 6e8
0.1 0.2 0.3
1500.
"""


def vabs(folder: Path, text: str) -> Path:
    file = folder / "part.sg"
    file.write_text(text)
    return file


def test_vabs(tmp_path: Path) -> None:
    section = read_vabs(vabs(tmp_path, SOUND))
    assert section.kind.tolist() == [QUADRILATERAL, TRIANGLE]
    assert section.nodes[1].tolist() == [1, 4, 2, *[ABSENT] * 6]
    assert section.points[1].tolist() == [1.0, 0.0]
    assert section.curvature == (0.1, 0.0, -0.2)
    assert section.theta1[0].tolist() == [10.0] * 9  # 540 says: the first holds for all
    assert section.theta1[1, :3].tolist() == [10.0, 20.0, 30.0]
    assert [section.plies[i] for i in section.ply] == [("material-2", 30.0), ("material-1", 0.0)]
    assert section.materials["material-2"]["G23"] == 6e8
    assert section.materials["material-1"] == {
        "kind": "isotropic",
        "E": 70e9,
        "nu": 0.3,
        "rho": 2700.0,
    }


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("1 1 2 3 4 0", "1 1 2 3 9 0", r"line 12: 9: expected a node of cell 1, .* to 6"),
        ("1 1 2 3 4 0", "1 1 2 2 4 0", r"cell 1: expected 3 or 4 corners, and each node once"),
        ("1 0 0 0\n0.1", "1 1 0 0\n0.1", r"oblique sections are not supported"),
        ("2 1\n1e9", "2 2\n1e9", r"the file ends before the constants"),
        ("0.1 0.2 0.3\n1500.\n", "", r"the file ends before the constants of material 2"),
        ("6 2 2\n", "6 x 2\n", r"line 5: 'x': expected the number of cells"),
        ("3 1 1\n", "2 1 1\n", r"node 3 has no position"),
        (
            "1 2 30.",
            "1 3 30.",
            r"3: expected the material of cell 1, a whole number from 1 up to 2",
        ),
    ],
)
def test_wrong_vabs_input(old: str, new: str, message: str, tmp_path: Path) -> None:
    assert old in SOUND
    with pytest.raises(InputError, match=message):
        read_vabs(vabs(tmp_path, SOUND.replace(old, new, 1)))


def becas(folder: Path, **changes: str) -> Path:
    texts = {
        "N2D": "10 0 0\n20 1 0\n30 1 1\n40 0 1\n50 2 0\n",
        "E2D": "1 10 20 30 40 0 0 0 0\n2 20 50 30 30 0 0 0 0\n",
        "EMAT": "2 1 0 5\n1 1 30 -90\n",
        "MATPROPS": "1e9 2e9 3e9 4e8 5e8 6e8 0.1 0.2 0.3 1500\n",
    } | changes
    for name, text in texts.items():
        (folder / f"{name}.in").write_text(text)
    return folder


def test_becas(tmp_path: Path) -> None:
    folder = becas(tmp_path)
    assert is_of_another_code(folder)
    section = read_becas(folder)
    assert section.kind.tolist() == [QUADRILATERAL, TRIANGLE]
    assert section.nodes[1, :3].tolist() == [1, 4, 2]
    np.testing.assert_array_equal(section.theta1, [[-90.0], [5.0]])
    assert section.plies[section.ply[0]] == ("material-1", 30.0)


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("E2D", "1 10 20 30 99 0 0 0 0\n", r"E2D.in: cell 1: node 99 does not exist"),
        ("E2D", "1 10 20\n", r"E2D.in: rows of 3 numbers, expected 5 or 9"),
        ("EMAT", "1 1 0 0\n", r"EMAT.in: no row for cell 2"),
        ("EMAT", "1 2 0 0\n2 1 0 0\n", r"EMAT.in: material 2: expected a row of MATPROPS.in"),
        ("N2D", "a b c\n", r"N2D.in: expected rows of numbers"),
    ],
)
def test_wrong_becas_input(name: str, text: str, message: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=message):
        read_becas(becas(tmp_path, **{name: text}))
