"""Solids of CalculiX: its own runs, matrices to packages."""

from pathlib import Path

import numpy as np
import pytest
from samples.exchange_decks import LENGTH, MASS, MM, SI, frequencies, write_shell, write_solid
from samples.exchange_routes import ccx, import_file, run_program

from plymotion.preprocess.exchange.formats.calculix import read
from plymotion.preprocess.exchange.import_file import imported as built
from plymotion.preprocess.exchange.import_file import read_table
from plymotion.preprocess.exchange.import_table import Files
from plymotion.solver.__main__ import main
from plymotion.solver.errors import InputError
from plymotion.solver.package import ModalPackage, read_package, validate, write_package

COUNT = (16, 2)


def package_of(file: Path) -> ModalPackage:
    return built(read_table(file), file.parent, str(file))


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The arm in m, kg, s and in mm, t, s; a deck of its free vibrations."""
    program = ccx()
    folder = tmp_path_factory.mktemp("calculix")
    write_solid(folder / "si.inp", COUNT, SI)
    write_solid(folder / "mm.inp", COUNT, MM)
    free = "*STEP\n*FREQUENCY\n14\n*END STEP"
    write_solid(folder / "free.inp", COUNT, SI, free)
    for name in ("si.sti", "mm.sti", "free.dat"):
        run_program(program, [name.split(".")[0]], folder, folder / name)
    import_file(folder, "calculix", {"deck": "si.inp"}, MASS, name="si.toml")
    mm = ("mm", "t")
    import_file(folder, "calculix", {"deck": "mm.inp"}, MASS, name="mm.toml", units=mm)
    return folder


def test_free_frequencies_are_those_of_calculix(folder: Path) -> None:
    """Its .dat has seven digits."""
    table = read_table(folder / "si.toml")
    table |= {"reference": {"kind": "mean-axis"}, "modes": [{"kind": "lowest", "count": 8}]}
    table["interfaces"] = {"tip": {"set": "NTIP", "link": "average"}}
    found = built(table, folder, "si.toml").frequencies
    np.testing.assert_allclose(found, frequencies(folder / "free.dat")[6:], rtol=1e-6)


def test_package_is_valid_and_consistent(folder: Path, tmp_path: Path) -> None:
    package = package_of(folder / "si.toml")
    write_package(tmp_path / "arm.vtkhdf", package)
    assert validate(tmp_path / "arm.vtkhdf") == []
    assert package.invariants.mass_form == "consistent"
    assert package.invariants.mass == pytest.approx(MASS, rel=1e-9)
    assert set(package.cell_types.tolist()) == {25}


def test_millimetres_and_tonnes_give_the_same_body(folder: Path) -> None:
    """Matrices to 1e-12. Of the slender arm the files' 14 digits leave 7 in bending.

    The difference of the frequencies is, to first order, that of the digits: x' dK x / (2 w^2).
    Reading, units and reduction add less than 1e-9.
    """
    si, mm = (read(Files({"deck": f"{name}.inp"}, folder, name)) for name in ("si", "mm"))
    mm = mm.in_units(1e-3, 1e3, 1.0)
    for a, b in ((si.K, mm.K), (si.M, mm.M)):
        assert np.abs((a - b).data).max() < 1e-12 * np.abs(a.data).max()
    assert np.abs(si.nodes - mm.nodes).max() < 1e-12 * LENGTH
    one, two = (package_of(folder / name) for name in ("si.toml", "mm.toml"))
    n = len(si.nodes)
    X = one.shapes_B[:, :n][:, si.dof_node, si.dof_direction].T
    w = one.frequencies
    of_digits = np.einsum("ni,ni->i", X, (mm.K - si.K) @ X) / (2.0 * w**2)
    vibrations = slice(0, 6)  # static shapes mix if frequencies change
    change = two.frequencies / w - 1.0
    assert np.abs(change - of_digits)[vibrations].max() < 1e-9
    assert np.abs(change).max() < 1e-6
    assert two.invariants.mass == pytest.approx(one.invariants.mass, rel=1e-12)
    np.testing.assert_allclose(two.invariants.T00_B, one.invariants.T00_B, rtol=0, atol=1e-12)


def test_of_a_compact_part_the_unit_changes_no_frequency(tmp_path: Path) -> None:
    """A block: its lowest eigenvalue is 1e-3 of the highest, and 14 digits leave 12."""
    found = []
    for name, unit, units in (("si", SI, ("m", "kg")), ("mm", MM, ("mm", "t"))):
        box = (0.1, 0.1, 0.1)
        write_solid(tmp_path / f"{name}.inp", (2, 2), unit, box=box)
        run_program(ccx(), [name], tmp_path, tmp_path / f"{name}.sti")
        file = import_file(
            tmp_path, "calculix", {"deck": f"{name}.inp"}, 1.55, name=f"{name}.toml", units=units
        )
        found.append(package_of(file).frequencies)
    np.testing.assert_allclose(found[1], found[0], rtol=1e-12)


def test_a_deck_of_shells_is_refused(folder: Path) -> None:
    text = (folder / "si.inp").read_text()
    head = text.split("*ELEMENT")[0]
    (folder / "shell.inp").write_text(head + "*ELEMENT, TYPE=S8R\n1, 1,2,3,4,5,6,7,8\n")
    file = import_file(folder, "calculix", {"deck": "shell.inp"}, MASS, name="shell.toml")
    with pytest.raises(InputError, match=r"element 1 of type S8: expected solids .*by their modes"):
        package_of(file)


def test_a_held_deck_is_refused(folder: Path, tmp_path: Path) -> None:
    """`*BOUNDARY` takes the held dofs out of the matrices, and their mass."""
    deck = write_solid(tmp_path / "held.inp", (4, 1), SI)
    deck.write_text(deck.read_text().replace("*STEP", "*BOUNDARY\nNROOT, 1, 1\n*STEP", 1))
    run_program(ccx(), ["held"], tmp_path, tmp_path / "held.sti")
    file = import_file(tmp_path, "calculix", {"deck": "held.inp"}, MASS)
    with pytest.raises(InputError, match=r"no degree of freedom along x .*of a held body"):
        package_of(file)


def test_files_of_two_analyses_are_refused(folder: Path, tmp_path: Path) -> None:
    for name in ("si.inp", "si.sti", "si.mas", "si.dof"):
        (tmp_path / name).write_bytes((folder / name).read_bytes())
    lines = (tmp_path / "si.dof").read_text().splitlines()
    (tmp_path / "si.dof").write_text("\n".join(lines[:-3]) + "\n")
    file = import_file(tmp_path, "calculix", {"deck": "si.inp"}, MASS)
    with pytest.raises(InputError, match="do the files belong to one analysis"):
        package_of(file)


SHELL = """\
format = 1
body = "arm"
from = "calculix-modes"
units = { length = "m", mass = "kg", time = "s" }
total_mass = 0.31
reference = { kind = "clamped", at = "root" }
modes = [{ kind = "lowest", count = 8 }]

[files]
deck = "shell.inp"

[interfaces]
root = { set = "NROOT", link = "average" }
tip = { set = "NTIP", link = "average" }
"""


def test_shells_by_their_modes(
    folder: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    """Frequencies of the .frd file; near those of the solid, whose tip face is rigid."""
    write_shell(tmp_path / "shell.inp", (20, 2), 8)
    run_program(ccx(), ["shell"], tmp_path, tmp_path / "shell.dat")
    (tmp_path / "shell.toml").write_text(SHELL)
    out = tmp_path / "shell.vtkhdf"
    assert main(["import", str(tmp_path / "shell.toml"), "-o", str(out), "--quiet"]) == 0
    told = capfd.readouterr()
    assert "interface-without-rotation" in told.err
    package = read_package(out)
    np.testing.assert_allclose(
        package.frequencies, frequencies(tmp_path / "shell.dat")[:8], rtol=1e-6
    )
    assert package.invariants.mass == pytest.approx(MASS, rel=1e-9)
    assert not [f for f in validate(out) if f.level == "error"]
    solid = package_of(folder / "si.toml")
    np.testing.assert_allclose(package.frequencies[:4], solid.frequencies[:4], rtol=0.02)
    assert "measured-shapes-coupled" not in told.err
