"""Sources that have modes without matrices: universal files and MED, out and in again."""

import shutil
from pathlib import Path

import h5py
import numpy as np
import pytest
from samples.brick_model import brick
from samples.exchange_samples import DENSITY, SIZE, request

from plymotion.preprocess.exchange import from_matrices
from plymotion.preprocess.exchange.formats.calculix import read_modes
from plymotion.preprocess.exchange.formats.med import read as read_med
from plymotion.preprocess.exchange.formats.modal import modal_package
from plymotion.preprocess.exchange.formats.uff import read
from plymotion.preprocess.exchange.import_file import imported
from plymotion.preprocess.exchange.import_table import Files
from plymotion.solver.__main__ import main
from plymotion.solver.errors import InputError
from plymotion.solver.package import ModalPackage, read_package, validate, write_package

TABLE = """\
format = 1
body = "arm"
from = "{source}"
units = {{ length = "m", mass = "kg", time = "s" }}
total_mass = 0.54
reference = {{ kind = "clamped", at = "root" }}
modes = [{{ kind = "lowest", count = 8 }}]

[files]
{source} = "arm.{source}"
masses = "arm_masses.csv"

[interfaces]
root = {{ nodes = [{root}], link = "average" }}
tip = {{ nodes = [{tip}], link = "average" }}
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The bar with its eight lowest modes, exported."""
    folder = tmp_path_factory.mktemp("modes")
    body = brick(SIZE, (80, 4, 2), density=DENSITY)
    cells = (body.cells + 1).tolist()
    wanted = request(modes=[{"kind": "lowest", "count": 8}])
    package = from_matrices(body.M, body.K, body.nodes, body.dofs, cells=cells, **wanted)
    write_package(folder / "arm.vtkhdf", package)
    for target in ("uff", "med"):
        out = folder / f"arm.{target}"
        assert main(["export", str(folder / "arm.vtkhdf"), "--to", target, "-o", str(out)]) == 0
    return folder


def again(folder: Path, source: str) -> ModalPackage:
    """The package that comes back."""
    n = int(read_package(folder / "arm.vtkhdf").node_ids[-1])
    file = folder / f"{source}.toml"
    file.write_text(TABLE.format(source=source, root=n - 1, tip=n))
    out = folder / f"{source}.vtkhdf"
    assert main(["import", str(file), "-o", str(out), "--quiet"]) == 0
    assert not [f for f in validate(out) if f.level == "error"]
    return read_package(out)


def deflection(package: ModalPackage) -> float:
    """Bending of the tip per unit force along z."""
    phi = package.interfaces[1].phi_B[2]
    return float(phi @ np.linalg.solve(package.stiffness, phi))


@pytest.mark.parametrize("source", ["uff", "med"])
def test_bending_comes_back(folder: Path, source: str) -> None:
    """Shapes become orthonormal in the lumped masses: 0.1 %."""
    before, after = read_package(folder / "arm.vtkhdf"), again(folder, source)
    digits = 1e-5 if source == "uff" else 1e-12
    np.testing.assert_allclose(after.frequencies, before.frequencies, rtol=digits)
    assert deflection(after) == pytest.approx(deflection(before), rel=1e-3)
    assert after.invariants.mass == pytest.approx(before.invariants.mass, rel=1e-12)


def test_pyuff_reads_the_universal_file(folder: Path) -> None:
    """Coordinates and shapes to the six digits of the format."""
    import sys

    from samples.exchange_routes import PROGRAMS

    if not (PROGRAMS / "python" / "pyuff").is_dir():
        pytest.skip("pyuff is not installed: make test-exchange downloads it")
    sys.path.insert(0, str(PROGRAMS / "python"))
    try:
        import pyuff
    finally:
        sys.path.pop(0)
    package = read_package(folder / "arm.vtkhdf")
    file = pyuff.UFF(str(folder / "arm.uff"))
    kinds = list(file.get_set_types())
    assert kinds == [164, 15, *[55] * package.n_mode]
    nodes = file.read_sets(1)
    found = np.column_stack([nodes["x"], nodes["y"], nodes["z"]])
    np.testing.assert_allclose(found, package.nodes_B, atol=1e-5 * SIZE[0])
    mode = file.read_sets(2)
    shape = np.column_stack([mode[f"r{k}"] for k in range(1, 7)]).real
    np.testing.assert_allclose(shape, package.shapes_B[0], atol=1e-5 * np.abs(shape).max())


def test_attachments_need_matrices(
    folder: Path, capfd: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    text = TABLE.format(source="uff", root=1, tip=2)
    attachment = '{ kind = "attachment", at = "tip", directions = ["x"] }'
    text = text.replace('{ kind = "lowest", count = 8 }', attachment)
    file = folder / "attachment.toml"
    file.write_text(text)
    out = tmp_path / "arm.vtkhdf"
    assert main(["import", str(file), "-o", str(out), "--quiet"]) == 2
    assert "modes only" in capfd.readouterr().err
    assert not out.exists()


def test_a_universal_file_that_is_cut_is_refused(folder: Path, tmp_path: Path) -> None:
    """Not read with fewer modes."""
    text = (folder / "arm.uff").read_text("ascii")
    (tmp_path / "arm.uff").write_text(text[: 2 * len(text) // 3], "ascii")
    (tmp_path / "arm_masses.csv").write_text((folder / "arm_masses.csv").read_text())
    table = {"uff": "arm.uff", "masses": "arm_masses.csv"}
    with pytest.raises(InputError, match=r"arm\.uff: truncated: the last dataset has no end"):
        read(Files(table, tmp_path, "arm.toml"))


PLACES = {10: (0.0, 0.0), 20: (2.0, 0.0), 35: (2.0, 1.0), 47: (0.0, 1.0)}
PLATE = {
    "body": "plate",
    "units": {"length": "m", "mass": "kg", "time": "s"},
    "reference": {"kind": "mean-axis"},
    "modes": [{"kind": "lowest", "count": 1}],
    "interfaces": {"tip": {"nodes": [20, 35], "link": "average"}},
}


def universal_file(
    folder: Path, system: int = 1, size: int = 3, left_out: int = 0, turned: int = 0
) -> Files:
    """A mode z = x y of four nodes as Fortran writes it: D, or no E at three digits."""
    lines = []
    if turned:  # axes of their own, as NX writes them, and global ones
        for number, rows in ((1, ("0 -1 0", "1 0 0", "0 0 1")), (2, ("1 0 0", "0 1 0", "0 0 1"))):
            lines += [f"{number:10d}{0:10d}{2:10d}", f"CS{number}"]
            lines += ["".join(f"{word + '.0D+00':>25}" for word in row.split()) for row in rows]
            lines.append("".join(f"{'0.0D+00':>25}" * 3))
        lines = ["    -1", "  2420", f"{1:10d}", "Part1", *lines, "    -1"]
    lines += ["    -1", "  2411"]
    for label, (x, y) in PLACES.items():
        lines.append(f"{label:10d}{system:10d}{system:10d}{11:10d}")
        lines.append("".join(f"{value:25.16E}" for value in (x, y, 0.0)).replace("E", "D"))
    lines += ["    -1", "    -1", "    55", *["NONE"] * 5, f"{1:10d}{2:10d}{2:10d}{8:10d}{2:10d}"]
    lines[-1] += f"{size:10d}"
    lines += [f"{2:10d}{4:10d}{0:10d}{1:10d}", "  4.00000E+01  1.00000E+00 -2.00000-103  0.0"]
    for label, (x, y) in PLACES.items():
        if label != left_out:
            lines += [f"{label:10d}", f"  1.00000-103 -2.00000-103{x * y - 0.5:13.5E}"]
    (folder / "plate.uff").write_text("\n".join([*lines, "    -1"]) + "\n")
    (folder / "masses.csv").write_text("".join(f"{label},1.5\n" for label in PLACES))
    return Files({"uff": "plate.uff", "masses": "masses.csv"}, folder, "plate.toml")


def test_a_universal_file_as_fortran_writes_it(tmp_path: Path) -> None:
    read(universal_file(tmp_path, turned=1, system=2))
    found = read(universal_file(tmp_path))
    np.testing.assert_array_equal(found.nodes[:, :2], list(PLACES.values()))
    np.testing.assert_array_equal(found.shapes[0, :, 2], [-0.5, -0.5, 1.5, -0.5])
    np.testing.assert_array_equal(found.shapes[0, :, :2], np.tile([1e-103, -2e-103], (4, 1)))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"system": 5}, r"plate.uff: node 10: expected global axes"),
        ({"turned": 1}, r"plate.uff: node 10: expected global axes"),
        ({"size": 1}, r"numbers 2, 1 at a node; expected .* 3 or 6 at a node"),
        ({"left_out": 35}, r"node 35 \(1 such nodes\) has no displacement in a mode"),
    ],
)
def test_a_universal_file_is_refused(change: dict[str, int], message: str, tmp_path: Path) -> None:
    files = universal_file(tmp_path, **change)
    with pytest.raises(InputError, match=message):
        modal_package(read(files), PLATE, files)


def test_held_nodes_need_no_displacements(tmp_path: Path) -> None:
    files = universal_file(tmp_path, left_out=10)
    held = {"root": {"nodes": [10], "link": "average"}}
    wanted = {
        "reference": {"kind": "clamped", "at": "root"},
        "interfaces": PLATE["interfaces"] | held,
    }
    package = modal_package(read(files), PLATE | wanted, files)
    assert package.shapes_B[0, 0].tolist() == [0.0] * 6


def test_masses_of_a_node_are_there_once(tmp_path: Path) -> None:
    files = universal_file(tmp_path)
    (tmp_path / "masses.csv").write_text("node,mass\n10,1.0\n10,2.0\n")
    with pytest.raises(InputError, match=r"masses.csv:3: node 10 has a line before this one"):
        modal_package(read(files), PLATE, files)


def test_components_of_a_med_field_have_names(folder: Path, tmp_path: Path) -> None:
    """They may be in any order; others, and values at a part of the nodes, are refused."""
    n = len(read_package(folder / "arm.vtkhdf").node_ids)
    shapes = {}
    for names in ("DX DY DZ DRX DRY DRZ", "DRX DRY DRZ DX DY DZ", "DX DY PRES DRX DRY DRZ"):
        shutil.copy(folder / "arm.med", tmp_path)
        with h5py.File(tmp_path / "arm.med", "r+") as file:
            padded = "".join(f"{name:<16}" for name in names.split())
            file["CHA/DEPL"].attrs["NOM"] = np.bytes_(padded)
        files = Files({"med": "arm.med", "masses": ""}, tmp_path, "arm.toml")
        if "PRES" not in names:
            shapes[names] = read_med(files).shapes
    one, other = shapes.values()
    np.testing.assert_array_equal(one, other[..., [3, 4, 5, 0, 1, 2]])
    with pytest.raises(InputError, match="has DX DY PRES DRX DRY DRZ; expected 3 or 6 components"):
        read_med(files)
    with h5py.File(tmp_path / "arm.med", "r+") as file:
        for step in file["CHA/DEPL"].values():
            step["NOE"].move("MED_NO_PROFILE_INTERNAL", "half")  # 3 numbers a node, if all had some
            half = step["NOE/half/CO"][: 3 * n]
            del step["NOE/half/CO"]
            step["NOE/half/CO"] = half
    with pytest.raises(InputError, match="expected a MED file with one mesh and modes"):
        read_med(files)


def test_the_lowest_modes_of_a_file_in_any_order(
    folder: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    """Three of eight that stand in the file from the highest to the lowest; none is refused."""
    mark = "    -1\n"
    parts = (folder / "arm.uff").read_text("ascii").split(mark)[1::2]
    modes = [part for part in parts if part.split()[0] == "55"]
    others = [part for part in parts if part.split()[0] != "55"]
    text = "".join(f"{mark}{part}{mark}" for part in [*others, *modes[::-1]])
    (tmp_path / "arm.uff").write_text(text, "ascii")
    (tmp_path / "arm_masses.csv").write_text((folder / "arm_masses.csv").read_text())
    before = read_package(folder / "arm.vtkhdf")
    file, out = tmp_path / "arm.toml", tmp_path / "arm.vtkhdf"
    n = int(before.node_ids[-1])
    words = TABLE.format(source="uff", root=n - 1, tip=n)
    file.write_text(words.replace("count = 8", "count = 3"))
    assert main(["import", str(file), "-o", str(out), "--quiet"]) == 0
    np.testing.assert_allclose(read_package(out).frequencies, before.frequencies[:3], rtol=1e-5)
    file.write_text(words.replace("count = 8", "count = 0"))
    assert main(["import", str(file), "-o", str(out), "--quiet"]) == 2
    assert f"{file}: modes: 0 of 8 modes requested" in capfd.readouterr().err


SHELL_DECK = """\
*NODE, NSET=ALL
10, 0., 0., 0.
20, 2., 0., 0.
35, 2., 1., 0.
47, 0., 1., 0.
*ELEMENT, TYPE=S4, ELSET=PLATE
7, 10, 20, 35, 47
*MATERIAL, NAME=M
*DENSITY
1000.
*SHELL SECTION, ELSET=PLATE, MATERIAL=M
0.5
"""


def test_modes_of_a_calculix_shell(tmp_path: Path) -> None:
    """By text in the form of CalculiX: two modes, labels with gaps, a node of the expansion."""
    lines = []
    for hertz, size in ((40.0, 1.0), (10.0, 2.0)):
        lines.append(
            f"  100CL  101{hertz:12.5E}           4                     2    1MODAL      1"
        )
        lines.append(" -4  DISP        4    1")
        for k, label in enumerate((10, 20, 35, 47, 900)):
            lines.append(f" -1{label:10d}{0.0:12.5E}{0.0:12.5E}{size * k:12.5E}")
        lines.append(" -3")
    (tmp_path / "plate.frd").write_text("\n".join(lines) + "\n")
    (tmp_path / "plate.inp").write_text(SHELL_DECK)
    found = read_modes(Files({"deck": "plate.inp"}, tmp_path, "plate.toml"))
    assert found.node_ids.tolist() == [10, 20, 35, 47]
    assert found.hertz.tolist() == [40.0, 10.0]
    np.testing.assert_allclose(found.shapes[1, :, 2], [0.0, 2.0, 4.0, 6.0])
    assert found.mass is not None
    np.testing.assert_allclose(found.mass, 4 * [2.0 * 0.5 * 1000.0 / 4.0])
    assert found.groups["ALL"].tolist() == [0, 1, 2, 3]
    reduction = {
        **{"body": "plate", "format": 1, "from": "calculix-modes"},
        "files": {"deck": "plate.inp"},
        "units": {"length": "m", "mass": "kg", "time": "s"},
        "reference": {"kind": "mean-axis"},
        "modes": [{"kind": "lowest", "count": 1}],
        "interfaces": {"tip": {"nodes": [20, 35], "link": "average"}},
    }
    package = imported(reduction, tmp_path, "plate.toml")
    np.testing.assert_allclose(package.frequencies, 2.0 * np.pi * np.array([10.0]))
    lines = [line for line in lines if line[:13] != f" -1{35:10d}"]  # *NODE FILE, NSET=...
    (tmp_path / "plate.frd").write_text("\n".join(lines) + "\n")
    with pytest.raises(InputError, match=r"node 35 \(1 such nodes\) has no displacement"):
        imported(reduction, tmp_path, "plate.toml")


def test_sets_of_sets_whose_names_differ_in_capitals(tmp_path: Path) -> None:
    """CalculiX takes capitals for small letters; a set of such a name lost its nodes.

    The line of a keyword goes on after a comma.
    """
    (tmp_path / "plate.frd").write_text(
        "  100CL  101 1.00000E+01           4                     2    1MODAL      1\n"
        " -4  DISP        4    1\n -3\n"
    )
    sets = "*NSET, NSET=Root\n10\n*NSET, NSET=both\nROOT, 47\n*ELSET, ELSET=Chosen\nplate\n"
    deck = SHELL_DECK.replace("*MATERIAL", f"{sets}*MATERIAL")
    deck = deck.replace("SECTION, ELSET=PLATE", "SECTION, ELSET=CHOSEN")
    deck = deck.replace("TYPE=S4, ELSET", "TYPE=S4,\nELSET").replace("10, 0.,", "10, 0.D0,")
    (tmp_path / "plate.inp").write_text(deck)
    found = read_modes(Files({"deck": "plate.inp"}, tmp_path, "plate.toml"))
    assert found.groups["both"].tolist() == [0, 3]
    assert found.mass is not None
    assert found.mass.sum() == pytest.approx(1000.0)
    for old, new, words in (
        ("NSET=ALL", "NSET=ALL, SYSTEM=C", r"\*NODE, SYSTEM=C: expected x, y, z"),
        ("ROOT, 47", "RIGHT, 47", r"NSET=both: RIGHT: expected a number, or the name of a set"),
        ("ELSET=CHOSEN", "ELSET=OTHER", "element 7: no .SHELL SECTION has it in its ELSET"),
        ("MATERIAL=M\n0.5\n", "MATERIAL=M, NODAL THICKNESS\n", "expected its thickness"),
    ):
        assert old in deck
        (tmp_path / "plate.inp").write_text(deck.replace(old, new))
        with pytest.raises(InputError, match=words):
            read_modes(Files({"deck": "plate.inp"}, tmp_path, "plate.toml"))
