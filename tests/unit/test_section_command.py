"""Batch lists, studies, shares, options and text output, without FEniCSx."""

import argparse
import csv
import json
import re
from pathlib import Path

import numpy as np
import pytest

from plymotion.solver.commands.bodies.section import read_list
from plymotion.solver.errors import InputError
from plymotion.solver.inputs.section.study import changed, described_spec
from plymotion.solver.package.common.design import Derivative
from plymotion.solver.package.common.plain_data import by_mesh, check_form, mesh_key, shard, share
from plymotion.solver.package.specification import DesignTarget
from plymotion.solver.report.section.codes import SectionResults
from plymotion.solver.report.section.section_text import (
    Row,
    section_json,
    section_text,
    summary_text,
    write_summary,
)
from plymotion.solver.workers.description_results import Entry, entries_of
from plymotion.solver.workers.launch import SpecificationQueue


def results(name: str = "box", **changes: object) -> SectionResults:
    K = np.diag([1.4e6, 9.0e4, 4.0e4, 50.0, 120.0, 430.0])
    K[0, 3] = K[3, 0] = -2.5e2
    K[0, 1] = K[1, 0] = 1e-8  # round-off
    M = np.diag([0.15, 0.15, 0.15, 4.5e-5, 1.5e-5, 3.0e-5])
    error = np.full((6, 6), 1e-9)
    error[3, 3] = 0.01
    values = {
        "K": K,
        "M": M,
        "error_estimate": error,
        "shear_centre": np.zeros(2),
        "tension_centre": np.array([1.25e-3, 0.0]),
        "mass_centre": np.array([0.0, 1e-17]),
        "warnings": ({"code": "sliver-elements", "message": "two of them"},),
        "provenance": {"dofs": 6021, "seconds": 0.53},
    }
    return SectionResults(name=name, **{**values, **changes})  # type: ignore[arg-type]


def test_screen_shows_names_units_and_no_round_off() -> None:
    text = section_text(results(), "a box")
    lines = text.splitlines()
    assert max(map(len, lines)) <= 100
    assert lines[0] == "box: a box"
    assert re.split(r"\s{2,}", lines[3].strip()) == [
        *("extension", "shear 2", "shear 3", "twist", "bending 2", "bending 3")
    ]
    row = next(line for line in lines if line.startswith("M1 [N m]"))
    assert row.removeprefix("M1 [N m]").split() == [
        "-2.50000e+02",
        "0",
        "0",
        "5.00000e+01",
        "0",
        "0",
    ]
    assert "1.00000e-08" not in text
    assert "Tension centre  x2 = 0.00125 m, x3 = 0 m" in text
    assert "Mass centre     x2 = 0 m, x3 = 0 m" in text
    assert "Error estimate  2.0e-04 of itself in K44 (twist)" in text
    assert "warning [sliver-elements] two of them" in text


def test_error_off_the_diagonal_is_named_by_both_strains() -> None:
    error = np.zeros((6, 6))
    error[3, 0] = error[0, 3] = 1.0
    text = section_text(results(error_estimate=error))
    assert "of sqrt(K11 K44) in K14 (extension - twist)" in text
    assert "not requested" in section_text(results(error_estimate=None))


def test_steps_of_a_refinement_are_shown() -> None:
    steps = [
        {"refine": 0, "dofs": 1500, "error": 3e-3, "seconds": 0.1},
        {"refine": 1, "dofs": 6021, "error": 8e-4, "seconds": 0.53},
    ]
    text = section_text(results(provenance={"refinements": steps}))
    assert "1500 unknowns   error 3.0e-03   after 0.10 s" in text


@pytest.mark.parametrize("code", ["vabs", "becas", "anba4", "beamdyn"])
def test_orders_of_other_codes(code: str) -> None:
    ours, theirs = section_json(results()), section_json(results(), code)
    extension = theirs["order"].index("extension")
    twist = theirs["order"].index("twist")
    assert theirs["K"][extension][extension] == pytest.approx(1.4e6)
    assert abs(theirs["K"][extension][twist]) == pytest.approx(2.5e2)
    assert theirs["error_estimate"][twist][twist] == pytest.approx(0.01)
    assert np.min(theirs["error_estimate"]) >= 0.0
    assert theirs["shear_centre"] == ours["shear_centre"]
    assert json.loads(json.dumps(theirs)) == theirs
    assert max(map(len, section_text(results(), "", code).splitlines())) <= 100


def test_summary_holds_every_section(tmp_path: Path) -> None:
    rows = [
        Row("box-a", "built", {"laminates.wall.angles_deg": [0, 15]}, results()),
        Row("box-b", "failed", {"laminates.wall.angles_deg": [0, 91]}, None, "91: too much"),
    ]
    table, numbers = write_summary(tmp_path, "summary", rows)
    with table.open(newline="") as stream:
        first, second = csv.DictReader(stream)
    assert [key for key in first if key[0] == "K" and key[1:].isdigit()] == [
        f"K{i}{j}" for i in range(1, 7) for j in range(i, 7)
    ]
    assert float(first["K14"]) == -2.5e2
    assert float(first["error_estimate_scaled"]) == pytest.approx(2e-4)
    assert first["laminates.wall.angles_deg"] == "[0, 15]"
    assert first["warnings"] == "sliver-elements"
    assert (second["status"], second["K11"], second["error"]) == ("failed", "", "91: too much")
    found = json.loads(numbers.read_text())
    assert found["box-a"]["K"][0][0] == 1.4e6
    assert found["box-b"]["error"] == "91: too much"
    text = summary_text(rows)
    assert max(map(len, text.splitlines())) <= 100
    assert "failed" in text


def touch(folder: Path, *names: str) -> None:
    for name in names:
        (folder / name).write_text("format = 1\n")


def test_lists_by_folder_pattern_and_text(tmp_path: Path) -> None:
    touch(tmp_path, "box.toml", "tube.toml")
    assert [e.name for e in read_list(str(tmp_path))] == ["box", "tube"]
    assert [e.name for e in read_list(str(tmp_path / "b*.toml"))] == ["box"]
    (tmp_path / "list.txt").write_text("# all\ntube.toml  # round\n\nbox.toml\n")
    marked = tmp_path / "what?[1]"  # no pattern: the folder is there
    marked.mkdir()
    (marked / "list.txt").write_text("../box.toml\n")
    assert [e.name for e in read_list(str(marked / "list.txt"))] == ["box"]
    assert [e.file for e in read_list(str(tmp_path / "list.txt"))] == [
        tmp_path / "tube.toml",
        tmp_path / "box.toml",
    ]


def test_lists_that_name_nothing(tmp_path: Path) -> None:
    for place in (tmp_path, tmp_path / "*.toml", tmp_path / "none.txt", tmp_path / "none.toml"):
        with pytest.raises(InputError, match=r"none|names no section"):
            read_list(str(place))


def test_two_files_of_one_name_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="would overwrite those of"):
        entries_of([tmp_path / "a" / "box.toml", tmp_path / "b" / "box.toml"])


def study(folder: Path, text: str) -> list[Entry]:
    touch(folder, "box.toml", "tube.toml")
    (folder / "study.toml").write_text("format = 1\n" + text)
    return read_list(str(folder / "study.toml"))


def test_study_combines_sweeps(tmp_path: Path) -> None:
    sweeps = """
    sections = ["box.toml", "tube.toml"]
    [[sweep]]
    key = "laminates.wall.angles_deg"
    values = [[0, 0], [15, -15], [30, -30]]
    [[sweep]]
    key = "mesh.height"
    values = [0.01, 0.02, 0.03]
    """
    product = study(tmp_path, sweeps)
    assert [e.name for e in product[:2]] == ["box-1", "box-2"]
    assert len(product) == 18
    assert product[1].changes == {"laminates.wall.angles_deg": [0, 0], "mesh.height": 0.02}
    zipped = study(tmp_path, 'combine = "zip"\n' + sweeps)
    assert len(zipped) == 6
    assert zipped[1].changes == {"laminates.wall.angles_deg": [15, -15], "mesh.height": 0.02}
    assert zipped[-1].file == tmp_path / "tube.toml"


def test_study_with_names_and_csv(tmp_path: Path) -> None:
    (tmp_path / "angles.csv").write_text("name, 1, 2\nsoft, 45, -45\nstiff, 0\n")
    entries = study(
        tmp_path,
        """
        sections = ["box.toml"]
        [[sweep]]
        key = "laminates.wall.angles_deg"
        csv = "angles.csv"
        """,
    )
    assert [(e.name, e.changes["laminates.wall.angles_deg"]) for e in entries] == [
        ("box-soft", [45.0, -45.0]),
        ("box-stiff", [0.0]),
    ]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('sections = ["box.toml"]\nsweeps = []', "sweeps: unknown key; did you mean 'sweep'"),
        ("sections = []", "sections"),
        ('sections = ["box.toml"]\n[[sweep]]\nkey = "a"', "either `values` or `csv`"),
        (
            'sections = ["box.toml"]\ncombine = "zip"\n[[sweep]]\nkey = "a"\nvalues = [1]\n'
            '[[sweep]]\nkey = "b"\nvalues = [1, 2]',
            r"as many values in each sweep, found \[1, 2\]",
        ),
        (
            'sections = ["box.toml"]\n[[sweep]]\nkey = "a"\nvalues = [1, 2]\nnames = ["x", "x"]',
            'the name "x" occurs 2 times',
        ),
        ('sections = ["box.toml"]\n[[sweep]]\nkey = "a"\ncsv = "no.csv"', "no such table"),
        (
            'sections = ["box.toml"]\n[[sweep]]\nkey = "a"\nvalues = [1]\nnames = ["../x"]',
            r"sweep.0.names.0 = ",
        ),
        ('sections = ["box.toml"]\nmesh = 1', "this is a section description"),
    ],
)
def test_wrong_studies(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        study(tmp_path, text)


def test_changes_reach_into_tables_and_lists() -> None:
    table = {"laminates": {"wall": {"plies": [{"angle_deg": 0}, {"angle_deg": 0}]}}}
    changes = {"laminates.wall.plies.1.angle_deg": 30, "title": "new"}
    new = changed(table, changes, Path("box.toml"))
    assert new["laminates"]["wall"]["plies"] == [{"angle_deg": 0}, {"angle_deg": 30}]
    assert new["title"] == "new"
    assert table["laminates"]["wall"]["plies"][1] == {"angle_deg": 0}


@pytest.mark.parametrize(
    ("key", "message"),
    [
        ("laminates.wal.angles_deg", r"box.toml: laminates.wal: .*did you mean 'wall'"),
        ("laminates.wall.angles_deg.1", "laminates.wall.angles_deg: has no 1"),
        ("laminates.wall.angles_deg.0.x", "laminates.wall.angles_deg.0: has no x"),
        ("laminates.wall.angles_deg.0.x.y", "laminates.wall.angles_deg.0.x: no such table"),
        ("a b", "not a dotted key"),
        ("a = 1\nb", "not a dotted key"),
    ],
)
def test_changes_that_lead_nowhere(key: str, message: str) -> None:
    table = {"laminates": {"wall": {"angles_deg": [0]}}}
    with pytest.raises(InputError, match=message):
        changed(table, {key: 1}, Path("box.toml"))


@pytest.mark.parametrize("n", [1, 2, 3, 7, 20])
def test_shares_make_the_whole(n: int) -> None:
    items = list(range(17))
    parts = [share(items, (k, n)) for k in range(1, n + 1)]
    assert [item for part in parts for item in part] == items
    assert max(map(len, parts)) - min(map(len, parts)) <= 1


@pytest.mark.parametrize("text", ["0/2", "3/2", "2", "a/b", "1/0", "-1/2", "1/2/3"])
def test_wrong_shards(text: str) -> None:
    with pytest.raises(argparse.ArgumentTypeError, match="expected k/N"):
        shard(text)


def test_equal_meshes_stay_together() -> None:
    a, b = {"mesh": {"script": "box", "degree": 2}}, {"mesh": {"degree": 2, "script": "box"}}
    assert mesh_key(a) == mesh_key(b)
    assert by_mesh([(1, "x"), (2, "y"), (3, "x")]) == [[1, 3], [2]]


def test_work_is_shared_by_mesh_and_then_split() -> None:
    one, two = 0, 1
    paths = [[Path(f"a{i}") for i in range(5)], [Path("b0")]]
    queue = SpecificationQueue(paths)
    first = [queue.next(one), queue.next(two), queue.next(two)]
    # The second has done its mesh and takes the far half of the first one's.
    assert first == [Path("a0"), Path("b0"), Path("a3")]
    rest = [queue.next(worker) for worker in (one, two, one, one, two)]
    assert sorted(map(str, filter(None, rest))) == ["a1", "a2", "a4"]
    assert queue.next(one) is None


BOX = """
format = 1
title = "box"
convention = "contour"
mesh = { shape = "box", width = 0.024, height = 0.014 }
[materials.ply]
kind = "orthotropic"
E1 = 142e9
E2 = 9.8e9
E3 = 9.8e9
G12 = 6e9
G13 = 6e9
G23 = 4.8e9
nu12 = 0.42
nu13 = 0.42
nu23 = 0.42
rho = 1600.0
[laminates.wall]
material = "ply"
angles_deg = [30, -30]
ply_thickness = 0.0004
[regions.all]
laminate = "wall"
"""


def test_parameters_move_what_follows_from_them(tmp_path: Path) -> None:
    """An angle moves that of its ply in all walls; a thickness also sizes of the mesh."""
    file = tmp_path / "box.toml"
    file.write_text(BOX)
    asked = {
        "a": {"laminates.wall.angles_deg.1": 2.0},
        "t": {"laminates.wall.ply_thickness": 1.0},
        "E": {"materials.ply.E2": 1.0},
    }
    spec = described_spec(file, {}, "box", tmp_path, asked)
    check_form(spec["design"], dict[str, list[DesignTarget]])  # as the preprocessor does
    plain = described_spec(file, {}, "box", tmp_path)
    assert {key: value for key, value in spec.items() if key != "design"} == plain
    targets = {
        name: {tuple(one["of"]): one["factor"] for one in found}
        for name, found in spec["design"].items()
    }
    walls = ("top", "right", "bottom", "left")
    assert targets["a"] == pytest.approx(
        {("regions", wall, "plies", "1", "angle_deg"): 2.0 for wall in walls}
    )
    assert targets["E"] == pytest.approx({("materials", "ply", "E2"): 1.0})
    sizes = {("mesh", "parameters", f"wall_{wall}"): 2.0 for wall in walls}
    plies = {("regions", w, "plies", i, "thickness"): 1.0 for w in walls for i in "01"}
    found = targets["t"]
    assert {key: found[key] for key in sizes | plies} == pytest.approx(sizes | plies)
    assert {key[1] for key in found.keys() - (sizes | plies).keys()} == {"parameters"}


@pytest.mark.parametrize(
    ("key", "message"),
    [
        ("laminates.wall.angle.1", r"laminates.wall.angle: no such table.*did you mean"),
        ("laminates.wall.material", r"laminates.wall.material = 'ply': expected a number"),
        ("laminates.wall.angles_deg.2", "has no 2"),
        ("laminates.wall.symmetric", "laminates.wall.symmetric = None: expected a number"),
        ("mesh.wall", r"box\.toml: mesh\.wall: changed alone, regions\.all: its 2 plies"),
    ],
)
def test_parameters_that_are_no_numbers(key: str, message: str, tmp_path: Path) -> None:
    file = tmp_path / "box.toml"
    file.write_text(BOX.replace("0.014 }", "0.014, wall = 0.0008 }"))
    with pytest.raises(InputError, match=message):
        described_spec(file, {}, "box", tmp_path, {key: {key: 1.0}})


def test_derivatives_on_the_screen_and_in_json() -> None:
    rate = np.diag([1e4, 0.0, 0.0, 2.5, 0.0, 0.0])
    one = Derivative("a", "angle", (), {"K": rate, "M": 0.01 * np.eye(6)})
    shown = results(design=(one,))
    text = section_text(shown)
    assert "Derivative of K by a, per deg; largest entry 0.05 of sqrt(Kii Kjj)" in text
    assert "0.01 kg/m per deg" in text
    found = section_json(shown)["derivatives"]["a"]
    assert found["K"] == rate.tolist()
    assert found["shear_centre"] == [0.0, 0.0]
    assert "derivatives" not in section_json(results())
