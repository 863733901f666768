"""Blades as files have them: rules of places, YAML, units, stations that fail, own matrices."""

import csv
import re
import shlex

import numpy as np
import pytest
from samples.blade_samples import (
    along,
    anchor,
    areas,
    blade_table,
    circle,
    layer,
    symmetric,
    write_blade,
)

from plymotion.solver.__main__ import main
from plymotion.solver.extras.blade.analysis import thin_masses
from plymotion.solver.extras.blade.shape import contour, edge_angle
from plymotion.solver.extras.blade.station import write_station
from plymotion.solver.extras.blade.windio import read_blade
from plymotion.solver.math.laws import lengths_along
from plymotion.solver.report.section.codes import read_results

pytestmark = pytest.mark.usefixtures("one_fenicsx")
PLACES = [0.1, 0.3, 0.55, 0.8, 1.0]
PLANE = {"anchor_curve": "reference_axis", "anchors_nd_grid": [0.0, 1.0], "rotation": 0.0}


def blade_with(tmp_path, change):
    table = blade_table()
    change(table["components"]["blade"], table)
    return write_blade(tmp_path, table)


def checked(file, tmp_path, at="0.3,0.8"):
    return main(["blade", str(file), "--at", at, "-o", str(tmp_path / "out"), "--check"])


def widths(blade, name, r):
    """Width of a layer [m], and its middle as an arc."""
    (found,) = (one for one in blade.layers if one.name == name)
    start, end = found.start.at(r), found.end.at(r)
    return (end - start) * lengths_along(contour(blade, r))[-1], 0.5 * (start + end)


@pytest.mark.parametrize("dummy", [(0.0, 1.0), (0.1, 0.9), (0.5, 0.5), None], ids=str)
def test_a_width_holds_over_numbers_that_are_not_its_result(tmp_path, dummy):
    """A strip of 0.3 m at the trailing edge, and one about a midpoint."""

    def change(blade, _):
        ends = {} if dummy is None else anchor("", *dummy)
        edge, cap = ({**ends, "name": name} for name in ("edge", "cap"))
        edge |= {
            "end_nd_arc": along(1.0, 1.0),
            "width": {**along(0.3, 0.3), "defines": ["start_nd_arc"]},
        }
        cap |= {"midpoint_nd_arc": along(0.3, 0.3)}
        cap["width"] = {**along(0.4, 0.2), "defines": ["start_nd_arc", "end_nd_arc"]}
        blade["structure"]["anchors"] += [edge, cap]
        blade["structure"]["layers"] += [layer("edge", "glass", 0.003), layer("cap", "foam", 0.003)]

    blade = read_blade(blade_with(tmp_path, change))
    for r in PLACES:
        assert widths(blade, "edge", r)[0] == pytest.approx(0.3, rel=1e-3)
        width, middle = widths(blade, "cap", r)
        assert width == pytest.approx(0.4 - 0.2 * r, rel=1e-3)
        assert middle == pytest.approx(0.3, abs=1e-9)


def test_a_layer_of_a_width_has_its_area(tmp_path):
    def change(blade, _):
        rule = {**anchor("strip", 0.0, 1.0), "midpoint_nd_arc": along(0.2, 0.2)}
        rule["width"] = {**along(0.25, 0.25), "defines": ["start_nd_arc", "end_nd_arc"]}
        blade["structure"]["anchors"].append(rule)
        blade["structure"]["layers"].insert(1, layer("strip", "glass", 0.004))

    mesh = write_station(read_blade(blade_with(tmp_path, change)), 0.55, "one", tmp_path)
    assert areas(mesh)["strip"] == pytest.approx(0.25 * 0.004, rel=0.02)


@pytest.mark.parametrize("side", ["suction", "pressure"])
def test_a_plane_along_the_blade_is_met_where_the_file_says(tmp_path, side):
    """0.15 m behind the reference axis in root axes: the section is turned by the twist."""

    def change(blade, _):
        plane = {"side": side, "defines": ["midpoint_nd_arc"], "plane_type1": PLANE}
        rule = {
            **anchor("cap", 0.0, 1.0),
            "plane_intersection": {**plane, "offset": along(0.15, 0.15)},
        }
        rule["width"] = {**along(0.1, 0.1), "defines": ["start_nd_arc", "end_nd_arc"]}
        blade["structure"]["anchors"].append(rule)
        blade["structure"]["layers"].append(layer("cap", "foam", 0.003))

    blade = read_blade(blade_with(tmp_path, change))
    for r in PLACES:
        _, middle = widths(blade, "cap", r)
        points = contour(blade, r)
        s = lengths_along(points)
        x2, x3 = (np.interp(middle * s[-1], s, points[:, k]) for k in (0, 1))
        twist = np.radians(blade.twist.at(r))
        assert -np.cos(twist) * x2 - np.sin(twist) * x3 == pytest.approx(0.15, abs=2e-3)
        assert (middle < 0.5) == (side == "suction")


@pytest.mark.parametrize(("rule", "unit"), [("offset_arc", None), ("offset_nd_arc", 1.0)])
def test_offsets_from_another_anchor(tmp_path, rule, unit):
    def change(blade, _):
        to = {"name": "cap-s", "handle": "end_nd_arc"}
        given = {**anchor("next", 0.0, 0.0), "end_nd_arc": along(0.5, 0.5)}
        given[rule] = {**along(0.05, 0.05), "anchor": to, "defines": "start_nd_arc"}
        blade["structure"]["anchors"].append(given)
        blade["structure"]["layers"].append(layer("next", "foam", 0.003))

    blade = read_blade(blade_with(tmp_path, change))
    for r in PLACES:
        perimeter = unit or lengths_along(contour(blade, r))[-1]
        assert blade.layers[-1].start.at(r) == pytest.approx(0.36 + 0.05 / perimeter, abs=1e-4)


@pytest.mark.provokes("rule-differs")
def test_numbers_that_are_not_those_of_their_rule_are_named(tmp_path, capsys):
    rule = {**anchor("cap-x", 0.2, 0.3), "midpoint_nd_arc": along(0.25, 0.25)}
    rule["width"] = {**along(0.9, 0.9), "defines": ["start_nd_arc", "end_nd_arc"]}

    def change(blade, _):
        blade["structure"]["anchors"].append(rule)
        blade["structure"]["layers"].append(layer("cap-x", "foam", 0.003))

    file = blade_with(tmp_path, change)
    assert checked(file, tmp_path) == 0
    told = capsys.readouterr().err
    code = "rule-differs"
    assert f"warning [{code}] {file}: structure.anchors.cap-x.start_nd_arc: width gives " in told
    # Numbers within 1 % of the arc are the result of the rule on a contour of other points.
    perimeter = lengths_along(contour(read_blade(file), 0.3))[-1]
    half = float(0.45 / perimeter)
    rule |= {"start_nd_arc": {"grid": [0.3], "values": [0.25 - half + 0.008]}}
    rule |= {"end_nd_arc": {"grid": [0.3], "values": [0.25 + half + 0.008]}}
    assert read_blade(blade_with(tmp_path, change)).differences == ()


@pytest.mark.parametrize(
    ("rule", "words"),
    [
        (
            {"width": {**along(0.3, 0.3), "defines": ["start_nd_arc", "end_nd_arc"]}},
            "midpoint_nd_arc",
        ),
        ({"width": {**along(-0.3, 0.3), "defines": ["end_nd_arc"]}}, "widths of 0 or more"),
        (
            {"width": {**along(0.3, 0.3), "defines": ["end"]}},
            "width.defines: expected start_nd_arc",
        ),
        (
            {"start_nd_arc": {"anchor": {"name": "odd", "handle": "start_nd_arc"}}},
            "defined by its own place",
        ),
        (
            {
                "plane_intersection": {
                    "side": "top",
                    "defines": ["start_nd_arc"],
                    "plane_type1": PLANE,
                }
            },
            "side: expected suction, pressure or both",
        ),
    ],
)
def test_rules_that_cannot_be_evaluated_are_named(tmp_path, capsys, rule, words):
    def change(blade, _):
        blade["structure"]["anchors"].append({**anchor("odd", 0.0, 1.0), **rule})
        blade["structure"]["layers"].append(layer("odd", "foam", 0.003))

    file = blade_with(tmp_path, change)
    assert checked(file, tmp_path) == 2
    message = capsys.readouterr().err
    assert words in message
    assert f"{file}: structure.anchors.odd" in message


def test_airfoils_of_one_thickness_are_blended_along_the_span(tmp_path):
    def change(blade, table):
        thick = symmetric(0.3)
        table["airfoils"] += [
            {"name": "round-2", "rthick": 1.0, "coordinates": circle()},
            {"name": "other", "rthick": 0.24, "coordinates": thick},
        ]
        blade["outer_shape"]["airfoils"] = [
            {"name": name, "spanwise_position": place}
            for name, place in (("round", 0.0), ("round-2", 0.1), ("thin", 0.5), ("other", 1.0))
        ]

    blade = read_blade(blade_with(tmp_path, change))
    for r, height in ((0.5, 0.24), (0.75, 0.27), (1.0, 0.3)):
        assert np.ptp(contour(blade, r)[:, 1]) / blade.chord.at(r) == pytest.approx(
            height, rel=0.01
        )
    plain = read_blade(write_blade(tmp_path))
    np.testing.assert_allclose(contour(blade, 0.05), contour(plain, 0.05), atol=1e-12)


@pytest.mark.parametrize("r", np.linspace(0.82, 0.98, 5).round(3).tolist())
def test_webs_as_thick_as_columns_are_wide(tmp_path, r):
    """Feet whose widths on both sides are rounded to different numbers of columns."""

    def change(blade, _):
        blade["structure"]["anchors"][-1] |= anchor("web", 0.2, 0.64)
        blade["structure"]["layers"][6]["thickness"] = along(0.019, 0.022, 0.021)

    mesh = write_station(read_blade(blade_with(tmp_path, change)), r, "one", tmp_path)
    assert {"web-core", "web-skin"} <= set(mesh.regions)


IMPOSSIBLE = [
    (
        lambda b, t: b["structure"]["layers"][3].update(thickness=along(0.01, -0.01)),
        "layers[3].thick",
    ),
    (
        lambda b, t: b["structure"]["layers"][1].update(thickness=along(20.0, 20.0)),
        "expected metres",
    ),
    (
        lambda b, t: b["structure"]["anchors"][1].update(end_nd_arc=along(0.28, 0.28)),
        "cap-s begins at 0.28 and ends at 0.28",
    ),
    (lambda b, t: b["outer_shape"].update(twist=along(573.0, 0.0)), "degrees from -90 to 90"),
    (lambda b, t: b["outer_shape"].update(rthick=along(100.0, 24.0)), "thicknesses over the chord"),
    (
        lambda b, t: b["outer_shape"]["chord"].update(grid=[0.0, 10.0, 20.0]),
        "expected 0 at the root",
    ),
    (lambda b, t: b["reference_axis"].update(z=along(0.0, 0.0)), "two rising coordinates"),
    (lambda b, t: b["outer_shape"].update(section_offset_y=along(1e9, 1e9)), "expected metres"),
    (lambda b, t: b["outer_shape"].update(chord=along(1.7e308, 1.0)), "finite ones, up to 1e+30"),
    (lambda b, t: b["outer_shape"].update(chord=along(10**400, 1.0)), "expected numbers"),
    (
        lambda b, t: t["airfoils"][1]["coordinates"]["y"].__setitem__(30, 1e18),
        "shares of the chord",
    ),
    (lambda b, t: b["structure"].update(layers=[]), "structure.layers: none"),
]


@pytest.mark.parametrize(("change", "words"), IMPOSSIBLE, ids=[words for _, words in IMPOSSIBLE])
def test_what_cannot_be_is_refused(tmp_path, capsys, change, words):
    file = blade_with(tmp_path, change)
    assert checked(file, tmp_path) == 2
    message = capsys.readouterr().err
    assert words in message
    assert message.startswith(f"error: {file}: ")
    assert not (tmp_path / "out").exists()


def in_millimetres(blade, _):
    for key in ("chord", "section_offset_y"):
        blade["outer_shape"][key]["values"] = [1e3 * x for x in blade["outer_shape"][key]["values"]]
    blade["reference_axis"]["z"] = along(0.0, 20e3)


UNLIKE = [
    (
        lambda b, t: t["materials"][0].update(E=[140.0, 9.0, 9.0], G=[5.0, 5.0, 4.0]),
        "material glass has E = 140 Pa",
    ),
    (
        lambda b, t: t["materials"][1].update(E=98.46e9),
        "material foam has E = 9.846e+10 Pa and rho = 100 kg/m3",
    ),
    (lambda b, t: t["materials"][1].update(rho=0.1), "material foam has E = "),
    (in_millimetres, "reference_axis.z.values: a blade of 20000 m; expected metres"),
    (lambda b, t: b["reference_axis"].update(z=along(0.0, 2.0)), "chord.values: up to 2 m"),
    (lambda b, t: b["outer_shape"].update(twist=along(60.0, 0.0)), "twist.values: up to 60"),
    (
        lambda b, t: t["materials"][1].update(G=50e9),
        "materials.foam.G = 5e+10 Pa: an isotropic material of this E and nu has 5e+07 Pa",
    ),
    (lambda b, t: t["materials"][1].update(nu=0.5), "materials.foam.nu = 0.5"),
    (
        lambda b, t: t["materials"][0].update(E=[14e9] * 3, nu=[0.533] * 3),
        "materials.glass.nu = [0.533, 0.533, 0.533]: no elastic material",
    ),
    (lambda b, t: t["materials"][2].update(E=4e6), "materials.adhesive: E is below 1e+08 Pa"),
    (
        lambda b, t: b["outer_shape"]["rthick"].update(values=[1.0, 1.0, 0.24, 0.1]),
        "outer_shape.rthick.values: 0.1 to 1, but airfoils from 0.2",
    ),
    (lambda b, t: t["airfoils"][1].update(rthick=0.3), "airfoils.thin.rthick: 0.3, but its coord"),
]


@pytest.mark.provokes("unlike-a-blade")
@pytest.mark.parametrize(("change", "words"), UNLIKE, ids=[words for _, words in UNLIKE])
def test_what_no_blade_has_is_a_finding(tmp_path, capsys, change, words):
    file = blade_with(tmp_path, change)
    assert checked(file, tmp_path) == 0
    code = "unlike-a-blade"
    lines = [one for one in capsys.readouterr().err.splitlines() if code in one]
    assert all(line.startswith(f"warning [{code}] {file}: ") for line in lines)
    assert any(words in line for line in lines)
    assert read_blade(write_blade(tmp_path)).doubtful == ()


@pytest.mark.provokes("no-room")
def test_layers_without_room_are_a_finding(tmp_path, capsys):
    def change(blade, _):
        blade["structure"]["layers"][0]["thickness"] = along(0.1, 0.1)

    assert checked(blade_with(tmp_path, change), tmp_path) == 0
    code = "no-room"
    assert f"warning [{code}] station r = 0.8: " in capsys.readouterr().err


def test_what_finds_no_room_is_what_the_mesh_lacks(tmp_path):
    """Thick skins at a sharp trailing edge: also what is cut away there counts."""

    def change(blade, _):
        blade["structure"]["layers"][0]["thickness"] = along(0.02, 0.02)
        blade["structure"]["layers"] = [
            one for one in blade["structure"]["layers"] if one["name"] in ("skin", "inner")
        ]

    blade = read_blade(blade_with(tmp_path, change))
    mesh = write_station(blade, 0.8, "one", tmp_path)
    points = contour(blade, 0.8)
    # Of an inner layer, the arc is shorter by the turn of the contour times its depth.
    turn = np.pi + edge_angle(points)
    arc = float(lengths_along(points)[-1])
    full = 0.02 * (arc - turn * 0.01) + 0.002 * (arc - turn * 0.021)
    has = sum(area for name, area in areas(mesh).items() if name != "trailing-edge")
    assert 1.0 - has / full == pytest.approx(mesh.removed, abs=0.006)
    assert mesh.removed > 0.03


def test_an_adhesive_with_a_placeholder_does_not_open_the_section(fenicsx, tmp_path):
    """Files have 4.56 MPa for 4.56 GPa: GJ of the section that is free to warp."""
    GJ = []
    for E in (4.56e9, 4.56e6):
        table = blade_table()
        table["materials"][2]["E"] = E
        words = ["--at", "0.8", "--no-estimate", "--quiet", "-o", str(tmp_path / f"{E:g}")]
        assert main(["blade", str(write_blade(tmp_path, table)), *words]) == 0
        K = read_results(tmp_path / f"{E:g}/sections/r08000/r08000.vtkhdf").K
        GJ.append(1.0 / np.linalg.inv(K)[3, 3])
    assert GJ[1] == pytest.approx(GJ[0], rel=0.03)


def test_keys_of_all_layers_are_one_line(tmp_path, capsys):
    def change(blade, _):
        for entry in blade["structure"]["layers"] + blade["structure"]["webs"]:
            entry |= {"start_nd_grid": 0.0, "end_nd_grid": 1.0}

    assert checked(blade_with(tmp_path, change), tmp_path) == 0
    (line,) = (one for one in capsys.readouterr().err.splitlines() if "start_nd_grid" in one)
    assert "structure.layers[0] and 7 more" in line


def test_the_advice_for_files_of_windio_1_is_a_command_that_works(tmp_path, capsys):
    """Its converter makes the folder of the output, which a name without one does not have."""
    file = blade_with(tmp_path, lambda blade, _: blade.update(internal_structure_2d_fem={}))
    odd = file.rename(tmp_path / "my old's.yaml")
    assert checked(odd, tmp_path) == 2
    message = capsys.readouterr().err
    assert "pip install windIO scipy" in message
    words = re.search(r"then (windio_converter .*\.yaml) ", message).group(1)
    _, _, source, _, target = shlex.split(words)
    assert source == str(odd)
    assert target == "./my old's-2.yaml"


def test_ends_that_the_converter_of_windio_leaves_open_are_those_of_the_own_anchor(tmp_path):
    def change(blade, _):
        rule = {**anchor("edge", 0.0, 1.0), "width": {**along(0.3, 0.3), "defines": ["end_nd_arc"]}}
        open_end = {"anchor": {"name": "not_defined", "handle": "not_defined"}}
        blade["structure"]["anchors"].append(rule)
        blade["structure"]["layers"].append(layer("edge", "glass", 0.003, end_nd_arc=open_end))

    assert widths(read_blade(blade_with(tmp_path, change)), "edge", 0.5)[0] == pytest.approx(
        0.3, rel=1e-3
    )


def test_a_bad_station_does_not_stop_the_others(fenicsx, tmp_path, capsys):
    def change(blade, _):
        start = {"grid": [0.0, 0.4, 1.0], "values": [0.32, 0.001, 0.32]}
        blade["structure"]["anchors"][-1]["start_nd_arc"] = start

    file, out = blade_with(tmp_path, change), tmp_path / "out"
    words = ["blade", str(file), "--at", "0,0.4,1", "--quiet", "--no-estimate", "-o", str(out)]
    assert main([*words, "--to", "beamdyn"]) == 2
    told = capsys.readouterr().err
    assert f"error: {file}: station r = 0.4: structure.webs: web: its foot covers" in told
    assert (
        "r = 0.4: without these stations the blade is another one; not written: beam.csv, " in told
    )
    with (out / "blade.csv").open(newline="") as stream:
        assert [row["r"] for row in csv.DictReader(stream)] == ["0.0", "1.0"]
    assert not [*out.glob("beam*"), *out.glob("case*"), *out.glob("blade_beamdyn*")]


@pytest.mark.provokes("differs-from-file")
def test_stations_are_compared_with_the_matrices_of_the_file(fenicsx, tmp_path, capsys):
    """Half the mass and a third of EA at the tip; K44 and K55 in either order are no difference."""
    file, out = write_blade(tmp_path), tmp_path / "out"
    words = ["--at", "0,1", "--quiet", "--no-estimate", "-o", str(out)]
    assert main(["blade", str(file), *words]) == 0
    with (out / "blade.csv").open(newline="") as stream:
        rows = list(csv.DictReader(stream))
    given = {
        key: [float(row[name]) for row in rows]
        for key, name in (
            ("mass", "mass_kg_m"),
            ("K33", "K11"),
            ("K34", "K15"),
            ("K35", "K16"),
            ("K44", "K55"),
            ("K55", "K66"),
            ("K45", "K56"),
            ("K66", "K44"),
        )
    }
    grid = {"grid": [0.0, 1.0]}

    def with_own(change):
        values = {key: list(pair) for key, pair in given.items()}
        change(values)
        inertia = {**grid, "mass": values.pop("mass")}
        own = {"inertia_matrix": inertia, "stiffness_matrix": {**grid, **values}}

        def into(blade, _):
            blade["structure"]["elastic_properties"] = own

        capsys.readouterr()
        assert main(["blade", str(blade_with(tmp_path, into)), *words]) == 0
        return [one for one in capsys.readouterr().err.splitlines() if "differs-from-file" in one]

    def swapped(values):
        values["K44"], values["K55"] = values["K55"], values["K44"]
        values["K34"], values["K35"] = values["K35"], values["K34"]

    assert with_own(swapped) == []

    def less(values):
        values["mass"][1] *= 0.5
        values["K33"][1] /= 3.0
        values["K34"][1] = values["K35"][1] = 0.0

    line, whole = with_own(less)
    code = "differs-from-file"
    assert line.startswith(f"warning [{code}] {file}: station r = 1: mass ")
    assert re.search(
        r"mass [\d.]+ kg/m, elastic_properties [\d.]+ \(x 2\); EA \S+ N, .* \(x 3\)", line
    )
    # Two stations: the tip has half of its mass.
    root, tip = given["mass"]
    ratio = (root + tip) / (root + 0.5 * tip)
    assert whole.startswith(
        f"warning [{code}] {file}: the blade has {10.0 * (root + tip):.5g} kg, "
    )
    assert f"(x {ratio:.3f}); thickness times arc of the outer surface" in whole


def test_masses_of_thin_walled_codes_at_a_round_station(tmp_path):
    """A circle of 1 m: all arcs are those of the outer surface, the web is a chord."""
    arc, web = 2.0 * np.pi, 2.0 * np.sin(0.36 * np.pi)
    shell = 1900.0 * (0.006 + 0.02 * 0.16) + 100.0 * 0.015 * 0.23
    expected = shell * arc + (1900.0 * 0.003 + 100.0 * 0.012) * web
    found = thin_masses(read_blade(write_blade(tmp_path)), [0.0, 0.05])
    np.testing.assert_allclose(found, expected, rtol=5e-4)
