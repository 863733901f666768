"""Stations of a blade from a windIO file: contours, layers, meshes, messages."""

import csv
from collections import Counter

import numpy as np
import pytest
from blade_samples import anchor, blade_table, layer, write_blade

from plymotion.solver.__main__ import main
from plymotion.solver.commands.blade.contour import arcs, contour
from plymotion.solver.commands.blade.station import write_station
from plymotion.solver.commands.blade.windio import read_blade

PLACES = [0.0, 0.1, 0.2, 0.35, 0.5, 0.8, 1.0]


def area(points: np.ndarray) -> float:
    x, y = points, np.roll(points, -1, axis=0)
    return 0.5 * float((x[:, 0] * y[:, 1] - x[:, 1] * y[:, 0]).sum())


def areas(mesh) -> Counter:
    nodes, found = np.array(mesh.nodes), Counter()
    for cell, region in zip(mesh.cells, mesh.regions, strict=True):
        found[region] += area(nodes[list(cell)])
    return found


@pytest.fixture
def blade(tmp_path):
    return read_blade(write_blade(tmp_path))


@pytest.mark.parametrize("r", PLACES)
def test_cells_are_convex_and_conform(blade, tmp_path, r):
    mesh = write_station(blade, r, "one", tmp_path)
    nodes = np.array(mesh.nodes)
    edges = Counter()
    for cell in mesh.cells:
        x = nodes[list(cell)]
        before, after = x - np.roll(x, 1, axis=0), np.roll(x, -1, axis=0) - x
        assert (before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]).min() > 0.0
        ends = zip(cell, [*cell[1:], cell[0]], strict=True)
        edges.update(tuple(sorted(end)) for end in ends)
    assert max(edges.values()) == 2
    # Euler's number of a plane part with two holes, one on either side of the web.
    assert len(nodes) - len(edges) + len(mesh.cells) == 1 - 2


@pytest.mark.parametrize("r", [0.0, 0.35, 0.8])
def test_layers_have_the_area_of_the_file(blade, tmp_path, r):
    mesh = write_station(blade, r, "one", tmp_path)
    perimeter = float(arcs(contour(blade, r))[-1])
    found = areas(mesh)
    assert mesh.removed < 0.02
    assert found["skin"] == pytest.approx(0.004 * perimeter, rel=0.02)
    for cap in ("cap-s", "cap-p"):
        assert found[cap] == pytest.approx(0.02 * 0.08 * perimeter, rel=0.06)
    # The foam is thicker than the inner skin: that one lies deeper, and is shorter on a curve.
    assert found["core-s"] == pytest.approx(0.015 * 0.23 * perimeter, rel=0.06)


def test_a_round_contour_is_round(blade):
    points = contour(blade, 0.0)
    radius = np.linalg.norm(points - points.mean(axis=0), axis=1)
    np.testing.assert_allclose(radius, 1.0, atol=0.01)
    # x2 to the leading edge, x3 to the suction side: the first points are of the trailing edge.
    assert points[0, 0] == pytest.approx(-1.0)
    assert points[20, 1] > 0.0


def test_the_command_writes_stations(tmp_path, capsys):
    file = write_blade(tmp_path)
    assert main(["blade", str(file), "--at", "0,0.5", "-o", str(tmp_path / "out"), "--check"]) == 0
    names = sorted(path.name for path in (tmp_path / "out" / "stations").iterdir())
    assert names == ["r00000.msh", "r00000.toml", "r05000.msh", "r05000.toml"]
    description = str(tmp_path / "out/stations/r05000.toml")
    assert main(["section", description, "--check", "--out", str(tmp_path / "s")]) == 0


def wrong(change) -> dict:
    table = blade_table()
    change(table["components"]["blade"], table)
    return table


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda b, t: b.pop("outer_shape"), "components.blade.outer_shape: missing"),
        (lambda b, t: b["outer_shape"].pop("chord"), "outer_shape.chord: missing"),
        (lambda b, t: b["outer_shape"]["twist"].update(values=[1.0]), "grid has 2 numbers"),
        (lambda b, t: b["outer_shape"]["twist"].update(grid=[1.0, 0.0]), "a grid that rises"),
        (lambda b, t: t["airfoils"].pop(), "no airfoil 'thin'"),
        (lambda b, t: t["materials"].pop(1), "no material 'foam'"),
        (
            lambda b, t: b["structure"]["layers"][0]["start_nd_arc"]["anchor"].update(name="shel"),
            "no anchor 'shel'; did you mean 'shell'?",
        ),
    ],
)
def test_what_is_wrong_is_named(tmp_path, capsys, change, words):
    file = write_blade(tmp_path, wrong(change))
    assert main(["blade", str(file), "--at", "0.5", "-o", str(tmp_path / "out"), "--check"]) == 2
    message = capsys.readouterr().err
    assert words in message
    assert str(file) in message


def test_stiffness_and_mass_of_stations(fenicsx, tmp_path, capsys):
    """Axial stiffness and mass are sums over layers; a second call analyses nothing again."""
    file, out = write_blade(tmp_path), tmp_path / "out"
    words = ["blade", str(file), "--at", "0,0.5", "-o", str(out), "--quiet", "--no-estimate"]
    assert main(words) == 0
    with (out / "blade.csv").open(newline="") as stream:
        rows = list(csv.DictReader(stream))
    moduli = {"glass": 45e9, "foam": 130e6, "adhesive": 4e9}
    densities = {"glass": 1900.0, "foam": 100.0, "adhesive": 1100.0}
    for row, r in zip(rows, (0.0, 0.5), strict=True):
        mesh = write_station(read_blade(file), r, "again", tmp_path)
        found = areas(mesh)
        materials = {region: band.material for region, band in mesh.bands.items()}
        stiffness = sum(moduli[materials[region]] * a for region, a in found.items())
        mass = sum(densities[materials[region]] * a for region, a in found.items())
        assert float(row["K11"]) == pytest.approx(stiffness, rel=2e-3)
        assert float(row["mass_kg_m"]) == pytest.approx(mass, rel=1e-9)
        assert float(row["M11"]) == float(row["mass_kg_m"])
    capsys.readouterr()
    assert main(words) == 0
    assert "2 unchanged" in capsys.readouterr().out


def test_a_failed_station_has_no_numbers_of_an_earlier_call(fenicsx, tmp_path, capsys):
    out = tmp_path / "out"
    words = ["--at", "0,0.5", "-o", str(out), "--quiet", "--no-estimate"]
    assert main(["blade", str(write_blade(tmp_path)), *words]) == 0

    def change(blade, table):
        table["materials"][1]["E"] = -1.0
        blade["structure"]["layers"][3]["thickness"] = {"grid": [0.0, 0.1], "values": [0.0, 0.015]}
        blade["structure"]["layers"].pop(6)

    assert main(["blade", str(write_blade(tmp_path, wrong(change))), *words]) == 2
    with (out / "blade.csv").open(newline="") as stream:
        assert [row["r"] for row in csv.DictReader(stream)] == ["0.0"]
    assert "0.5000  failed" in capsys.readouterr().out


def test_webs_whose_feet_overlap_are_refused(tmp_path, capsys):
    def change(blade, table):
        structure = blade["structure"]
        close = anchor("close", 0.322, 0.66)
        structure["anchors"].append(close)
        ends = {key: close[key] for key in ("start_nd_arc", "end_nd_arc")}
        structure["webs"].append({"name": "second", "anchors": [], **ends})
        structure["layers"].append(layer("more", "foam", 0.05, at="close", web="second"))

    file = write_blade(tmp_path, wrong(change))
    assert main(["blade", str(file), "--at", "0.5", "-o", str(tmp_path / "out"), "--check"]) == 2
    message = capsys.readouterr().err
    assert f"{file}: station r = 0.5: structure.webs: second: its foot covers the arcs " in message
    assert "expected none of those of web" in message
