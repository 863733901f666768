"""Bodies of MYSTRAN: its own run, OUTPUT4 matrices, bulk data."""

from pathlib import Path

import numpy as np
import pytest
import scipy.sparse as sp
from samples.exchange_decks import MASS, write_mystran, write_solid
from samples.exchange_routes import ccx, import_file, mystran, run_program

from plymotion.preprocess.exchange.formats.nastran import bulk_cards, read_bulk_data, read_op4
from plymotion.preprocess.exchange.import_file import imported as built
from plymotion.preprocess.exchange.import_file import read_table
from plymotion.solver.errors import InputError
from plymotion.solver.package import ModalPackage, validate, write_package

ENDS = {
    "root": "box = [[-1e-6, -1, -1], [1e-6, 1, 1]]",
    "tip": "box = [[0.499999, -1, -1], [0.500001, 1, 1]]",
}


def package_of(file: Path) -> ModalPackage:
    return built(read_table(file), file.parent, str(file))


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    program = mystran()
    folder = tmp_path_factory.mktemp("mystran")
    write_mystran(folder / "arm.dat", (40, 4))
    run_program(program, ["arm.dat"], folder, folder / "arm.OU1")
    return folder


def test_mystran_agrees_with_a_solid_of_calculix(folder: Path, tmp_path: Path) -> None:
    """Plates of one layer and solids of one element per ply: two codes, two theories."""
    file = import_file(folder, "nastran", {"bulk": "arm.dat", "matrices": "arm.OU1"}, MASS, **ENDS)
    shell = package_of(file)
    write_package(tmp_path / "arm.vtkhdf", shell)
    assert [f for f in validate(tmp_path / "arm.vtkhdf") if f.level != "note"] == []
    write_solid(tmp_path / "arm.inp", (20, 2))
    run_program(ccx(), ["arm"], tmp_path, tmp_path / "arm.sti")
    solid = package_of(import_file(tmp_path, "calculix", {"deck": "arm.inp"}, MASS))
    np.testing.assert_allclose(shell.frequencies[:6], solid.frequencies[:6], rtol=0.01)
    left_out = shell.provenance["source"]["degrees of freedom without stiffness and mass"]
    assert left_out == {"rz": 205}


def test_the_mass_that_mystran_loses_is_noticed(folder: Path, tmp_path: Path) -> None:
    """Without the masses that make up for it, one ply of one element is missing."""
    deck = tmp_path / "arm.dat"
    lines = (folder / "arm.dat").read_text().splitlines()
    deck.write_text("\n".join(line for line in lines if not line.startswith("CONM2")) + "\n")
    run_program(mystran(), ["arm.dat"], tmp_path, tmp_path / "arm.OU1")
    files = {"bulk": "arm.dat", "matrices": "arm.OU1"}
    file = import_file(tmp_path, "nastran", files, MASS, **ENDS)
    with pytest.raises(InputError, match=r"total_mass = 0.31 kg, but .* 0.30903125 kg"):
        package_of(file)


GRIDS = """\
BEGIN BULK
GRID*,9,,1.0,2.0
*,3.0
GRID*   7                               1.5             -2.5-3
*       3.25D+1
GRID,3,,0.5,1.+2,
GRID           5             1.0     2.0     3.0
CTRIA3,1,1,3,5,7
CHEXA,2,1,3,5,7,3,5,7,
,3,5
ENDDATA
"""


def test_bulk_data_in_its_three_formats(tmp_path: Path) -> None:
    deck = tmp_path / "a.bdf"
    deck.write_text(GRIDS)
    ids, nodes, cells = read_bulk_data(deck, list(bulk_cards(deck)))
    assert ids.tolist() == [3, 5, 7, 9]
    expected = [[0.5, 100.0, 0.0], [1.0, 2.0, 3.0], [1.5, -2.5e-3, 32.5], [1.0, 2.0, 3.0]]
    np.testing.assert_array_equal(nodes, expected)
    assert cells.types.tolist() == [5, 12]
    assert cells.connectivity.tolist() == [0, 1, 2, 0, 1, 2, 0, 1, 2, 0, 1]


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("GRID,9,2,0.,0.,0.", "GRID 9 has a coordinate system of its own"),
        ("GRDSET,,2", "GRDSET has a coordinate system of its own"),
        ("GRID,9,,0.,0.,0.,4", "GRID 9 has a coordinate system of its own"),
        ("INCLUDE 'b.bdf'", "INCLUDE 'b.bdf'.: expected whole cards"),
        ("=,*(1),=,*(1.),==", "without INCLUDE and replication"),
        ("PCOMP,1,,,,,,,,,1,0.1,45.", "at most ten fields a line"),
        ("SPOINT,12", "SPOINT: expected grid points only"),
        ("GRID,9,,a.,0.,0.", "GRID: expected a number, found 'a.'"),
        ("CQUAD4,9,1,3,5,7", "CQUAD4 9: expected 4 nodes"),
        ("CTRIA3,9,1,3,5,8", "no node has the label 8"),
    ],
)
def test_bulk_data_is_refused(tmp_path: Path, line: str, message: str) -> None:
    deck = tmp_path / "a.bdf"
    deck.write_text(GRIDS.replace("ENDDATA", f"{line}\nENDDATA"))
    with pytest.raises(InputError, match=message):
        read_bulk_data(deck, list(bulk_cards(deck)))


def op4_bytes(A: np.ndarray, name: str, sparse: bool, big: bool = False) -> bytes:
    """A binary OUTPUT4 file of one matrix, by its description; `big`: with BIGMAT = TRUE."""

    def record(*parts: bytes) -> bytes:
        body = b"".join(parts)
        size = np.int32(len(body)).tobytes()
        return size + body + size

    def words(*numbers: int) -> bytes:
        return np.array(numbers, dtype="<i4").tobytes()

    rows, columns = A.shape
    out = record(words(columns, -rows if big else rows, 2, 2), f"{name:8s}".encode())
    for j in range(columns):
        used = np.flatnonzero(A[:, j])
        if sparse:
            heads = [words(3, i + 1) if big else words(3 * 65536 + i + 1) for i in used]
            strings = [head + A[i, j].tobytes() for head, i in zip(heads, used, strict=True)]
            out += record(words(j + 1, 0, (4 if big else 3) * len(used)), *strings)
        else:
            out += record(words(j + 1, 1, 2 * rows), A[:, j].tobytes())
    return out + record(words(columns + 1, 1, 2), np.ones(1).tobytes())


@pytest.mark.parametrize(
    ("sparse", "big"), [(False, False), (True, False), (True, True)], ids=["dense", "sparse", "big"]
)
def test_op4_of_any_writer(tmp_path: Path, sparse: bool, big: bool) -> None:
    A = sp.random(12, 12, 0.3, random_state=3).toarray()
    B = sp.random(12, 12, 0.2, random_state=4).toarray()
    file = tmp_path / "a.op4"
    file.write_bytes(op4_bytes(A, "KGG", sparse, big) + op4_bytes(B, "MGG", sparse, big))
    found = read_op4(file)
    np.testing.assert_array_equal(found["KGG"].toarray(), A)
    np.testing.assert_array_equal(found["MGG"].toarray(), B)
    file.write_bytes(op4_bytes(A, "KGG", sparse, big)[:-60])
    with pytest.raises(InputError, match=r"damaged at byte|before its last column"):
        read_op4(file)


# of the columns and the rows in the first record
@pytest.mark.parametrize(("place", "count"), [(4, 2**31 - 1), (8, 2**31 - 1), (4, -(2**31) + 1)])
def test_op4_of_absurd_size_takes_no_memory(tmp_path: Path, place: int, count: int) -> None:
    file = tmp_path / "a.op4"
    data = bytearray(op4_bytes(np.eye(3), "KGG", sparse=True))
    data[place : place + 4] = np.array([count], "<i4").tobytes()
    file.write_bytes(data)
    with pytest.raises(InputError, match=r"a\.op4: matrix KGG: .*2147483647.* file of \d+ bytes"):
        read_op4(file)
