"""Messages about wrong input files of VABS and BECAS, and what is read from sound ones."""

from pathlib import Path

import numpy as np
import pytest

from plymotion.solver.errors import InputError
from plymotion.solver.inputs.section.becas import ABSENT, QUADRILATERAL, TRIANGLE, read_becas
from plymotion.solver.inputs.section.vabs import is_of_another_code, read_vabs, spec_of_another_code

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
        ("1 1 2 3 4 0", "1 1 2 3 9 0", r"line 12: 9: expected a node, one of the numbers 1 to 6"),
        ("1 1 2 3 4 0", "1 1 2 2 4 0", r"line 12: cell 1: expected 3 or 4 corners, and each"),
        ("1 0 0 0\n0.1", "1 1 0 0\n0.1", r"oblique sections are not supported"),
        ("2 1\n1e9", "2 2\n1e9", r"the file ends before the constants"),
        ("0.1 0.2 0.3\n1500.\n", "", r"the file ends before the constants of material 2"),
        ("6 2 2\n", "6 x 2\n", r"line 5: 'x': expected .* the number of cells"),
        ("3 1 1\n", "2 1 1\n", r"line 8: node 2 is also in line 7"),
        ("1 2 30.", "1 3 30.", r"line 14: 3: expected the material of .*, one of 1, 2"),
        ("1 2 30.", "7 2 30.", r"line 14: 7: expected a cell, one of the numbers 1 to 2"),
        ("1 2 30.", "2 2 30.", r"line 15: orientation 2 is also in line 14"),
        ("2 1\n1e9", "1 1\n1e9", r"line 19: material 1 was given before"),
        ("2 1\n1e9", "2 5\n1e9", r"line 19: 5: expected the kind of material 2, 0, 1 or 2"),
        ("1 0 0\n1 0 0 0", "1 0 0\n2 0 0 0", r"line 3: 2: expected the flag curved"),
        ("6 2 1\n1 1", "6 2 nan\n1 1", r"line 11: 'nan': expected the number and values of a"),
    ],
)
def test_wrong_vabs_input(old: str, new: str, message: str, tmp_path: Path) -> None:
    assert old in SOUND
    with pytest.raises(InputError, match=message):
        read_vabs(vabs(tmp_path, SOUND.replace(old, new, 1)))


NEW = """1 2   two layers, words without a sign of a comment
! flags
1 {second} 0 / Timoshenko
0 0 1 1
5 2 2
70 0 0
10 1 0

20 1 1
! the cells
40 0 1
50,2,0
8 70 10 20 40 5*0
3 10 50 20 6*0
{cells}3 2 1.5D+1
8 1 -90
{layers}
7 0
0.7-2  .3  steel
2700 ! rho
{damped}{plastic}
{end}"""
PLASTIC = "4 1\n10 10\n10 4 4\n4 .1 .1 .1\n1.5d3"


def new_layout(**changes: str) -> str:
    parts = {"second": "0", "cells": "", "damped": "", "plastic": PLASTIC, "end": ""}
    return NEW.format(**({**parts, "layers": "2 4 45.\n1 7 0.\n"} | changes))


@pytest.mark.parametrize("end", ["\n", "\r\n"])
@pytest.mark.parametrize(
    ("changes", "asked"),
    [
        ({}, []),
        ({"second": "1", "end": "0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 2 3 4\n"}, ["recovery"]),
        ({"second": "2"}, ["recovery"]),
        (
            {
                "second": "1",
                "layers": "2 4 45. 0.01\n1 7 0. 0\n",
                "damped": "0.1\n",
                "plastic": PLASTIC + "\n0.2",
            },
            ["damping"],
        ),
    ],
)
def test_vabs_reads_rows_as_fortran_does(
    changes: dict[str, str], asked: list[str], end: str, tmp_path: Path
) -> None:
    """Numbers with gaps, words after the numbers, rows over two lines, exponents and repeats."""
    file = tmp_path / "part.vab"
    file.write_bytes(b"\xef\xbb\xbf" + new_layout(**changes).replace("\n", end).encode())
    assert is_of_another_code(file)
    section = read_vabs(file)
    assert section.nodes[:, :4].tolist() == [[0, 1, 2, 3], [1, 4, 2, ABSENT]]
    assert section.points[4].tolist() == [2.0, 0.0]
    assert section.theta1.tolist() == [[-90.0], [15.0]]
    assert [section.plies[i] for i in section.ply] == [("material-7", 0.0), ("material-4", 45.0)]
    assert section.materials["material-7"]["E"] == 0.007
    assert section.materials["material-4"]["G23"] == 4.0
    assert section.materials["material-4"]["rho"] == 1500.0
    assert section.not_computed == ["trapeze", "vlasov", *asked]


def test_vabs_without_layers(tmp_path: Path) -> None:
    text = new_layout(layers="").replace("1 2   two", "1 0   two")
    text = text.replace("3 2 1.5D+1\n8 1 -90", "3 4 1.5D+1\n8 7 -90")
    section = read_vabs(vabs(tmp_path, text))
    assert [section.plies[i] for i in section.ply] == [("material-7", 0.0), ("material-4", 0.0)]


def test_old_vabs_format_with_recovery(tmp_path: Path) -> None:
    text = SOUND.replace("\n1 0 0\n", "\n1 1 0\n", 1)
    section = read_vabs(vabs(tmp_path, text + "0 0 0\n1 0 0\n0 1 0\n0 0 1\n5 6 7 8\n"))
    assert section.not_computed == ["recovery"]
    assert section.materials["material-2"]["rho"] == 1500.0
    with pytest.raises(InputError, match=r"line 21: 'x': expected the constants of material 2"):
        read_vabs(vabs(tmp_path, text.replace("4e8 5e8", "4e8 x")))


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


def test_becas_as_matlab_reads_numbers(tmp_path: Path) -> None:
    numbers = "1.0D+09, 2d9, 3e9, 4e8, 5e8, 6e8, 0.1, 0.2, 0.3, 1500 % carbon\n"
    section = read_becas(becas(tmp_path, MATPROPS=numbers))
    assert section.materials["material-1"]["E2"] == 2e9


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("1500.", "-1500.", r"line 19: material 2.rho = -1500 kg/m3: expected 0 or more"),
        ("70e9 0.3", "70e9 0.5", r"line 16: material 1.nu = 0.5"),
        ("0.1 0.2 0.3", "0.1 3.2 0.3", r"line 19: material 2"),
        ("1e9 2e9", "0. 2e9", r"line 19: material 2.E1 = 0 Pa: expected a value above 0"),
    ],
)
def test_impossible_materials_are_named_by_line(
    old: str, new: str, message: str, tmp_path: Path
) -> None:
    with pytest.raises(InputError, match=message):
        spec_of_another_code(vabs(tmp_path, SOUND.replace(old, new)), tmp_path)
    unused = SOUND.replace(old, new).replace("1 2 30.", "1 1 30.")
    if "material 2" in message:  # without cells
        assert spec_of_another_code(vabs(tmp_path, unused), tmp_path)["materials"].keys() == {
            "material-1"
        }


def test_impossible_materials_of_becas_are_named(tmp_path: Path) -> None:
    numbers = "1e9 2e9 3e9 4e8 5e8 6e8 0.1 0.2 0.3 -1\n"
    with pytest.raises(InputError, match=r"MATPROPS.in: material-1.rho = -1 kg/m3: expected 0 or"):
        spec_of_another_code(becas(tmp_path, MATPROPS=numbers), tmp_path)


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("E2D", "1 10 20 30 99 0 0 0 0\n", r"E2D.in: cell 1: node 99 does not exist"),
        ("E2D", "1 10 20\n", r"E2D.in: rows of 3 numbers, expected 5 or 9"),
        ("EMAT", "1 1 0 0\n", r"EMAT.in: no row for cell 2"),
        ("EMAT", "1 2 0 0\n2 1 0 0\n", r"EMAT.in: material 2: expected a row of MATPROPS.in"),
        ("N2D", "a b c\n", r"N2D.in: expected rows of numbers"),
        ("N2D", "10 0 0\n20 1 nan\n", r"N2D.in: row 2: expected finite numbers"),
        ("N2D", "10 0 0\n10.5 1 0\n", r"N2D.in: row 2: expected whole numbers"),
        ("N2D", "10 0 0\n10 1 0\n", r"N2D.in: number 10 occurs twice"),
        ("E2D", "1 10 20 30 40\n1 20 50 30 30\n", r"E2D.in: number 1 occurs twice"),
        ("EMAT", "1 1.5 0 0\n2 1 0 0\n", r"EMAT.in: row 1: expected whole numbers"),
    ],
)
def test_wrong_becas_input(name: str, text: str, message: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=message):
        read_becas(becas(tmp_path, **{name: text}))
