"""Stations of a blade from a windIO file: contours, layers, meshes, messages."""

import contextlib
import io
import shutil
from collections import Counter

import numpy as np
import pytest
from samples.blade_samples import (
    along,
    anchor,
    area,
    areas,
    blade_table,
    layer,
    rows_of,
    write_blade,
)

import plymotion as pm
from plymotion.solver.__main__ import main
from plymotion.solver.errors import InputError
from plymotion.solver.extras.blade.shape import contour
from plymotion.solver.extras.blade.station import write_station
from plymotion.solver.extras.blade.windio import read_blade
from plymotion.solver.inputs.case.tables.beam_keys import BeamBody
from plymotion.solver.inputs.case.tables.laws import FOLDER
from plymotion.solver.math.laws import lengths_along

pytestmark = pytest.mark.usefixtures("one_fenicsx")
WORDS = ["--at", "0,0.4,1", "--quiet", "--no-estimate"]  # of the stations that are analysed
PLACES = [0.0, 0.1, 0.2, 0.35, 0.5, 0.8, 1.0]


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
    perimeter = float(lengths_along(contour(blade, r))[-1])
    found = areas(mesh)
    assert mesh.removed < 0.02
    assert found["skin"] == pytest.approx(0.004 * perimeter, rel=0.02)
    for cap in ("cap-s", "cap-p"):
        assert found[cap] == pytest.approx(0.02 * 0.08 * perimeter, rel=0.06)
    # The foam is thicker than the inner skin: that one lies deeper, and is shorter on a curve.
    assert found["core-s"] == pytest.approx(0.015 * 0.23 * perimeter, rel=0.06)


@pytest.mark.parametrize("r", [0.37, 0.4, 0.45])
def test_walls_go_around_an_edge_that_is_round(blade, tmp_path, r):
    """Both walls of 6 mm fit into it: nothing is cut, also where its radius is a few walls."""
    mesh = write_station(blade, r, "one", tmp_path)
    perimeter = float(lengths_along(contour(blade, r))[-1])
    assert "trailing-edge" not in areas(mesh)
    assert areas(mesh)["skin"] == pytest.approx(0.004 * (perimeter - np.pi * 0.004), rel=3e-3)


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
    names = sorted(path.name for path in (tmp_path / "out" / "stations").glob("r*"))
    assert names == ["r00000.msh", "r00000.toml", "r05000.msh", "r05000.toml"]
    description = str(tmp_path / "out/stations/r05000.toml")
    assert main(["section", description, "--check", "--out", str(tmp_path / "s")]) == 0


def wrong(change) -> dict:
    table = blade_table()
    change(table["components"]["blade"], table)
    return table


def web_at(blade: dict, end: float, start: float = 0.32) -> None:
    """Move the ends of the web."""
    blade["structure"]["anchors"][-1] = anchor("web", start, end)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda b, t: b.pop("outer_shape"), "components.blade.outer_shape: missing"),
        (lambda b, t: b["outer_shape"].pop("chord"), "outer_shape.chord: missing"),
        (lambda b, t: b["outer_shape"]["twist"].update(values=[1.0]), "grid has 2 numbers"),
        (lambda b, t: b["outer_shape"]["twist"].update(grid=[1.0, 0.0]), "a grid that rises"),
        (lambda b, t: t["airfoils"].pop(), "no airfoil 'thin'"),
        (lambda b, t: t["materials"].pop(1), "no material 'foam'"),
        (lambda b, t: b["outer_shape"]["chord"].update(values=[2.0, 2.0, 0.0]), "lengths above 0"),
        (lambda b, t: b["outer_shape"].update(twist=[1.0]), "twist: has a list of 1; expected a"),
        (lambda b, t: b.update(outer_shape_bem={}), "pip install windIO scipy, then windio_conv"),
        (lambda b, t: b["structure"].pop("layers"), "structure.layers: missing; expected a list"),
        (lambda b, t: b["structure"]["layers"][2].pop("name"), "layers[2].name: missing"),
        (lambda b, t: b["structure"]["layers"][4].update(name="cap-s"), "'cap-s' is the name of"),
        (lambda b, t: b["structure"]["layers"][1].update(name="trailing-edge"), "also a region of"),
        (lambda b, t: b["structure"]["layers"][6].update(web="wep"), "no web 'wep'; did you mean"),
        (lambda b, t: b["structure"]["webs"][0].update(anchors=3), "webs[0].anchors: has 3"),
        (
            lambda b, t: b["structure"]["anchors"][1].update(end_nd_arc={"width": 1.0}),
            "anchors.cap-s.end_nd_arc: expected numbers in grid and values, or a rule",
        ),
        (lambda b, t: t["airfoils"].append({"name": "thin"}), "airfoils[2].name: 'thin' is the na"),
        (lambda b, t: t["materials"].append({"name": "foam"}), "name: 'foam' is the name of ano"),
        (
            lambda b, t: web_at(b, 0.2),
            "webs: web: from the arc 0.20000 to 0.32000; expected one on",
        ),
        (lambda b, t: t["airfoils"][1].pop("rthick"), "airfoils.thin.rthick: missing"),
        (lambda b, t: t["airfoils"][1].update(rthick=240.0), "240, but its coordinates are 0.23"),
        (
            lambda b, t: t["airfoils"][1]["coordinates"]["x"].__setitem__(20, 0.0),
            "airfoils.thin.coordinates: the outline turns back at point ",
        ),
        (
            lambda b, t: b["structure"]["layers"][0]["thickness"]["values"].__setitem__(0, False),
            "structure.layers[0].thickness.values: has ",
        ),
        (
            lambda b, t: t["airfoils"][1]["coordinates"].update(x=[0.1] * 119),
            "expected points over the chord, from the trailing edge",
        ),
        (lambda b, t: t["airfoils"][1].update(coordinates={"x": [1.0], "y": [0.0, 1.0]}), "ten or"),
        (
            lambda b, t: t["materials"][0].update(E=45e9),
            "materials.glass.E: has 45000000000.0; exp",
        ),
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


@pytest.mark.parametrize(
    ("start", "end", "words"),
    [
        (0.322, 0.66, ("structure.webs: second: its foot covers the arcs ", "of those of web")),
        (0.28, 0.6, ("structure.webs: web and second cross; expected webs side by side",)),
    ],
)
def test_webs_that_cross_or_whose_feet_overlap_are_refused(tmp_path, capsys, start, end, words):
    def change(blade, table):
        structure = blade["structure"]
        close = anchor("close", start, end)
        structure["anchors"].append(close)
        ends = {key: close[key] for key in ("start_nd_arc", "end_nd_arc")}
        structure["webs"].append({"name": "second", "anchors": [], **ends})
        structure["layers"].append(layer("more", "foam", 0.05, at="close", web="second"))

    file = write_blade(tmp_path, wrong(change))
    assert main(["blade", str(file), "--at", "0.5", "-o", str(tmp_path / "out"), "--check"]) == 2
    message = capsys.readouterr().err
    assert f"{file}: station r = 0.5: {words[0]}" in message
    assert words[-1] in message


def test_a_web_in_the_nose_is_as_thick_as_there_is_room(tmp_path):
    # At the tip the feet would overlap if its layers had their thickness across it.
    def change(blade, table):
        blade["structure"]["anchors"][-1] = anchor("web", 0.49, 0.51)

    blade = read_blade(write_blade(tmp_path, wrong(change)))
    found = [areas(write_station(blade, r, "one", tmp_path))["web-core"] for r in (0.9, 1.0)]
    assert 0.0 < found[1] < found[0]


def test_a_web_without_room_at_the_trailing_edge_is_told_by_its_key(tmp_path):
    table = blade_table()
    web_at(table["components"]["blade"], 0.99, 0.01)
    blade = read_blade(write_blade(tmp_path, table))
    assert write_station(blade, 0.6, "one", tmp_path).cells
    with pytest.raises(InputError, match=r"r = 0\.9: structure\.webs: web: from the arc 0\.01000"):
        write_station(blade, 0.9, "two", tmp_path)
    assert not (tmp_path / "two.msh").exists()


def test_layers_and_webs_are_there_within_their_grids_only(tmp_path):
    def change(blade, table):
        layers = blade["structure"]["layers"]
        for number in (1, 5):  # a cap, a skin of the web
            layers[number]["thickness"] = {"grid": [0.2, 0.6], "values": [0.01, 0.01]}

    blade = read_blade(write_blade(tmp_path, wrong(change)))
    for r, there in ((0.1, False), (0.2, True), (0.6, True), (0.7, False)):
        found = write_station(blade, r, "one", tmp_path).bands
        assert ("cap-s" in found) == ("web-skin" in found) == there
        assert "cap-p" in found


@pytest.mark.parametrize("height", [0.1, 0.3])
def test_the_face_of_a_flatback_is_a_wall(tmp_path, height):
    """An open contour: its layers go around the corners, to the middle of the face."""

    def change(blade, table):
        xy = table["airfoils"][1]["coordinates"]
        x, y = np.array(xy["x"]), np.array(xy["y"])
        half = 0.5 * height * x * np.where(np.arange(len(x)) < len(x) // 2, 1.0, -1.0)
        xy["y"] = (y + half).tolist()
        blade["structure"]["anchors"].append(anchor("edge-s", 0.0, 0.04))
        blade["structure"]["layers"].insert(1, layer("edge-s", "glass", 0.005))

    blade = read_blade(write_blade(tmp_path, wrong(change)))
    points = contour(blade, 0.8)
    gap = float(np.linalg.norm(points[0] - points[-1]))
    assert gap == pytest.approx(height * blade.chord.at(0.8), rel=1e-6)
    mesh = write_station(blade, 0.8, "one", tmp_path)
    assert "trailing-edge" not in mesh.bands
    perimeter = float(lengths_along(points)[-1]) + gap
    found = areas(mesh)
    assert found["skin"] == pytest.approx(0.004 * perimeter, rel=0.02)
    assert found["edge-s"] == pytest.approx(0.005 * 0.04 * perimeter, rel=0.1)
    nodes = np.array(mesh.nodes)
    behind = {
        (region, nodes[list(cell), 1].mean() > 0.5 * (points[0, 1] + points[-1, 1]))
        for cell, region in zip(mesh.cells, mesh.regions, strict=True)
        if nodes[list(cell), 0].mean() < points[0, 0] + 0.008
    }
    assert behind >= {("skin", True), ("skin", False), ("edge-s", True)}
    assert ("edge-s", False) not in behind
    outline = nodes[[a for a, _ in mesh.outer]]
    assert abs(area(outline)) == pytest.approx(abs(area(points)), rel=5e-3)


@pytest.fixture(scope="module")
def built(fenicsx, tmp_path_factory):
    """A blade of three stations with all files."""
    folder = tmp_path_factory.mktemp("blade")
    table = blade_table()
    axis = table["components"]["blade"]["reference_axis"]
    axis |= {"x": along(0.0, -0.2, -0.8), "y": along(0.0, 0.0, 0.3)}
    file, out = write_blade(folder, table), folder / "out"
    for code in ("beamdyn", "hawc2"):
        told = io.StringIO()
        with contextlib.redirect_stdout(told):
            assert main(["blade", str(file), *WORDS, "-o", str(out), "--to", code]) == 0
    assert "3 unchanged" in told.getvalue()  # a second call analyses nothing again
    return read_blade(file), out


def matrix(row, letter):
    found = np.zeros((6, 6))
    for i in range(6):
        for j in range(i, 6):
            found[i, j] = found[j, i] = float(row[f"{letter}{i + 1}{j + 1}"])
    return found


def test_stiffness_and_mass_of_stations(built, tmp_path):
    """Axial stiffness and mass are sums over layers."""
    blade, out = built
    moduli = {"glass": 45e9, "foam": 130e6, "adhesive": 4e9}
    densities = {"glass": 1900.0, "foam": 100.0, "adhesive": 1100.0}
    for row, r in zip(rows_of(out / "blade.csv"), (0.0, 0.4, 1.0), strict=True):
        mesh = write_station(blade, r, "again", tmp_path)
        found = areas(mesh)
        materials = {region: band.material for region, band in mesh.bands.items()}
        stiffness = sum(moduli[materials[region]] * a for region, a in found.items())
        mass = sum(densities[materials[region]] * a for region, a in found.items())
        assert float(row["K11"]) == pytest.approx(stiffness, rel=2e-3)
        assert float(row["mass_kg_m"]) == pytest.approx(mass, rel=1e-9)
        assert float(row["M11"]) == float(row["mass_kg_m"])


def test_python_has_what_the_command_writes(built):
    """`plymotion.blade` in the folder of the command: nothing is analysed again."""
    known, out = built
    before = {file: file.stat().st_mtime_ns for file in out.glob("sections/*/*.vtkhdf")}
    text = (out / "beam.csv").read_text()
    blade = pm.blade(known.file, at=[0.0, 0.4, 1.0], out=out, estimate=False)
    assert {file: file.stat().st_mtime_ns for file in before} == before
    assert (out / "beam.csv").read_text() == text
    rows = rows_of(out / "blade.csv")
    np.testing.assert_array_equal(blade.r, [float(row["r"]) for row in rows])
    np.testing.assert_array_equal(blade.K[:, 3, 3], [float(row["K44"]) for row in rows])
    np.testing.assert_array_equal(blade.M[:, 0, 0], blade.to_pandas()["mass_kg_m"])
    assert blade.sections[1].K[0, 0] == blade.K[1, 0, 0]
    assert list(pm.load(blade.case).runs) == ["spin-up"]
    assert "3 stations" in repr(blade)
    with pytest.raises(pm.InputError, match="expected beamdyn or hawc2"):
        pm.blade(known.file, to="fast")


def test_a_failed_station_has_no_numbers_of_an_earlier_call(built, tmp_path, capsys):
    out = tmp_path / "out"
    shutil.copytree(built[1], out)

    def change(blade, table):
        table["materials"][1]["E"] = -1.0
        blade["structure"]["layers"][3]["thickness"] = along(0.0, 0.015)
        blade["structure"]["layers"].pop(6)

    file = write_blade(tmp_path, wrong(change))
    assert main(["blade", str(file), *WORDS, "-o", str(out)]) == 2
    assert [row["r"] for row in rows_of(out / "blade.csv")] == ["0.0"]
    assert "0.4000  failed" in capsys.readouterr().out


def test_a_blade_becomes_a_table_of_a_beam(built):
    """The axes of windIO: x to the suction side, y to the trailing edge, z to the tip."""
    _, out = built
    beam, table = rows_of(out / "beam.csv"), rows_of(out / "blade.csv")
    assert [float(beam[-1][k]) for k in ("x_m", "y_m", "z_m")] == [20.0, -0.3, -0.8]
    # positive in the file: the leading edge (y) is turned to the pressure side (-z)
    assert float(beam[0]["twist_deg"]) == -10.0
    for one, two in zip(beam, table, strict=True):
        np.testing.assert_array_equal(matrix(one, "K"), matrix(two, "K"))
        np.testing.assert_array_equal(matrix(one, "M"), matrix(two, "M"))
        # a_1 of a thin closed section is about its polar radius of gyration squared
        M = matrix(one, "M")
        assert 0.3 < float(one["A1"]) / (M[3, 3] / M[0, 0]) < 1.5
    body = {
        "kind": "beam",
        "table": "beam.csv",
        "modes": [{"kind": "lowest", "count": 3}],
        "interfaces": {"root": {"at": "start"}},
    }
    read = BeamBody.model_validate(body, context={FOLDER: out})
    assert [s.stiffness for s in read.stations] == [matrix(row, "K").tolist() for row in beam]


def test_files_for_beamdyn_have_the_matrices_in_its_axes(built):
    _, out = built
    lines = (out / "blade_beamdyn.dat").read_text().splitlines()
    numbers = [list(map(float, line.split())) for line in lines[13:] if line.strip()]
    assert int(lines[10].split()[0]) == 0  # modes of damping: a line of OpenFAST 5
    station = [row for row in numbers if len(row) == 1]
    assert np.ravel(station)[[0, -1]].tolist() == [0.0, 1.0]
    K = np.array([row for row in numbers if len(row) == 6][:6])  # the first station
    ours = matrix(rows_of(out / "beam.csv")[0], "K")
    # x, y, z of BeamDyn are x3, -x2, x1: shear x, shear y, axial, about x (edge), about y (flap)
    diagonal = np.diag(ours)[[2, 1, 0, 5, 4, 3]]
    np.testing.assert_allclose(np.diag(K), diagonal, rtol=1e-12)
    assert K[2, 3] == pytest.approx(ours[0, 5], rel=1e-12, abs=1e-9 * diagonal.max())
    assert K[2, 4] == pytest.approx(-ours[0, 4], rel=1e-12, abs=1e-9 * diagonal.max())
    keys = (out / "blade_beamdyn_geometry.dat").read_text().splitlines()[5:]
    assert [float(x) for x in keys[-1].split()] == pytest.approx([-0.8, 0.3, 20.0, 0.0])
    assert float(keys[0].split()[3]) == 10.0


def test_files_for_hawc2_are_about_the_half_chord_line(built):
    blade, out = built
    lines = (out / "blade_hawc2_st.dat").read_text().splitlines()[4:]
    sections = (out / "blade_hawc2_c2_def.htc").read_text().splitlines()[2:-1]
    for line, sec, row in zip(lines, sections, rows_of(out / "blade.csv"), strict=True):
        st, c2 = np.array(line.split(), float), np.array(sec.split()[2:6], float)
        r = float(row["r"])
        arm = blade.offset.at(r) - 0.5 * blade.chord.at(r)  # of the half chord, to the nose
        M, K = matrix(row, "M"), matrix(row, "K")
        assert st[1] == pytest.approx(float(row["mass_kg_m"]))
        assert st[2] == pytest.approx(-M[0, 5] / M[0, 0] - arm, abs=1e-9)
        assert st[20] == pytest.approx(K[0, 0], rel=0.05)  # axial: K_33 in its order
        assert c2[3] == pytest.approx(-blade.twist.at(r))
        assert c2[2] == pytest.approx(20.0 * r)
    angle = np.radians(blade.twist.at(0.0))
    first = np.array(sections[0].split()[2:4], float)
    arm = blade.offset.at(0.0) - 0.5 * blade.chord.at(0.0)
    np.testing.assert_allclose(first, arm * np.array([np.cos(angle), -np.sin(angle)]), atol=1e-9)


@pytest.mark.provokes("not-modelled")
def test_what_is_not_modelled_is_named(tmp_path, capsys):
    def change(blade, table):
        structure = blade["structure"]
        structure["webs"][0]["flanges"] = [{"type": "T", "side": "both"}]
        structure["trailing_edge_adhesive"] = {"material": "glass"}
        structure["joint"] = {"position": 0.3, "mass": 120.0}
        blade["outer_shape"]["section_offset_x"] = along(0.0, 0.1)
        structure["layers"][2]["fibre_orientation"] = along(20.0, 20.0)

    file = write_blade(tmp_path, wrong(change))
    assert main(["blade", str(file), "--at", "0.8", "-o", str(tmp_path / "out"), "--check"]) == 0
    told = capsys.readouterr().err.splitlines()
    keys = ("structure.webs: web: flanges", "structure.trailing_edge_adhesive", "structure.joint")
    keys += ("structure.layers[2]: unknown key 'fibre_orientation'; did you mean 'fiber_orient",)
    for line, key in zip(told, keys, strict=True):
        code = "not-modelled"
        assert line.startswith(f"warning [{code}] {file}: {key}")
    blade = read_blade(file)
    assert write_station(blade, 0.8, "one", tmp_path).bands["trailing-edge"].material == "glass"
    # the chord line lies over the reference axis
    shifted = contour(blade, 1.0) - contour(read_blade(write_blade(tmp_path)), 1.0)
    np.testing.assert_allclose(shifted, np.tile([0.0, 0.1], (len(shifted), 1)), atol=1e-12)


def with_layers(tmp_path, *changes):
    """The blade whose layers have other keys: pairs of a number and keys."""

    def change(blade, table):
        for number, keys in changes:
            blade["structure"]["layers"][number] |= keys

    return read_blade(write_blade(tmp_path, wrong(change)))


@pytest.mark.parametrize("cap", [0.02, 0.06])
def test_layers_of_webs_have_their_thickness_under_thick_caps(tmp_path, cap):
    """Their feet are on the inner face of a curved wall, and on walls that stand obliquely."""
    blade = with_layers(
        tmp_path, (1, {"thickness": along(cap, cap)}), (2, {"thickness": along(cap, cap)})
    )
    for r in (0.3, 0.8):
        mesh = write_station(blade, r, "one", tmp_path)
        nodes, found = np.array(mesh.nodes), areas(mesh)
        run = np.array(mesh.directions["web-skin"])
        along_web = run / np.linalg.norm(run)
        cells = [c for c, n in zip(mesh.cells, mesh.regions, strict=True) if n == "web-core"]
        places = nodes[sorted({k for cell in cells for k in cell})] @ along_web
        for name, thickness in (("web-skin", 0.003), ("web-core", 0.012)):
            height = found[name] / thickness
            assert height == pytest.approx(np.ptp(places), rel=0.02), (r, name)


@pytest.mark.parametrize("r", [0.28, 0.38, 0.4])
def test_feet_of_webs_do_not_thin_the_wall(tmp_path, r):
    """Columns a millimetre apart are no sign of a narrow place: no layer is made thinner."""
    thick = {"thickness": along(0.12, 0.12)}
    skin = {"thickness": along(0.0004, 0.0004)}
    mesh = write_station(with_layers(tmp_path, (1, thick), (2, thick), (5, skin)), r, "x", tmp_path)
    assert mesh.removed < 1e-3


def test_thin_and_thick_layers_side_by_side_keep_their_areas(tmp_path):
    """The core, 40 mm, ends at the cap, 5 mm: the slope between them is a part of the core."""
    thin = {"thickness": along(0.005, 0.005)}
    blade = with_layers(tmp_path, (1, thin), (2, thin), (3, {"thickness": along(0.04, 0.04)}))
    mesh = write_station(blade, 0.3, "one", tmp_path)
    perimeter = float(lengths_along(contour(blade, 0.3))[-1])
    found = areas(mesh)
    assert found["cap-p"] == pytest.approx(0.005 * 0.08 * perimeter, rel=0.02)
    assert found["cap-s"] == pytest.approx(0.005 * 0.08 * perimeter, rel=0.05)
    assert found["core-s"] == pytest.approx(0.04 * 0.23 * perimeter, rel=0.03)


def test_a_layer_that_ends_thinner_beside_another_loses_nothing(tmp_path):
    """One of 60 mm beside one of 15 mm: the full thickness up to the end of the file."""
    thick = {"thickness": along(0.06, 0.06)}
    blade = with_layers(tmp_path, (1, thick), (2, thick))
    mesh = write_station(blade, 0.3, "one", tmp_path)
    points = contour(blade, 0.3)
    perimeter = float(lengths_along(points)[-1])
    alone, beside = (areas(mesh)[name] for name in ("cap-p", "cap-s"))
    assert beside == pytest.approx(alone, rel=5e-3)
    assert beside == pytest.approx(0.06 * 0.08 * perimeter, rel=0.06)  # shorter inside a curve


def test_fibres_turn_to_the_leading_edge_on_both_sides(tmp_path):
    blade = with_layers(tmp_path, (0, {"fiber_orientation": along(20.0, 20.0)}))
    mesh = write_station(blade, 0.8, "one", tmp_path)
    assert mesh.bands["skin"].angle_deg == 20.0
    assert mesh.bands["skin-pressure"].angle_deg == -20.0
    nodes = np.array(mesh.nodes)
    for cell, region in zip(mesh.cells, mesh.regions, strict=True):
        if region.startswith("skin"):
            assert (nodes[list(cell), 1].mean() < 0.0) == (region == "skin-pressure")
    description = str(tmp_path / "one.toml")
    assert main(["section", description, "--check", "--out", str(tmp_path / "s")]) == 0


def test_symmetric_fibres_couple_bending_with_twist_not_extension(fenicsx, tmp_path):
    angle = {"fiber_orientation": along(20.0, 20.0)}
    blade = with_layers(tmp_path, (0, angle), (4, angle), (3, {"thickness": along(0.0, 0.0)}))
    out = tmp_path / "out"
    assert main(["blade", str(blade.file), "--at", "0.8", *WORDS[2:], "-o", str(out)]) == 0
    K = matrix(rows_of(out / "blade.csv")[0], "K")
    scaled = K / np.sqrt(np.outer(np.diag(K), np.diag(K)))
    assert scaled[0, 1] > 0.1  # pulled, it shears to the leading edge
    assert scaled[3, 4] < -0.1
    assert abs(scaled[0, 3]) < 1e-6


def mirrored(table):
    """Points in the other sense: over the pressure side first."""
    for airfoil in table["airfoils"]:
        xy = airfoil["coordinates"]
        xy |= {key: xy[key][::-1] for key in "xy"}


def test_the_sense_of_points_does_not_matter(tmp_path, blade):
    other = read_blade(write_blade(tmp_path, wrong(lambda b, t: mirrored(t))))
    for r in (0.0, 0.3, 1.0):
        np.testing.assert_allclose(contour(other, r), contour(blade, r), atol=1e-12)


def test_a_layer_around_the_trailing_edge_is_on_both_sides(tmp_path):
    def change(blade, table):
        structure = blade["structure"]
        structure["anchors"].append(anchor("edge", 0.94, 0.05))
        structure["layers"].insert(1, layer("edge", "glass", 0.003))

    blade = read_blade(write_blade(tmp_path, wrong(change)))
    mesh = write_station(blade, 0.3, "one", tmp_path)
    perimeter = float(lengths_along(contour(blade, 0.3))[-1])
    found = areas(mesh)
    for name, share in (("edge", 0.06), ("edge-suction", 0.05)):
        assert found[name] == pytest.approx(0.003 * share * perimeter, rel=0.15), name


@pytest.mark.parametrize("count", [0, 3])
def test_any_number_of_webs(tmp_path, count):
    def change(blade, table):
        structure = blade["structure"]
        structure["webs"], structure["layers"] = [], structure["layers"][:5]
        for k in range(count):
            place = anchor(f"web-{k}", 0.2 + 0.08 * k, 0.8 - 0.08 * k)
            ends = {key: place[key] for key in ("start_nd_arc", "end_nd_arc")}
            structure["webs"].append({"name": f"web-{k}", **ends})  # without anchors of its own
            structure["layers"].append(
                {"name": f"skin-{k}", "material": "glass", "web": f"web-{k}"}
                | {"thickness": along(0.004, 0.004)}  # a layer of a web needs no arcs
            )

    blade = read_blade(write_blade(tmp_path, wrong(change)))
    for r in (0.0, 0.3, 0.9):
        mesh = write_station(blade, r, "one", tmp_path)
        edges = {
            tuple(sorted(end))
            for cell in mesh.cells
            for end in zip(cell, [*cell[1:], cell[0]], strict=True)
        }
        assert len(mesh.nodes) - len(edges) + len(mesh.cells) == 1 - (count + 1)
