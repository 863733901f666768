"""Ply stresses of imported shells: laminates of a NASTRAN deck, resultants of its modes."""

from pathlib import Path

import numpy as np
import pytest
from samples.case_samples import computed_file
from samples.exchange_decks import (
    ANGLES,
    E1,
    E2,
    G12,
    G23,
    LENGTH,
    MASS,
    NU12,
    PLY,
    RHO,
    WIDTH,
    write_mystran,
)
from samples.exchange_routes import import_file, mystran, run_program

from plymotion.preprocess.exchange.formats.nastran import bulk_cards, read_bulk_data, read_layups
from plymotion.preprocess.exchange.free_body import Cells, Layups, centre_strains, recovered
from plymotion.preprocess.exchange.import_file import imported, read_table
from plymotion.solver.math.arrays import Array
from plymotion.solver.package import ModalPackage, validate, write_package
from plymotion.solver.package.body.package_schema import CellResultants

COUNT = (40, 4)
ENDS = {
    "root": "box = [[-1e-6, -1, -1], [1e-6, 1, 1]]",
    "tip": "box = [[0.499999, -1, -1], [0.500001, 1, 1]]",
}


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Import file of the arm of MYSTRAN."""
    program = mystran()
    folder = tmp_path_factory.mktemp("layups")
    write_mystran(folder / "arm.dat", COUNT)
    run_program(program, ["arm.dat"], folder, folder / "arm.OU1")
    return import_file(folder, "nastran", {"bulk": "arm.dat", "matrices": "arm.OU1"}, MASS, **ENDS)


@pytest.fixture(scope="module")
def package(file: Path) -> ModalPackage:
    return imported(read_table(file), file.parent, str(file))


def cells_of(package: ModalPackage) -> CellResultants:
    assert package.cell_resultants is not None
    return package.cell_resultants


def test_plies_are_those_of_the_deck(package: ModalPackage, tmp_path: Path) -> None:
    (laminate,) = package.laminates
    assert [ply.angle_deg for ply in laminate.plies] == list(ANGLES)
    assert [ply.bottom for ply in laminate.plies] == [-PLY, 0.0]
    (material,) = laminate.materials.values()
    expected = {"E1": E1, "E2": E2, "G12": G12, "G23": G23, "nu12": NU12, "rho": RHO}
    for key, value in expected.items():
        assert material[key] == pytest.approx(value, rel=1e-3)  # the deck has four digits
    write_package(tmp_path / "arm.vtkhdf", package)
    assert [found for found in validate(tmp_path / "arm.vtkhdf") if found.level != "note"] == []


def test_energy_of_the_resultants_is_that_of_the_modes(package: ModalPackage) -> None:
    """Means of cells leave out what varies inside: little of the lowest modes."""
    (laminate,), found = package.laminates, cells_of(package)
    S = np.zeros((8, 8))
    S[:6, :6], S[6:, 6:] = np.linalg.inv(laminate.ABD), np.linalg.inv(laminate.Ds)
    area = LENGTH * WIDTH / (COUNT[0] * COUNT[1])
    R = found.resultants_E
    energy = area * np.einsum("cim,ij,cjm->m", R, S, R)
    ratio = energy / np.diag(package.stiffness)
    out_of_plane = ratio[[0, 2]]
    assert (out_of_plane > 0.99).all()
    assert (out_of_plane < 1.001).all()
    # Bending in the plane: n cells over the width keep 1 - 1 / n^2 of a linear strain.
    assert ratio[1] == pytest.approx(1.0 - 1.0 / COUNT[1] ** 2, abs=0.015)


@pytest.mark.parametrize(("direction", "arm"), [(2, "bending"), (0, "tension")])
def test_resultants_balance_a_force_at_the_tip(
    package: ModalPackage, direction: int, arm: str
) -> None:
    """1 N at the tip in static equilibrium: moments and normal force over the width at each x."""
    found, tip = cells_of(package), package.interfaces[1]
    load = tip.phi_B[direction]
    q = np.linalg.solve(package.stiffness, load)
    R = found.resultants_E @ q  # (e, 8)
    corners = package.connectivity.reshape(-1, 4)[found.cell]
    x = package.nodes_B[corners, 0].mean(axis=1)
    across = WIDTH / COUNT[1]
    places = np.unique(np.round(x, 9))[4:-4]  # ends held rigid disturb the nearest cells
    total = np.array([R[np.isclose(x, place)].sum(axis=0) * across for place in places])
    if arm == "bending":
        # The upper side is pressed by a force upwards: M = int z s dz is minus F (L - x).
        np.testing.assert_allclose(total[:, 3], -(LENGTH - places), rtol=0.02)
        assert np.abs(total[:, 0]).max() < 0.5
    else:
        np.testing.assert_allclose(total[:, 0], 1.0, rtol=0.01)


CASE = """\
format = 1
title = "The arm under a force"
gravity = [0.0, 0.0, 0.0]
[bodies.arm]
kind = "package"
package = "arm.vtkhdf"
[ground.wall]
position = [0.0, 0.0, 0.0]
[joints.clamp]
kind = "fixed"
between = ["ground.wall", "arm.root"]
[forces.push]
kind = "force"
at = "arm.tip"
direction = [0.0, 0.0, 1.0]
law = { constant = 20.0 }
[signals.fibre]
kind = "exposure"
body = "arm"
criterion = "max-stress"
[solver]
start = "equilibrium"
t_end = 0.001
output_step = 0.001
[runs.base]
"""


def test_strength_of_an_imported_shell_in_a_mechanism(file: Path, tmp_path: Path) -> None:
    """Exposure by the greatest stress in static equilibrium, against a sum by hand."""
    for name in ("arm.OU1", "arm.toml"):
        (tmp_path / name).write_bytes((file.parent / name).read_bytes())
    text = (file.parent / "arm.dat").read_text()
    assert text.count("MAT8,1,") == 1
    line = next(row for row in text.splitlines() if row.startswith("MAT8,1,"))
    strong = f"{line},+M\n+M,,,,1500.E6,1200.E6,50.E6,250.E6,70.E6"
    (tmp_path / "arm.dat").write_text(text.replace(line, strong))
    arm = tmp_path / "arm.toml"
    package = imported(read_table(arm), tmp_path, str(arm))
    write_package(tmp_path / "arm.vtkhdf", package)
    result, _ = computed_file(tmp_path / "case.toml", CASE)
    q = np.linalg.solve(package.stiffness, 20.0 * package.interfaces[1].phi_B[2])
    R = cells_of(package).resultants_E @ q
    stress = np.einsum("plsr,cr->clps", package.laminates[0].stress_M, R)
    tension = np.array([1500e6, 50e6, 50e6, 94.25e6, 70e6, 70e6])
    pressure = np.array([1200e6, 250e6, 250e6, 94.25e6, 70e6, 70e6])
    exact = np.where(stress > 0.0, stress / tension, -stress / pressure).max()
    assert exact > 0.05
    assert result.signals[0].values[0] == pytest.approx(exact, rel=1e-3)


def quad() -> tuple[Array, Cells]:
    """A quadrilateral and a triangle in a plane in space."""
    flat = np.array(
        [[0, 0, 0], [2, 0.1, 0], [2.2, 1, 0], [-0.1, 0.9, 0], [3.0, 0.5, 0]], dtype=float
    )
    return flat, Cells.of([[0, 1, 2, 3], [1, 4, 2]], [9, 5])


def test_strains_of_linear_fields_are_exact() -> None:
    """Whatever the element and its axes: stretch, shear, curvatures, twist, transverse shear."""
    nodes, cells = quad()
    turn = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    angle = 0.4
    plane = np.array(
        [[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]]
    )
    A = turn @ plane  # axes of the laminate
    layups = Layups({}, {}, np.arange(2), np.zeros(2, dtype=int), np.array([A, A]))
    places = nodes @ turn.T
    local = places @ A
    exact = np.random.default_rng(2).normal(size=8)
    exx, eyy, gxy, kxx, kyy, kxy, gxz, gyz = exact
    x, y = local[:, 0], local[:, 1]
    beta = np.column_stack([kxx * x + kxy * y, kyy * y])
    u = np.column_stack([exx * x + gxy * y, eyy * y, np.zeros(5)])
    rotations = np.column_stack([-beta[:, 1], beta[:, 0], np.zeros(5)])
    shapes = np.concatenate([u @ A.T, rotations @ A.T], axis=1)[None]
    found = centre_strains(layups, places, cells, shapes)
    for row, own in enumerate(([0, 1, 2, 3], [1, 4, 2])):
        np.testing.assert_allclose(found[row, :6, 0], exact[:6], atol=1e-12)
        np.testing.assert_allclose(found[row, 6:, 0], beta[own].mean(axis=0), atol=1e-12)
    slope = np.array([gxz, gyz])
    w = (local[:, :2] @ slope)[:, None] * A[:, 2]
    only = np.concatenate([w, np.zeros((5, 3))], axis=1)[None]
    sheared = centre_strains(layups, places, cells, only)
    np.testing.assert_allclose(sheared[:, 6:, 0], [slope, slope], atol=1e-12)
    rigid = np.concatenate([np.cross([0.3, -0.2, 0.5], places), [[0.3, -0.2, 0.5]] * 5], axis=1)
    assert np.abs(centre_strains(layups, places, cells, rigid[None])).max() < 1e-14


DECK = """\
BEGIN BULK
GRID,1,,0.,0.,0.
GRID,2,,2.,0.,0.
GRID,3,,2.,1.,0.
GRID,4,,0.,1.,0.
CQUAD4,1,7,1,2,3,4,{theta}
PCOMP,7,{bottom},,,,,,{lam}
,1,0.1,0.,YES,,,90.
MAT8,1,140.+3,9.+3,0.3,5.+3,,4.+3,1.5-9
,,,,1500.,1200.,50.,250.,70.
ENDDATA
"""


def deck(folder: Path, text: str = DECK, **changes: str) -> Layups | str:
    fields = {"theta": "", "bottom": "", "lam": "", **changes}
    file = folder / "a.bdf"
    file.write_text(text.format(**fields))
    cards = list(bulk_cards(file))
    _, nodes, cells = read_bulk_data(file, cards)
    return read_layups(file, cards, nodes, cells)


def test_a_deck_in_millimetres(tmp_path: Path) -> None:
    """N, mm, t: moduli in MPa. Blank material and thickness are those of the ply before."""
    layups = deck(tmp_path, bottom="0.", lam="SYM")
    assert isinstance(layups, Layups)
    si = layups.in_units(1e-3, 1e3, 1.0)
    table = si.laminates["laminate 7"]
    assert [ply["angle_deg"] for ply in table["plies"]] == [0.0, 90.0, 90.0, 0.0]
    assert [ply["thickness"] for ply in table["plies"]] == pytest.approx([1e-4] * 4)
    assert table["offset"] == pytest.approx(2e-4)
    material = si.materials["MAT 1"]
    assert material["E1"] == pytest.approx(140e9)
    assert material["G13"] == pytest.approx(5e9)
    assert material["rho"] == pytest.approx(1500.0)
    assert material["strength"]["Xt"] == pytest.approx(1.5e9)
    nodes = 1e-3 * np.array([[0.0, 0, 0], [2, 0, 0], [2, 1, 0], [0, 1, 0]])
    cells = Cells.of([[0, 1, 2, 3]], [9])
    stretch = np.zeros((1, 4, 6))
    stretch[0, :, 0] = 1e-3 * nodes[:, 0]
    found = recovered(si, nodes, cells, stretch, "a.bdf")
    # Laminate above the nodes: a stretch of the reference surface bends.
    assert found.cells.resultants_E[0, 0, 0] == pytest.approx(found.laminates[0].ABD[0, 0] * 1e-3)
    assert found.cells.resultants_E[0, 3, 0] == pytest.approx(
        2e-4 * found.laminates[0].ABD[0, 0] * 1e-3
    )


@pytest.mark.parametrize(
    ("theta", "e1"), [("", [1.0, 0.0, 0.0]), ("30.", [0.75**0.5, 0.5, 0.0]), ("0", [1.0, 0.0, 0.0])]
)
def test_angles_count_from_the_first_side(tmp_path: Path, theta: str, e1: list[float]) -> None:
    layups = deck(tmp_path, theta=theta)
    assert isinstance(layups, Layups)
    np.testing.assert_allclose(layups.A_BE[0, :, 0], e1, atol=1e-12)
    np.testing.assert_allclose(layups.A_BE[0, :, 2], [0, 0, 1], atol=1e-12)


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"theta": "5"}, "CQUAD4 1: MCID = 5: a coordinate system of its own"),
        ({"theta": ",0.2"}, "CQUAD4 1: ZOFFS"),
        ({"theta": ",\n,,,0.1,0.1,0.2,0.2"}, "CQUAD4 1: thicknesses of its own"),
        ({"lam": "MEM"}, "PCOMP 7: LAM = MEM"),
    ],
)
def test_what_is_not_understood_gives_no_plies(
    tmp_path: Path, change: dict[str, str], reason: str
) -> None:
    """The import goes on without ply stresses, and the provenance says why."""
    assert deck(tmp_path, **change) == reason


def test_other_properties(tmp_path: Path) -> None:
    plate = DECK.replace("PCOMP,7,{bottom},,,,,,{lam}\n,1,0.1,0.,YES,,,90.", "PSHELL,7,1,0.4,1")
    layups = deck(tmp_path, plate)
    assert isinstance(layups, Layups)
    (ply,) = layups.laminates["laminate 7"]["plies"]
    assert ply == {"material": "MAT 1", "angle_deg": 0.0, "thickness": 0.4}
    membrane = plate.replace("PSHELL,7,1,0.4,1", "PSHELL,7,1,0.4")
    assert "PSHELL 7: expected MID2 = MID1" in str(deck(tmp_path, membrane))
    metal = plate.replace("MAT8,1,140.+3,9.+3,0.3,5.+3,,4.+3,1.5-9", "MAT1,1,70.+3,,0.3,2.7-9")
    metal = metal.replace(",,,,1500.,1200.,50.,250.,70.\n", "")
    found = deck(tmp_path, metal)
    assert isinstance(found, Layups)
    assert found.materials["MAT 1"] == {"kind": "isotropic", "E": 70e3, "nu": 0.3, "rho": 2.7e-9}
    by_G = deck(tmp_path, metal.replace("70.+3,,0.3", ",28.+3,0.25"))
    assert isinstance(by_G, Layups)
    assert by_G.materials["MAT 1"]["E"] == pytest.approx(70e3)
